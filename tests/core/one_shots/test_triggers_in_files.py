"""Triggers in scene files: they come back as they were, play as they did, and what is wrong with
one is said with its place."""

import json
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.recording import RecordedFrame, Recording, traced
from haptic_tracing.core.formats.scene.scene_json import read_scene, scene_from_dict, scene_to_dict
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

KNOCK = DecayingSine(120.0, 0.02)
G = 9.81
TRIGGERS = (
    Trigger("times", (0.1, 0.55), (1.0, 0.5), ("", "crate")),
    Trigger("hit"),
    Trigger("passing", object="crate", size=(2.0, 2.0, 0.0), pose=Pose((0, 0, 1.0))),
)


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


def fall():
    """The crate falls freely for 0.515 s, to the ground."""
    height = [0.25 + max(1.30 - G * (n / 24) ** 2 / 2, 0.0) for n in range(25)]
    return Recording(
        24.0,
        0,
        tuple(RecordedFrame(n, {"crate": (0, 0, z, 1, 0, 0, 0)}) for n, z in enumerate(height)),
    )


def test_a_file_keeps_triggers(tmp_path):
    write_export(Export("bells", scene(*TRIGGERS)), tmp_path / "bells.json")
    assert read_scene(tmp_path / "bells.json") == scene(*TRIGGERS)
    assert scene_from_dict(scene_to_dict(scene()), "no.json").sources[0].triggers == ()


def test_what_happens_in_a_file_plays_from_the_file_alone_as_from_its_moments(tmp_path):
    results = list(traced(scene(*TRIGGERS), fall()))
    shots = sorted(
        {shot for result in results for shot in result.shots}, key=lambda shot: shot.onset
    )
    # Given; passed when a free fall is there; given; hit.
    assert [shot.onset for shot in shots] == pytest.approx(
        [0.1, (2 * 0.55 / G) ** 0.5, (2 * 1.3 / G) ** 0.5, 0.55], abs=1e-3
    )
    times = Trigger(
        "times", *zip(*((shot.onset, shot.strength, shot.by) for shot in shots), strict=True)
    )
    write_export(Export("bells", scene(times), recording=fall()), tmp_path / "bells.json")
    export = read_export(tmp_path / "bells.json")
    for first, second in zip(results, traced(export.scene, export.recording), strict=True):
        assert [(s.name, s.amplitude) for s in first.sources] == [
            (s.name, s.amplitude) for s in second.sources
        ]
        if first.block is not None:
            np.testing.assert_allclose(second.block, first.block, atol=1e-12)


def test_the_command_line_plays_the_triggers_of_a_still_scene(tmp_path):
    write_export(Export("bells", scene(TRIGGERS[0])), tmp_path / "bells.json")
    assert (
        main(
            [
                "export",
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
        ("/sources/0/triggers/0/object", {"on": "passing", "object": "nobody", "size": [1, 1, 0]}),
        ("/sources/0/triggers/0", {"on": "passing", "object": "crate"}),
        ("/sources/0/triggers/0/on", {"on": "level"}),
        ("/sources/0/triggers/0/strengths", {"on": "times", "times": [1, 2], "strengths": [1]}),
        ("/sources/0/triggers/0", {"on": "hit", "times": [1]}),
        (
            "/sources/0/triggers/0/pose/rotation",
            {
                "on": "passing",
                "object": "crate",
                "size": [1, 1, 0],
                "pose": {"rotation": [0, 0, 0, 0]},
            },
        ),
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
