"""Handlers, and what is kept between redraws."""

import dataclasses
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.changes import redraw
from haptic_tracing.addon.properties.scene import HapticSceneProperties
from haptic_tracing.addon.registration import draw_handlers
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view import overlay as draw
from haptic_tracing.addon.view import shader
from haptic_tracing.addon.view.options import options_of
from haptic_tracing.addon.view.render_data import Options

from .conftest import BRIDGE


@pytest.fixture
def uploads(monkeypatch):
    """Counts what goes to the GPU, which this test needs none of."""
    counted = []
    monkeypatch.setattr(shader, "upload", lambda quads: counted.append(quads.count) or object())
    draw.forget()
    yield counted
    draw.forget()


@pytest.fixture
def show(scene, settle, monkeypatch):
    """Shows a frame with settings and options of its own in the scene; returns its drawing once it
    is complete."""

    def shown(result, settings=BRIDGE.settings, options=None):
        own = session.of(scene)
        own.shown = sessions.Traced(result, settings, np.zeros((len(result.listeners), 0)))
        monkeypatch.setattr(draw, "options_of", lambda *_: options or Options())
        return settle(lambda: draw.drawing_of(scene))

    return shown


def test_nothing_is_built_while_nothing_changed(uploads, bridge, scene, show):
    first = show(bridge)
    assert draw.drawing_of(scene) is first
    assert len(uploads) == 1
    data = first.shapes.data
    assert uploads[0] == len(data.tree.width) + 2 * len(data.paths.width) + len(data.points.width)


def test_frames_in_which_nothing_changes_share_a_drawing(uploads, bridge, show):
    first = show(bridge)
    assert show(dataclasses.replace(bridge, number=2)) is first
    assert len(uploads) == 1


def test_every_change_is_drawn(uploads, bridge, show):
    again = dataclasses.replace(bridge, graph=dataclasses.replace(bridge.graph))
    louder = dataclasses.replace(BRIDGE.settings, threshold=0.1)
    chosen = Options(listeners=frozenset({"driver"}))
    frames = ((bridge,), (again,), (again, louder), (again, louder, chosen))
    drawings = [show(*what) for what in frames]
    assert len({id(drawing) for drawing in drawings}) == len(uploads) == 4


def test_selection_is_read_from_the_scene(scene, bridge, add_empty):
    names = [item.name for item in (*BRIDGE.sources, *BRIDGE.listeners)]
    objects = {name: add_empty(name) for name in names}
    bpy.context.view_layer.update()
    for obj in objects.values():
        obj.select_set(False)
    assert options_of(scene, bridge) == Options(labelled="")
    objects["truck"].select_set(True)
    objects["walker"].select_set(True)
    assert options_of(scene, bridge) == Options(
        labelled="", sources=frozenset({"truck"}), listeners=frozenset({"walker"})
    )
    scene.haptics.show_labels = True
    assert options_of(scene, bridge).labelled is None


def test_handlers_come_and_go_any_number_of_times():
    for _ in range(3):
        draw_handlers.unregister()
        assert not draw_handlers._handlers
        draw_handlers.unregister()
        draw_handlers.register()
        draw_handlers.register()
        # One draws in world space, one in pixels, one beside the panel Adjust Last Operation.
        assert len(draw_handlers._handlers) == 3


def test_redraw_tags_every_3d_viewport_and_nothing_else(monkeypatch):
    tagged = []
    areas = [
        SimpleNamespace(type=kind, tag_redraw=lambda kind=kind: tagged.append(kind))
        for kind in ("VIEW_3D", "TEXT_EDITOR", "VIEW_3D")
    ]
    windows = [
        SimpleNamespace(screen=SimpleNamespace(areas=chosen)) for chosen in (areas, areas[1:2])
    ]
    monkeypatch.setattr(
        redraw,
        "bpy",
        SimpleNamespace(context=SimpleNamespace(window_manager=SimpleNamespace(windows=windows))),
    )
    redraw.redraw_viewports()
    assert tagged == ["VIEW_3D", "VIEW_3D"]


def test_draw_callbacks_outside_a_viewport_draw_nothing(uploads, shown):
    shown()
    draw.draw_view()
    draw.draw_pixels()
    assert uploads == []
    assert not draw._drawings


def test_overlay_properties_have_tooltips():
    for name in (
        "show_overlay",
        "show_intra",
        "show_best_paths",
        "show_labels",
        "show_flow",
        "xray",
    ):
        assert HapticSceneProperties.bl_rna.properties[name].description
