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
from haptic_tracing.addon.session import session, sessions, timeline
from haptic_tracing.core.contacts.shapes import transformed_bounds
from mathutils import Matrix

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
    read = reader.world_matrices
    monkeypatch.setattr(
        reader, "world_matrices", lambda count, layer: times.append(count) or read(count, layer)
    )
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


@pytest.fixture
def handler() -> Any:
    """Adds handlers of frames, as other add-ons have them, before or after those of this one."""
    added: list[Callable[..., None]] = []
    handlers = bpy.app.handlers.frame_change_post

    def add(function: Callable[..., None], is_first: bool) -> None:
        handlers.insert(0 if is_first else len(handlers), function)
        added.append(function)

    yield add
    for function in added:
        handlers.remove(function)


def lowest(obj: Any) -> float:
    """The lowest point of an object as Blender has evaluated it [m]."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    return min((evaluated.matrix_world @ vertex.co).z for vertex in mesh.vertices)


def raised_mesh(obj: Any) -> Any:
    mesh = obj.data.copy()
    mesh.transform(Matrix.Translation((0, 0, 3)))
    mesh.use_fake_user = obj.data.use_fake_user = True
    return mesh


def move(obj: Any) -> Callable[[bool], None]:
    return lambda is_up: setattr(obj.location, "z", 3.0 if is_up else 0.0)


def swap_mesh(obj: Any) -> Callable[[bool], None]:
    meshes = obj.data.name, raised_mesh(obj).name
    return lambda is_up: setattr(obj, "data", bpy.data.meshes[meshes[is_up]])


def set_vertices(obj: Any) -> Callable[[bool], None]:
    places = np.array([vertex.co[:] for vertex in obj.data.vertices], dtype=np.float32)

    def apply(is_up: bool) -> None:
        obj.data.vertices.foreach_set(
            "co", (places + np.array([0, 0, 3 * is_up])).astype(np.float32).ravel()
        )
        obj.data.update()

    return apply


def shape_key(obj: Any) -> Callable[[bool], None]:
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="up")
    for point in key.data:
        point.co.z += 3
    return lambda is_up: setattr(key, "value", float(is_up))


def modifier(obj: Any) -> Callable[[bool], None]:
    displace = obj.modifiers.new("Displace", "DISPLACE")
    displace.direction, displace.strength, displace.mid_level = "Z", 0, 0
    return lambda is_up: setattr(displace, "strength", 3.0 * is_up)


def constraint(obj: Any) -> Callable[[bool], None]:
    limit = obj.constraints.new("LIMIT_LOCATION")
    limit.use_min_z, limit.min_z = True, 0.0
    return lambda is_up: setattr(limit, "min_z", 3.0 * is_up)


def parent(obj: Any) -> Callable[[bool], None]:
    above = bpy.data.objects.new("above", None)
    bpy.context.scene.collection.objects.link(above)
    obj.parent = above
    return lambda is_up: setattr(above.location, "z", 3.0 * is_up)


def custom_property(obj: Any) -> Callable[[bool], None]:
    obj["height"] = 0.0
    driver = obj.driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = obj, '["height"]'
    driver.expression = variable.name
    return lambda is_up: (obj.__setitem__("height", 3.0 * is_up), obj.update_tag())


@pytest.mark.parametrize("is_first", [False, True], ids=["after", "before"])
@pytest.mark.parametrize(
    "change",
    [move, swap_mesh, set_vertices, shape_key, modifier, constraint, parent, custom_property],
)
def test_what_other_handlers_change_is_traced_in_that_frame(
    boxes, scene, handler, change, is_first
):
    """By scripts that ask, by exports, and where nobody asked of the frame before."""
    box = boxes[0]
    apply = change(box)
    handler(lambda *_: apply(bpy.context.scene.frame_current % 2 == 0), is_first)
    stepped = {step.result.number: step.result for step in timeline.steps(scene, 3, 8)}
    for frame in range(3, 9):
        scene.frame_set(frame)
        result = session.result_of(scene)
        known = sessions.known(scene).reading
        row = [body.name for body in known.bodies].index(box.name)
        shape = known.bodies[row].shape
        ((low, _),) = transformed_bounds(np.array([shape.local_bounds]), known.transforms[[row]])
        assert low[2] == pytest.approx(lowest(box), abs=1e-5)
        touching = {
            frozenset((result.objects[a], result.objects[b])) for a, b in result.contacts.pairs
        }
        assert (frozenset((box.name, "plank")) in touching) == (frame % 2 == 1)
        np.testing.assert_array_equal(result.gains, stepped[frame].gains)
    for frame in (9, 10, 11):  # nobody asks
        scene.frame_set(frame)
    request = sessions.known(scene).request
    assert request.frame.number == 10  # read before the next one
    row = [body.name for body in request.reading.bodies].index(box.name)
    shape = request.reading.bodies[row].shape
    poses = request.reading.transforms[[row]]
    ((low, _),) = transformed_bounds(np.array([shape.local_bounds]), poses)
    assert low[2] > 1.0
    session.result_of(scene)
    assert_read_as_afresh(scene, "the last frame, when its result is asked for")


@pytest.mark.parametrize("is_first", [False, True], ids=["after", "before"])
def test_what_other_handlers_hide_or_edit_is_traced_in_that_frame(boxes, scene, handler, is_first):
    def hide(*_: Any) -> None:
        boxes[0].hide_viewport = scene.frame_current % 2 == 0
        boxes[1].haptics.kappa = 0.5 if scene.frame_current % 2 else 0.25

    handler(hide, is_first)
    for frame in range(3, 8):
        scene.frame_set(frame)
        result = session.result_of(scene)
        assert (boxes[0].name in result.objects) == (frame % 2 == 1)
        objects = {item.name: item for item in sessions.known(scene).reading.objects}
        assert objects[boxes[1].name].kappa == (0.5 if frame % 2 else 0.25)
