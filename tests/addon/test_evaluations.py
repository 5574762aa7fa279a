"""A frame in which Blender says that few objects have changed is read as a fresh reader reads it,
whatever was done before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.scene_reader import reader
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import sessions

COUNT = 8


@pytest.fixture
def boxes(add_box: Callable[..., Any], scene: Any) -> list[Any]:
    """A row of boxes on a plank, of which the last one slides to and fro."""
    plank = add_box("plank", (0, 0, -0.35), (40, 1, 0.2))
    row = [add_box(f"box {k}", (k, 0, 0), (0.5, 0.5, 0.5)) for k in range(COUNT)]
    plank.haptics.source.enabled = row[-1].haptics.listener.enabled = True
    for frame in (1, 200):
        row[-1].location.x = frame / 10
        row[-1].keyframe_insert("location", index=0, frame=frame)
    scene.frame_set(1)
    return row


@pytest.fixture
def read_everywhere(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A number for each time that the matrices of all objects are read."""
    times: list[int] = []
    read = reader.raw_matrices
    monkeypatch.setattr(reader, "raw_matrices", lambda count: times.append(count) or read(count))
    return times


def assert_read_as_afresh(scene: Any, told: str) -> None:
    """The last reading of the session equals that of a new reader."""
    now = sessions.known(scene).reading
    fresh = SceneReader().read(scene, bpy.context.evaluated_depsgraph_get())
    assert [body.name for body in now.bodies] == [body.name for body in fresh.bodies], told
    assert now.bodies == fresh.bodies, told
    np.testing.assert_allclose(now.transforms, fresh.transforms, atol=2e-5, err_msg=told)


def test_of_many_objects_only_the_one_that_moves_is_read(boxes, scene, read_everywhere):
    scene.frame_set(2)
    read_everywhere.clear()
    for frame in range(3, 12):
        scene.frame_set(frame)
        assert_read_as_afresh(scene, str(frame))
    assert len(read_everywhere) == 9  # those of the fresh readers


@pytest.mark.slow
def test_random_edits_between_frames(boxes, scene):
    random = np.random.default_rng(9)
    away = bpy.data.collections.new("away")
    scene.collection.children.link(away)
    names = iter("mnopqrstuvwxyz" * 100)

    def some() -> Any:
        return boxes[random.integers(COUNT)]

    def move() -> None:
        some().location.z += 0.1

    def place() -> None:
        some().matrix_world.translation = random.uniform(0, 9, 3)

    def scale() -> None:
        some().scale.z *= 1.2

    def hide() -> None:
        obj = some()
        obj.hide_viewport = not obj.hide_viewport

    def key_hiding() -> None:
        obj = some()
        for frame in (scene.frame_current, scene.frame_current + 3):
            obj.hide_viewport = not obj.hide_viewport
            obj.keyframe_insert("hide_viewport", frame=frame)

    def link() -> None:
        obj = some()
        if obj.name in scene.collection.objects:
            scene.collection.objects.unlink(obj)
        else:
            scene.collection.objects.link(obj)

    def collect() -> None:
        obj = some()
        if obj.name in away.objects:
            away.objects.unlink(obj)
        else:
            away.objects.link(obj)

    def hide_collection() -> None:
        away.hide_viewport = not away.hide_viewport

    def exclude() -> None:
        layer = bpy.context.view_layer.layer_collection.children["away"]
        layer.exclude = not layer.exclude

    def rename() -> None:
        some().name = next(names)
        update()

    def add_unlinked() -> None:
        bpy.data.objects.new(next(names), None)

    def remove_unlinked() -> None:
        for obj in bpy.data.objects:
            if obj.type == "EMPTY":
                bpy.data.objects.remove(obj)
                return

    def parent() -> None:
        obj = some()
        obj.parent = None if obj.parent or obj is boxes[-1] else boxes[-1]

    def follow() -> None:
        obj = some()
        if obj.constraints or obj is boxes[-1]:
            obj.constraints.clear()
        else:
            obj.constraints.new("COPY_LOCATION").target = boxes[-1]

    def subdivide() -> None:
        obj = some()
        if obj.modifiers:
            obj.modifiers.clear()
        else:
            obj.modifiers.new("s", "SUBSURF")

    def update() -> None:
        bpy.context.view_layer.update()

    def leave_untraced() -> None:
        scene.haptics.tracing = False
        scene.frame_set(scene.frame_current + 1)
        scene.haptics.tracing = True

    edits = (
        *(move, place, scale, hide, key_hiding, link, collect, hide_collection, exclude, rename),
        *(add_unlinked, remove_unlinked, parent, follow, subdivide, update, leave_untraced),
    )
    for _ in range(400):
        chosen = [edits[random.integers(len(edits))] for _ in range(random.integers(3))]
        for edit in chosen:
            edit()
        following = scene.frame_current % 190 + 1
        scene.frame_set(following)
        assert_read_as_afresh(
            scene, f"frame {following} after {[edit.__name__ for edit in chosen]}"
        )


@pytest.mark.parametrize("is_removed", [False, True])
def test_what_another_script_moves_after_the_frame_is_seen_in_the_next_one(
    boxes, scene, is_removed
):
    def lift(*_: Any) -> None:
        boxes[0].location.z = 3.0

    scene.frame_set(2)
    bpy.app.handlers.frame_change_post.append(lift)
    scene.frame_set(3)
    if is_removed:
        bpy.app.handlers.frame_change_post.remove(lift)
    scene.frame_set(4)
    if not is_removed:
        bpy.app.handlers.frame_change_post.remove(lift)
    assert_read_as_afresh(scene, "lifted")
    now = sessions.known(scene).reading
    assert now.transforms[[body.name for body in now.bodies].index("box 0"), 2, 3] == 3.0
