"""From an empty file to something that is felt, in few steps; names, shapes and masses choose what
a designer would."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.authoring.signals import signal_for
from haptic_tracing.addon.session import session
from haptic_tracing.sample_scenes import SAMPLES


def _select(*objects):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0] if objects else None


def test_four_operators_from_a_cube_to_something_felt(add_box):
    cube = add_box("Cube", (0, 0, 0), (1, 1, 1), haptic=False)
    _select(cube)
    bpy.ops.haptic.make_objects()
    bpy.ops.haptic.add_source()
    bpy.ops.haptic.add_default_listeners()
    for frame in (2, 3):
        bpy.context.scene.frame_set(frame)
    result = session.result_of(bpy.context.scene)
    assert len(result.listeners) == 12
    assert (result.amplitudes > 0).all()
    assert np.abs(result.block).max() > 0.01


def test_three_operators_from_nothing_to_something_felt():
    bpy.ops.haptic.add_source_object(kind="PULSE")
    bpy.ops.haptic.add_listener()
    bpy.context.scene.frame_set(2)
    assert session.result_of(bpy.context.scene).amplitudes[0, 0] > 0.1


def test_make_haptic_chooses_materials(add_box):
    names = {"Oak Plank": "Hardwood", "Anvil": "Steel", "Cube": "", "Rubber Mat": "Rubber"}
    boxes = [add_box(name, (2 * k, 0, 0), (1, 1, 1), haptic=False) for k, name in enumerate(names)]
    ground = add_box("Plane", (0, 0, -1), (20, 20, 0.1), haptic=False)
    skin = bpy.data.materials.new("Marble white")
    boxes[2].data.materials.append(skin)
    bpy.context.view_layer.update()
    _select(*boxes, ground)
    bpy.ops.haptic.make_objects()
    assert [box.haptics.material.name for box in boxes] == ["Hardwood", "Steel", "Stone", "Rubber"]
    assert ground.haptics.material.name == "Soil"
    assert {item.name for item in bpy.context.scene.haptics.materials.items} == {
        "Hardwood",
        "Steel",
        "Stone",
        "Rubber",
        "Soil",
    }
    assert boxes[3].haptics.kappa == pytest.approx(0.8)


def test_make_haptic_leaves_what_is_haptic_as_it_is(add_box):
    box = add_box("Oak", (0, 0, 0), (1, 1, 1))
    box.haptics.kappa = 0.55
    _select(box)
    bpy.ops.haptic.make_objects()
    assert box.haptics.kappa == pytest.approx(0.55)
    assert not box.haptics.material.name


def test_physics_is_added_where_it_is_asked_for(add_box):
    ground, crate = (
        add_box("Plane", (0, 0, 0), (20, 20, 0.1), haptic=False),
        add_box("Crate", (0, 0, 3), (1, 1, 1), haptic=False),
    )
    bpy.context.view_layer.update()
    _select(ground, crate)
    bpy.ops.haptic.make_objects()
    assert bpy.context.scene.rigidbody_world is None
    bpy.ops.haptic.make_objects(physics=True)
    assert (ground.rigid_body.type, crate.rigid_body.type) == ("PASSIVE", "ACTIVE")
    for frame in range(1, 40):
        bpy.context.scene.frame_set(frame)
    assert crate.matrix_world.translation.z == pytest.approx(0.55, abs=0.06)


@pytest.mark.parametrize(
    ("name", "signal", "frequency"),
    [
        ("Jackhammer", "PULSE", 25),
        ("Car Engine.001", "SINE", 30),
        ("Waterfall", "NOISE", 60),
        ("Cube", "SINE", 60),
        ("Phones", "SINE", 150),
    ],
)
def test_names_tell_the_signal(name, signal, frequency, add_box):
    assert (signal_for(name).signal, signal_for(name).frequency) == (signal, frequency)
    box = add_box(name, (0, 0, 0), (1, 1, 1))
    _select(box)
    bpy.ops.haptic.add_source()
    assert (box.haptics.source.signal, box.haptics.source.frequency) == (signal, frequency)


def test_a_source_is_added_as_an_empty_on_what_is_haptic_else_as_a_body(add_box):
    box = add_box("Bench", (1, 2, 3), (2, 1, 1))
    box.rotation_euler = (0.3, 0.2, 0.1)
    bpy.context.view_layer.update()
    _select(box)
    bpy.context.scene.cursor.location = (1, 2, 3.5)
    bpy.ops.haptic.add_source_object(kind="NOISE")
    empty = bpy.context.object
    bpy.context.view_layer.update()
    assert (empty.type, empty.parent, empty.haptics.source.signal) == ("EMPTY", box, "NOISE")
    assert tuple(empty.matrix_world.translation) == pytest.approx((1, 2, 3.5), abs=1e-5)
    assert tuple(empty.matrix_world.to_scale()) == pytest.approx((1, 1, 1), abs=1e-5)
    _select()
    bpy.ops.haptic.add_source_object(kind="SINE")
    body = bpy.context.object
    assert body.type == "MESH"
    assert body.haptics.enabled
    assert body.haptics.material.name == "Steel"


def test_a_medium_surrounds_the_selection(add_box, traced):
    boxes = [add_box(str(x), (x, 0, 0), (1, 1, 1)) for x in (-3, 3)]
    boxes[0].haptics.source.enabled = boxes[1].haptics.listener.enabled = True
    bpy.context.view_layer.update()
    _select(*boxes)
    bpy.ops.haptic.add_medium(medium="air")
    air = bpy.context.object
    bpy.context.view_layer.update()
    assert air.haptics.medium
    assert tuple(air.dimensions) == pytest.approx((7.5, 1.5, 1.5))
    assert traced().amplitudes[0, 0] > 0


def test_samples_are_added_beside_the_scenes_of_the_file(scene):
    assert bpy.ops.haptic.add_sample(sample="hammer_nail") == {"FINISHED"}
    assert len(bpy.data.scenes) == 2
    assert SAMPLES["hammer_nail"].title in bpy.data.scenes


def test_linked_objects_are_told_apart(add_box, tmp_path):
    box = add_box("far", (0, 0, 0), (1, 1, 1), haptic=False)
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {box})
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["far"]
    linked = wanted.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    _select(linked)
    for operator in (
        "make_objects",
        "add_source",
        "add_listener",
        "clear",
        "add_default_listeners",
    ):
        with pytest.raises(RuntimeError, match="linked from a library"):
            getattr(bpy.ops.haptic, operator)()


@pytest.mark.slow
@pytest.mark.parametrize("count", [2_500, pytest.param(10_000, marks=pytest.mark.more)])
def test_thousands_of_objects(add_box, count):
    """They are done with a progress bar."""
    mesh = add_box("one", (0, 0, 0), (1, 1, 1), haptic=False).data
    collection = bpy.context.scene.collection
    for number in range(count):
        collection.objects.link(bpy.data.objects.new(f"Brick {number}", mesh))
    bpy.ops.object.select_all(action="SELECT")
    bpy.context.scene.haptics.tracing = False
    bricks = list(bpy.context.selected_objects)
    assert bpy.ops.haptic.make_objects() == {"FINISHED"}
    assert all(obj.haptics.enabled for obj in bricks)
    # Numbers of bricks are none of alloys; of the one whose name tells nothing plastic is assumed.
    titles = {item.name for item in bpy.context.scene.haptics.materials.items}
    assert titles == {"Brick", "Plastic"}
    assert bpy.ops.haptic.guess_material() == {"FINISHED"}
    assert bpy.ops.haptic.add_listener() == {"FINISHED"}
    assert (
        sum(obj.haptics.listener.enabled for obj in bpy.context.scene.objects)
        == len(bricks)
        == count + 1
    )
    for obj in bricks:
        obj.select_set(True)
    assert bpy.ops.haptic.clear() == {"FINISHED"}
    assert not any(obj.haptics.enabled for obj in bricks)
