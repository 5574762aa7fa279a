"""The path to a listener against closed forms, its row in the overlay, and the panel that shows
it."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import recording_layout
from haptic_tracing.addon.panels import answer as answer_panel
from haptic_tracing.addon.session import sessions
from haptic_tracing.addon.view import explanation, levels, paths, watched
from haptic_tracing.addon.view.options import options_of
from haptic_tracing.addon.view.render_data import HIGHLIGHT_LINE, render_data
from haptic_tracing.core.message import Cause

ALPHA = {"ground": 0.2, "bench": 1.5, "seat": 0.4}
NEPER = 20 / math.log(10)


@pytest.fixture
def chain(scene, add_box, add_empty):
    """Three boxes of 1 m in a row, each with its own decay per metre; a source amid the first, a
    listener amid the last."""
    for k, (name, alpha) in enumerate(ALPHA.items()):
        box = add_box(name, (k, 0, 0), (1, 1, 1))
        box.haptics.function, box.haptics.alpha = "exponential", alpha
    add_empty("drill", (0, 0, 0), bpy.data.objects["ground"]).haptics.source.enabled = True
    bpy.data.objects["drill"].haptics.source.amplitude = 0.5
    add_empty("skin", (0, 0, 0), bpy.data.objects["seat"]).haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = bpy.data.objects["skin"]
    scene.haptics.strategy = "best_path"
    scene.frame_set(1)
    return scene


def _drawn(draw):
    """The texts that a panel, or a function that takes a layout, draws."""
    layout = recording_layout.RecordingLayout()
    draw(SimpleNamespace(layout=layout) if draw.__name__ == "draw" else layout, bpy.context)
    return layout.labels


def _path(scene, settle):
    return settle(lambda: paths.path_of(scene)).value


def _tenths(words):
    """The decibels of a text such as "−12.3 dB", in tenths."""
    number, unit = words.replace("\N{MINUS SIGN}", "-").split()
    assert unit == "dB"
    return round(10 * float(number))


def check_rows(path, level):
    """What the table says adds up: the rows to the level, and with the threshold to the margin; the
    level is the one that is shown."""
    rows = paths.rows(path)
    ends = [place for place, row in enumerate(rows) if row.is_sum]
    shown = [_tenths(levels.change_words(row.decibels)) for row in rows]
    assert shown[ends[0]] == sum(shown[: ends[0]])
    assert shown[ends[0]] / 10 == pytest.approx(level.rms, abs=0.051)
    assert shown[ends[1]] == shown[ends[0]] - shown[ends[0] + 1]
    assert shown[ends[1]] / 10 == pytest.approx(level.margin, abs=0.051)


def test_losses_add_up_to_the_gain_of_the_best_path(chain, settle):
    path = _path(chain, settle)
    fall = path.fall
    assert [hop.object for hop in fall.hops] == list(ALPHA)
    assert [hop.distance for hop in fall.hops] == pytest.approx([0.5, 1.0, 0.45], abs=0.02), (
        "the last up to the listener's radius"
    )
    losses = [NEPER * a * h.distance for a, h in zip(ALPHA.values(), fall.hops, strict=True)]
    assert [hop.loss for hop in fall.hops] == pytest.approx(losses)
    assert (fall.source.name, fall.listener) == ("drill", "skin")
    assert fall.amplitude == pytest.approx(20 * math.log10(0.5))
    assert fall.gain == pytest.approx(-sum(losses))
    assert fall.gain == pytest.approx(20 * math.log10(sessions.shown(chain).result.gains[0, 0]))


def test_one_gain_whatever_amplitude_and_listener_gain_and_rows_that_add_up(chain, settle):
    """The reason for silence names the same gain, which is that of the path."""
    before = _path(chain, settle).fall.gain
    drill, skin = (
        bpy.data.objects["drill"].haptics.source,
        bpy.data.objects["skin"].haptics.listener,
    )
    for frame, (amplitude, gain) in enumerate(((1.0, 1.0), (0.37, 2.0), (0.05, 0.3)), 2):
        drill.amplitude, skin.gain = amplitude, gain
        chain.frame_set(frame)
        path = _path(chain, settle)
        assert path.fall.gain == pytest.approx(before)
        check_rows(path, settle(lambda: watched.levels_of(chain))[0])
    drill.amplitude = 0.0005
    chain.frame_set(9)
    (reason,) = settle(lambda: explanation.why_silent(chain, "skin")).reasons
    assert reason.cause is Cause.NOT_FELT and reason["gain"] == pytest.approx(before)
    assert reason["level"] == pytest.approx(watched.levels_of(chain)[0].rms)


def test_rows_say_which_source_is_silent_and_what_others_play(chain, settle, add_empty):
    add_empty("fan", (0.2, 0, 0), bpy.data.objects["ground"]).haptics.source.enabled = True
    chain.frame_set(2)
    path = _path(chain, settle)
    check_rows(path, settle(lambda: watched.levels_of(chain))[0])
    names = [row.name for row in paths.rows(path)]
    assert names == [
        "Source amplitude",
        *ALPHA,
        "RMS of the signal",
        "Other sources, limiter",
        "Level",
        "Threshold of feeling",
        "Margin",
    ]
    assert [row.name for row in paths.rows(path, by_loss=True)][1:4] == ["bench", "seat", "ground"]
    bpy.data.objects["skin"].haptics.listener.gain = 0
    chain.frame_set(3)
    rows = paths.rows(_path(chain, settle))
    assert [(row.name, levels.change_words(row.decibels)) for row in rows[-2:]] == [
        ("Listener gain", "silent"),
        ("Level", "silent"),
    ]


def test_the_active_object_decides_source_and_row_and_the_listener_stays(chain, add_empty, settle):
    add_empty("fan", (0.2, 0, 0), bpy.data.objects["ground"]).haptics.source.enabled = True
    chain.frame_set(2)
    assert _path(chain, settle).fall.source.name == "fan"  # nearer, and twice as strong
    bpy.context.view_layer.objects.active = bpy.data.objects["drill"]
    assert _path(chain, settle).fall.source.name == "drill"
    assert _path(chain, settle).fall.listener == "skin"


def test_the_overlay_highlights_the_part_of_the_path_in_the_active_object(chain, settle):
    _path(chain, settle)
    traced = sessions.shown(chain)
    data = render_data(traced.result, traced.settings, options_of(chain, traced.result))
    assert not len(data.highlight.width), "the active object is the listener"
    bpy.context.view_layer.objects.active = bpy.data.objects["bench"]
    options = options_of(chain, traced.result)
    assert options.highlight == ("skin", "bench")
    highlight = render_data(traced.result, traced.settings, options).highlight
    assert (highlight.width == HIGHLIGHT_LINE).all()
    across = highlight.position[:, :, 0]
    assert (across.min(), across.max()) == (
        pytest.approx(0.5, abs=0.02),
        pytest.approx(1.5, abs=0.02),
    )
    assert np.ptp(across, axis=1).max() == pytest.approx(1.0, abs=0.02)


def test_modes_without_paths_have_no_rows(chain, settle):
    chain.haptics.mode = "MN"
    chain.frame_set(2)
    path = _path(chain, settle)
    assert path.fall.hops == ()
    assert path.fall.gain == pytest.approx(0.0)
    check_rows(path, settle(lambda: watched.levels_of(chain))[0])
    assert [row.name for row in paths.rows(path)][:2] == ["Source amplitude", "Gain"]


def test_the_panel_lists_the_objects_in_order_or_by_loss_and_presses_the_active_row(chain, settle):
    def names():
        return [
            label
            for label in _drawn(answer_panel.draw_why)
            if label in ALPHA or label == "= Margin"
        ]

    assert settle(names) == ["ground", "bench", "seat", "= Margin"]
    chain.haptics.meters.sort_path = True
    assert settle(names) == ["bench", "seat", "ground", "= Margin"]


def test_nothing_reaches_a_listener_that_hangs_in_the_air(chain, settle):
    bpy.data.objects["seat"].location.x = 9
    bpy.context.view_layer.update()
    assert settle(lambda: paths.path_of(chain)).value is None


def test_a_listener_that_is_gone_in_the_next_frame_has_no_path(chain, settle):
    """The path is computed with every frame, of the listener that was looked at last: as after
    undo."""
    assert _path(chain, settle) is not None
    bpy.data.objects["skin"].haptics.listener.enabled = False
    chain.frame_set(2)
    assert settle(lambda: paths.path_of(chain)) is None
    bpy.data.objects["skin"].haptics.listener.enabled = True
    chain.frame_set(3)
    assert _path(chain, settle).fall.listener == "skin"
