"""What a listener's and a source's panel says about mixing, felt live and from a baked track,
against the formulas."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import recording_layout
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.io.frame_scene import scene_of_frame
from haptic_tracing.addon.live_output import handlers, outputs
from haptic_tracing.addon.panels import live_output
from haptic_tracing.addon.panels.listener import HAPTIC_PT_listener
from haptic_tracing.addon.panels.source import HAPTIC_PT_source
from haptic_tracing.addon.session import session
from haptic_tracing.core.formats.scene.scene_json import scene_from_dict, scene_to_dict
from haptic_tracing.core.render.limiter import LOOK_AHEAD
from haptic_tracing.core.render.renderer import sample_index

RATE = 8000
TRACK = 1.6e-5  # a track keeps 16 bits
FRAMES = range(2, 20)


@pytest.fixture
def two_sources(felt, add_empty):
    """The humming box, and a second tone on it that counts twice."""
    empty = add_empty("second", parent=bpy.data.objects["box"])
    source = empty.haptics.source
    source.enabled, source.frequency, source.amplitude, source.priority = True, 35.0, 0.6, 2.0
    bpy.data.objects["box"].haptics.source.amplitude = 0.8
    return felt


def played(scene, plug, connect) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the device gets in `FRAMES`, a row per listener, first live, then from the baked track;
    and `tones`."""
    plug()
    connect()
    sent: list[np.ndarray] = []
    outputs.running()["dualsense"].send = lambda block, _sent=None: sent.append(block)

    def play() -> np.ndarray:
        scene.frame_set(1)
        sent.clear()
        handlers.animation_playback_pre(scene)
        with pytest.MonkeyPatch.context() as without_window:
            without_window.setattr(playback, "is_playing", lambda: True)
            for frame in FRAMES:
                scene.frame_set(frame)
        handlers.animation_playback_post(scene)
        return np.concatenate(sent, axis=1)

    live, each = play(), tones(scene)
    scene.frame_end = FRAMES[-1]
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    scene.haptics.bake.use_track = True
    return live, play(), each


def tones(scene) -> np.ndarray:
    """Either source as the listener "left" gets it, at the samples of `FRAMES`."""
    result = session.result_of(scene)
    seconds = handlers.frame_seconds(scene)
    n = np.arange(sample_index(0.0, RATE), sample_index((FRAMES[-1] - 1) * seconds, RATE))
    row = [listener.name for listener in result.listeners].index("left")
    each = {
        source.name: gain * np.sin(2 * np.pi * frequency * n / RATE)
        for source, gain in zip(result.sources, result.amplitudes[:, row], strict=True)
        for frequency in [{"box": 150.0, "second": 35.0}[source.name]]
    }
    return np.array([each["box"], each["second"]])


def first_frame(scene) -> int:
    """Samples of the first frame, in which sources fade in."""
    return sample_index(handlers.frame_seconds(scene), RATE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formula", "mix"),
    [
        ("s_max * tanh(sum / s_max)", lambda s: 0.5 * np.tanh(s.sum(axis=0) / 0.5)),
        ("0.25 * weighted", lambda s: 0.25 * (s[0] + 2.0 * s[1])),
        (
            "0.5 * strongest + 0.1 * sum",
            lambda s: 0.5 * np.where(abs(s[0]) >= abs(s[1]), s[0], s[1]) + 0.1 * s.sum(axis=0),
        ),
        (
            "max(min(power, 0.3), -0.3)",
            lambda s: np.clip(np.hypot(*s) * np.where(s.sum(axis=0) < 0, -1, 1), -0.3, 0.3),
        ),
        ("0 * sum + log(-1)", lambda s: np.zeros(s.shape[1])),
    ],
)
def test_a_designers_formula_is_felt_live_and_baked(two_sources, plug, connect, formula, mix):
    listener = bpy.data.objects["left"].haptics.listener
    listener.mixing, listener.mixing_expression, listener.s_max = "custom", formula, 0.5
    live, baked, each = played(two_sources, plug, connect)
    begin = first_frame(two_sources)
    sure = np.abs(each.sum(axis=0)) > 1e-9  # where the sum is 0 its sign is a matter of rounding
    expected = np.clip(mix(each), -0.5, 0.5)
    assert np.abs(live[0] - expected)[begin:][sure[begin:]].max() < 1e-9
    assert np.abs(live[1, begin:] - np.clip(each.sum(axis=0), -1, 1)[begin:]).max() < 1e-9, (
        "the other listener adds up as before"
    )
    assert np.abs(live - baked)[:, begin:].max() < TRACK


def test_the_limiter_turns_down_what_would_be_cut(two_sources, plug, connect):
    for name in ("left", "right"):
        bpy.data.objects[name].haptics.listener.s_max = 0.4
    bpy.data.objects["left"].haptics.listener.limiter = True
    live, baked, each = played(two_sources, plug, connect)
    begin, late = first_frame(two_sources), round(LOOK_AHEAD * RATE)
    total = each.sum(axis=0)
    assert np.abs(live).max() <= 0.4 and np.abs(total).max() > 0.4
    assert np.abs(live[1, begin + late :] - np.clip(total, -0.4, 0.4)[begin:-late]).max() < 1e-9, (
        "all listeners stay together"
    )
    share = live[0, begin + late :] / total[begin:-late]
    sure = np.abs(total[begin:-late]) > 1e-3
    assert share[sure].max() <= 1 + 1e-9 and share[sure].min() > 0, "turned down, never bent over"
    assert np.abs(np.diff(share[sure])).max() < 0.1, "smoothly"
    assert np.abs(live - baked)[:, begin:].max() < TRACK
    assert live_output.limiter_seconds(two_sources) == 0.0, "what a track was baked with is in it"
    two_sources.haptics.bake.use_track = False
    two_sources.frame_set(3)
    assert live_output.limiter_seconds(two_sources) == LOOK_AHEAD


def test_a_persistent_source_wears_off(two_sources, plug, connect):
    bpy.data.objects["second"].haptics.source.muted = True
    bpy.data.objects["box"].haptics.source.decay = 0.25
    live, baked, each = played(two_sources, plug, connect)
    times, begin = np.arange(live.shape[1]) / RATE, first_frame(two_sources)
    assert np.abs(live[0] - each[0] * np.exp(-times / 0.25))[begin:].max() < 1e-9
    assert np.abs(live - baked)[:, begin:].max() < TRACK


def test_the_scene_file_carries_it(two_sources):
    listener, source = (
        bpy.data.objects["left"].haptics.listener,
        bpy.data.objects["box"].haptics.source,
    )
    listener.mixing, listener.mixing_expression, listener.limiter, source.decay = (
        "custom",
        "0.5 * sum",
        True,
        3.0,
    )
    two_sources.frame_set(2)
    document = scene_to_dict(scene_of_frame(two_sources, bpy.context.evaluated_depsgraph_get()))
    left = next(item for item in document["listeners"] if item["name"] == "left")
    assert (left["mixing"], left["mixing_expression"], left["limiter"]) == (
        "custom",
        "0.5 * sum",
        True,
    )
    box = next(item for item in document["sources"] if item["name"] == "box")
    assert box["signal"]["of"][1] == {"signal": "decay", "time_constant": 3.0}
    again = scene_from_dict(document, "scene.json")
    assert scene_to_dict(again) == document


def test_a_wrong_formula_is_said_and_the_others_go_on_feeling(two_sources):
    listener = bpy.data.objects["left"].haptics.listener
    listener.mixing, listener.mixing_expression = "custom", "sum + loud"
    two_sources.frame_set(2)
    assert [listener.name for listener in session.result_of(two_sources).listeners] == ["right"]
    problem = next(
        problem for problem in session.problems_of(two_sources) if problem.object == "left"
    )
    assert problem.message.startswith("the mixing formula: unknown name 'loud'")


def drawn(panel):
    layout = recording_layout.RecordingLayout()
    panel.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def test_panels_show_formula_limiter_and_decay(two_sources):
    bpy.context.view_layer.objects.active = bpy.data.objects["left"]
    listener = bpy.context.object.haptics.listener
    assert "mixing_expression" not in drawn(HAPTIC_PT_listener).properties
    listener.mixing, listener.mixing_expression = "custom", "sum +"
    wrong = drawn(HAPTIC_PT_listener)
    assert {"mixing_expression", "limiter", "s_max"} <= set(wrong.properties)
    assert any(text.lower().startswith("not a formula") for text in wrong.labels), wrong.labels
    listener.mixing_expression = "0.5 * sum"
    assert not any("formula" in text.lower() for text in drawn(HAPTIC_PT_listener).labels)
    bpy.context.view_layer.objects.active = bpy.data.objects["box"]
    assert "decay" in drawn(HAPTIC_PT_source).properties
