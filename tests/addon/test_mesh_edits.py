"""An edit of a mesh is seen whenever it was made, and nothing is built anew where no mesh changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.registration import handlers
from haptic_tracing.addon.scene_reader import reader
from haptic_tracing.addon.session import session


@pytest.fixture
def boxes(add_box: Callable[..., Any], traced: Callable[[], Any]) -> list[Any]:
    """A plank, and a box that stands on it until its mesh is edited."""
    found = [add_box("plank", (0, 0, 0), (4, 1, 0.2)), add_box("box", (1.5, 0, 0.35), (0.5, 0.5, 0.5))]
    assert len(traced().contacts) == 1
    return found


def lift(mesh: Any) -> None:
    """Move all vertices of a mesh up by its height."""
    for vertex in mesh.vertices:
        vertex.co.z += 1.0
    mesh.update()
    bpy.context.view_layer.update()


def contacts(scene: Any) -> int:
    return len(session.result_of(scene).contacts)


def test_an_edit_while_tracing_is_on(boxes, scene):
    lift(boxes[1].data)
    assert contacts(scene) == 0


def test_an_edit_while_tracing_is_off(boxes, scene):
    scene.haptics.tracing = False
    lift(boxes[1].data)
    scene.haptics.tracing = True
    bpy.context.view_layer.update()
    assert contacts(scene) == 0


def test_an_edit_while_the_timeline_plays(boxes, scene, monkeypatch):
    monkeypatch.setattr(handlers, "is_playing", lambda: True)
    scene.frame_set(1)
    lift(boxes[1].data)
    scene.frame_set(2)
    assert contacts(scene) == 0


def test_an_edit_through_a_window_of_another_scene(boxes, scene):
    other = bpy.data.scenes.new("other")
    other.collection.objects.link(boxes[1])
    bpy.context.window.scene = other
    lift(boxes[1].data)
    bpy.context.window.scene = scene
    scene.frame_set(2)
    assert contacts(scene) == 0


@pytest.mark.parametrize("tracing", [True, False])
def test_a_modifier(boxes, scene, tracing):
    scene.haptics.tracing = tracing
    boxes[1].modifiers.new("smaller", "SUBSURF").levels = 2  # a sphere that touches no longer
    bpy.context.view_layer.update()
    scene.haptics.tracing = True
    bpy.context.view_layer.update()
    assert contacts(scene) == 0


def test_a_part_of_a_compound(add_box, traced, scene):
    add_box("plank", (0, 0, 0), (4, 1, 0.2))
    parent = add_box("parent", (0, 0, 3), (1, 1, 1), body="ACTIVE")
    part = add_box("part", (0, 0, 0.35), (0.5, 0.5, 0.5), body="PASSIVE", haptic=False)
    part.parent, part.matrix_parent_inverse = parent, parent.matrix_world.inverted()
    parent.rigid_body.collision_shape = "COMPOUND"
    bpy.context.view_layer.update()
    part.matrix_world.translation = (0, 0, 0.35)
    bpy.context.view_layer.update()
    assert len(traced().contacts) == 1
    lift(part.data)
    assert contacts(scene) == 0


def test_shapes_are_built_once_where_only_settings_change(boxes, scene, monkeypatch):
    built = []
    build = reader.collision_shape
    monkeypatch.setattr(reader, "collision_shape", lambda *what: built.append(what[0].name) or build(*what))
    boxes[0].haptics.rho = 0.5
    boxes[1].location.x = 1.0
    bpy.context.view_layer.update()
    assert built == []
    lift(boxes[1].data)
    assert built == ["box"]
