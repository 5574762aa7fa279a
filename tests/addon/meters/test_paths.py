"""The path to a listener against closed forms, its row in the overlay, and the panel that shows it."""

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.panels import result as result_panel
from haptic_tracing.addon.session import sessions
from haptic_tracing.addon.view import paths
from haptic_tracing.addon.view.options import options_of
from haptic_tracing.addon.view.render_data import HIGHLIGHT_LINE, render_data

_spec = importlib.util.spec_from_file_location("recording_layout", Path(__file__).parents[1] / "recording_layout.py")
recording_layout = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(recording_layout)

ALPHA = {"ground": 0.2, "bench": 1.5, "seat": 0.4}
NEPER = 20 / math.log(10)


@pytest.fixture
def chain(scene, add_box, add_empty):
    """Three boxes of 1 m in a row, each with its own decay per metre; a source amid the first, a listener amid the last."""
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


def _path(scene, settle):
    return settle(lambda: paths.path_of(scene)).value


def test_losses_add_up_to_the_gain_of_the_best_path(chain, settle):
    path = _path(chain, settle)
    assert [hop.object for hop in path.hops] == list(ALPHA)
    assert [hop.distance for hop in path.hops] == pytest.approx([0.5, 1.0, 0.45], abs=0.02), "the last up to the listener's radius"
    assert [hop.loss for hop in path.hops] == pytest.approx(
        [NEPER * a * h.distance for a, h in zip(ALPHA.values(), path.hops, strict=True)]
    )
    assert (path.source.name, path.listener) == ("drill", "skin")
    assert path.amplitude == pytest.approx(20 * math.log10(0.5))
    assert path.best_gain == pytest.approx(20 * math.log10(path.gain))
    assert path.gain == pytest.approx(sessions.shown(chain).result.gains[0, 0])


def test_the_active_object_decides_source_and_row_and_the_listener_stays(chain, add_empty, settle):
    add_empty("fan", (0.2, 0, 0), bpy.data.objects["ground"]).haptics.source.enabled = True
    chain.frame_set(2)
    assert _path(chain, settle).source.name == "fan"  # nearer, and twice as strong
    bpy.context.view_layer.objects.active = bpy.data.objects["drill"]
    assert _path(chain, settle).source.name == "drill"
    assert _path(chain, settle).listener == "skin"


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
    assert (across.min(), across.max()) == (pytest.approx(0.5, abs=0.02), pytest.approx(1.5, abs=0.02))
    assert np.ptp(across, axis=1).max() == pytest.approx(1.0, abs=0.02)


def test_modes_without_paths_have_no_rows(chain, settle):
    chain.haptics.mode = "MN"
    chain.frame_set(2)
    path = _path(chain, settle)
    assert path.hops == ()
    assert path.gain == pytest.approx(0.5)


def test_the_panel_lists_the_objects_in_order_or_by_loss_and_presses_the_active_row(chain, settle):
    def names():
        layout = recording_layout.RecordingLayout()
        result_panel.HAPTIC_PT_path.draw(SimpleNamespace(layout=layout), bpy.context)
        return [label for label in layout.labels if label in ALPHA or label == "Gain of the best path"]

    assert settle(names) == ["ground", "bench", "seat", "Gain of the best path"]
    chain.haptics.meters.sort_path = True
    assert settle(names) == ["bench", "seat", "ground", "Gain of the best path"]


def test_nothing_reaches_a_listener_that_hangs_in_the_air(chain, settle):
    bpy.data.objects["seat"].location.x = 9
    bpy.context.view_layer.update()
    assert settle(lambda: paths.path_of(chain)).value is None


def test_a_listener_that_is_gone_in_the_next_frame_has_no_path(chain, settle):
    """The path is computed with every frame, of the listener that was looked at last: as after undo."""
    assert _path(chain, settle) is not None
    bpy.data.objects["skin"].haptics.listener.enabled = False
    chain.frame_set(2)
    assert settle(lambda: paths.path_of(chain)) is None
    bpy.data.objects["skin"].haptics.listener.enabled = True
    chain.frame_set(3)
    assert _path(chain, settle).listener == "skin"
