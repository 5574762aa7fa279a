"""Triggers in scene files: they come back as they were, play as they did, and what is wrong with
one is said with its place."""

import json
from dataclasses import replace

import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.scene_json import scene_from_dict, scene_to_dict
from haptic_tracing.core.scene.functions import Identity
from haptic_tracing.core.scene.values import (
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
    Trigger,
)
from haptic_tracing.core.signals import DecayingSine
from haptic_tracing.core.signals.wav import WavFile
from written_scenes import read_scene

KNOCK = DecayingSine(120.0, 0.02)
TRIGGERS = (Trigger((0.1, 0.55), (1.0, 0.5)), Trigger((0.3,)))


def scene(*triggers):
    ground = HapticObject(
        "ground",
        0.2,
        0.9,
        Identity(),
        shape=Box((40, 40, 1)),
        pose=Pose((0, 0, -0.5)),
        motion="static",
    )
    crate = HapticObject(
        "crate", 0.3, 0.8, shape=Box((0.5, 0.5, 0.5)), mass=12.0, pose=Pose((0, 0, 1.55))
    )
    bell = Source("bell", "ground", (1.0, 0.0, 0.0), 0.8, signal=KNOCK, triggers=triggers)
    return HapticScene(
        (ground, crate), sources=(bell,), listeners=(Listener("skin", "ground", radius=0.0),)
    )


def test_a_file_keeps_triggers(tmp_path):
    write_export(Export("bells", scene(*TRIGGERS)), tmp_path / "bells.json")
    assert read_scene(tmp_path / "bells.json") == scene(*TRIGGERS)
    assert scene_from_dict(scene_to_dict(scene()), "no.json").sources[0].triggers == ()


def test_the_command_line_plays_the_triggers_of_a_still_scene(tmp_path):
    write_export(Export("bells", scene(TRIGGERS[0])), tmp_path / "bells.json")
    assert (
        main(
            [
                "export",
                "--absolute",
                str(tmp_path / "bells.json"),
                "--to",
                "wav",
                "--out",
                str(tmp_path),
                "--seconds",
                "1",
            ]
        )
        == 0
    )
    (path,) = tmp_path.glob("*.wav")
    wav = WavFile(path.open("rb"))
    expected = 0.8 * KNOCK.sample(0, 4000, wav.rate, 0.1)
    assert wav.read(0, 4000)[:, 0] == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    ("place", "form"),
    [
        ("/sources/0/triggers/0", {}),
        ("/sources/0/triggers/0", {"times": [1], "on": "hit"}),
        ("/sources/0/triggers/0/strengths", {"times": [1, 2], "strengths": [1]}),
        ("/sources/0/triggers/0/strengths/0", {"times": [1], "strengths": [2]}),
    ],
)
def test_what_is_wrong_with_a_trigger_is_said_with_its_place(place, form):
    document = json.loads(json.dumps(scene_to_dict(scene())))
    document["sources"][0]["triggers"] = [form]
    with pytest.raises(FormatError) as error:
        scene_from_dict(document, "wrong.json")
    assert error.value.pointer.startswith(place)


def test_a_signal_without_an_end_is_refused_with_its_place():
    document = json.loads(json.dumps(scene_to_dict(scene())))
    document["sources"][0]["signal"] = {"signal": "noise"}
    with pytest.raises(FormatError) as error:
        scene_from_dict(document, "wrong.json")
    assert error.value.pointer == "/sources/0/signal"
    assert replace(scene().sources[0], triggers=None, signal=None).triggers is None
