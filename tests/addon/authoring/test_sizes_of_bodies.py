"""Sizes of bodies as waves meet them: walls of solid, hollow and open meshes against closed forms,
and what *Model* makes of them."""

from __future__ import annotations

import math

import bpy
import pytest
from haptic_tracing.addon.authoring import materials as library
from haptic_tracing.addon.authoring.sizes import Sizes
from haptic_tracing.addon.scene_reader.functions import read_function
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.materials import MATERIALS


@pytest.fixture
def sizes(scene):
    """The sizes of the active object, of its evaluated mesh."""

    def of_active():
        active = bpy.context.view_layer.objects.active
        return Sizes([active]).of(active).edges

    return of_active


@pytest.fixture
def pipe(scene):
    """A tube of 3 m, 0.5 m across, as one surface."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=128, radius=0.25, depth=3, end_fill_type="NOTHING")
    return bpy.context.object


def thicken(obj: bpy.types.Object, wall: float) -> None:
    """Give a surface a wall, to the inside."""
    modifier = obj.modifiers.new("wall", "SOLIDIFY")
    modifier.thickness, modifier.offset, modifier.use_even_offset = wall, -1.0, True
    bpy.context.view_layer.update()


@pytest.mark.parametrize("size", [(1, 1, 1), (4, 0.1, 0.1), (3, 2, 0.01), (0.2, 5, 2)])
def test_a_solid_box_has_the_sizes_of_its_box(sizes, add_box, size):
    bpy.context.view_layer.objects.active = add_box("box", (0, 0, 0), size)
    assert sizes() == pytest.approx(sorted(size, reverse=True), rel=1e-5)


def test_bodies_that_share_a_mesh_have_each_the_sizes_of_their_scale(add_box):
    first = add_box("box", (0, 0, 0), (1, 1, 1))
    boxes = [first, *(first.copy() for _ in range(3))]
    scales = [(1, 1, 1), (4, 0.1, 0.2), (0.1, 4, 0.2), (-3, 2, 0.01)]
    for box, scale in zip(boxes, scales, strict=True):
        box.scale = scale
    for box in boxes[1:]:
        bpy.context.collection.objects.link(box)
    bpy.context.view_layer.update()
    sizes = Sizes(boxes)
    for box, scale in zip(boxes, scales, strict=True):
        assert sizes.of(box).edges == pytest.approx(sorted(map(abs, scale), reverse=True), rel=1e-5)
        assert sizes.of(box).volume == pytest.approx(abs(math.prod(scale)), rel=1e-5)


def test_volumes_are_those_of_the_meshes(scene):
    """A cylinder, a ball, and a sheet of 1 m² that counts as a centimetre thick."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=128, radius=0.2, depth=3)
    cylinder = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.5)
    ball = bpy.context.object
    bpy.ops.mesh.primitive_plane_add(size=1)
    sheet = bpy.context.object
    sizes = Sizes([cylinder, ball, sheet])
    assert sizes.of(cylinder).volume == pytest.approx(math.pi * 0.2**2 * 3, rel=0.01)
    assert sizes.of(ball).volume == pytest.approx(math.pi / 6, rel=0.01)
    assert sizes.of(sheet).volume == pytest.approx(0.01, rel=0.01)


def test_a_script_that_tags_many_objects_evaluates_nothing(add_box):
    """Each evaluation takes as long as the scene is large."""
    boxes = [add_box(f"box {k}", (2 * k, 0, 0), (1, 1, 0.01), haptic=False) for k in range(5)]
    counted = []
    count = bpy.app.handlers.depsgraph_update_post
    count.append(lambda *_: counted.append(1))
    for number, box in enumerate(boxes, 1):
        box.scale.z *= number
        box.haptics.enabled = True
    count.pop()
    assert not counted
    held = [box.haptics.plate_thickness for box in boxes]
    assert held == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05], rel=1e-5)


def test_sizes_follow_what_a_script_has_just_changed(add_box):
    """A shape key, a modifier and a parent's scale, before any evaluation."""
    keyed, arrayed, child, parent = (
        add_box(name, (0, 0, 0), (1, 1, 1)) for name in ("keyed", "arrayed", "child", "parent")
    )
    keyed.shape_key_add(name="basis")
    for point in keyed.shape_key_add(name="tall").data:
        point.co.z *= 3
    keyed.data.shape_keys.key_blocks["tall"].value = 1.0
    arrayed.modifiers.new("row", "ARRAY").count = 2
    child.parent, parent.scale = parent, (1, 1, 5)
    sizes = Sizes([keyed, arrayed, child])
    assert [max(sizes.of(obj).edges) for obj in (keyed, arrayed, child)] == pytest.approx([3, 2, 5])


def test_a_ball_that_is_made_haptic_weighs_what_it_should(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.1)
    ball = bpy.context.object
    ball.name = "Steel Ball"
    bpy.ops.haptic.make_objects()
    held = ball.haptics
    volume = held.length * held.extent * held.plate_thickness
    assert volume * held.density == pytest.approx(7850 * 4 / 3 * math.pi * 0.1**3, rel=0.01)


def test_solid_cylinders_and_balls_are_as_thick_as_they_are_wide(sizes, scene):
    bpy.ops.mesh.primitive_cylinder_add(vertices=128, radius=0.2, depth=3)
    assert sizes() == pytest.approx((3, 0.4, 0.4), rel=0.01)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.5)
    assert sizes() == pytest.approx((1, 1, 1), rel=0.01)


@pytest.mark.parametrize("wall", [0.002, 0.01, 0.03])
def test_a_pipe_is_as_thin_as_its_wall(sizes, pipe, wall):
    thicken(pipe, wall)
    assert sizes() == pytest.approx((3, 0.5, wall), rel=0.1)


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_a_room_is_as_thin_as_its_walls(sizes, add_box, scale):
    room = add_box("room", (0, 0, 0), (4, 5, 3))
    bpy.context.view_layer.objects.active = room
    bpy.ops.object.select_all(action="DESELECT")
    room.select_set(True)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    thicken(room, 0.2)
    room.scale = (scale, scale, scale)
    bpy.context.view_layer.update()
    assert sizes() == pytest.approx((5 * scale, 4 * scale, 0.2 * scale), rel=0.15)


def test_a_sheet_modelled_as_one_surface_is_a_centimetre_thick_at_most(sizes, pipe):
    assert sizes() == pytest.approx((3, 0.5, 0.01), rel=0.01)
    bpy.ops.mesh.primitive_plane_add(size=2)
    assert sizes() == pytest.approx((2, 2, 0.01))


def made_physical(scene, obj: bpy.types.Object, material: str) -> None:
    obj.haptics.enabled = True
    library.apply([obj], library.preset_in(scene, MATERIALS[material]))
    assert bpy.ops.haptic.set_model() == {"FINISHED"}


def test_physical_materials_take_the_wall_of_a_hollow_body(scene, pipe):
    thicken(pipe, 0.005)
    made_physical(scene, pipe, "steel")
    assert pipe.haptics.wave == "bounded"
    assert pipe.haptics.extent == pytest.approx(0.5, rel=0.01)
    assert pipe.haptics.plate_thickness == pytest.approx(0.005, rel=0.1)


def test_the_ground_and_half_spaces_are_the_same_whatever_their_thickness(
    scene, add_box, add_empty, traced
):
    """A slab of 40 m, from 0.1 to 20 m thick: of soil, and of concrete that is marked as a
    half-space."""
    slab = add_box("slab", (0, 0, -0.5), (40, 40, 1))
    for x, role in ((0.0, "source"), (7.0, "listener")):
        getattr(add_empty(role, (x / 40, 0, 0), slab).haptics, role).enabled = True
    found = {"soil": set(), "concrete": set()}
    for name, levels in found.items():
        made_physical(scene, slab, name)
        slab.haptics.wave = "surface"  # what soil has already
        for thickness in (0.1, 1.0, 20.0):
            slab.scale.z, slab.location.z = thickness, -thickness / 2
            bpy.context.view_layer.update()
            bpy.ops.haptic.set_model()
            assert slab.haptics.wave == "surface"
            levels.add(round(20 * math.log10(traced().amplitudes[0, 0]), 3))
    assert all(len(levels) == 1 for levels in found.values()), found


@pytest.mark.parametrize(("name", "pieces"), [("Soil", 1), ("Steel Beam", 1), ("Steel Beam", 4)])
def test_make_haptic_spreads_as_the_body_is(scene, add_box, add_empty, traced, name, pieces):
    """The ground as a half-space, by its formula, from 0.1 to 20 m thick; and a beam of 4 m that is
    no thicker than what a source drives without any spreading, whole and cut into four."""
    for thickness in (0.1, 1.0, 20.0) if name == "Soil" else (0.1, 0.3):
        size = (60.0, 60.0, thickness) if name == "Soil" else (4.0 / pieces, thickness, thickness)
        places = [(size[0] * (k + 0.5 - pieces / 2), 0.0, -thickness / 2) for k in range(pieces)]
        made = [
            add_box(f"{name} {thickness} {k}", place, size, haptic=False)
            for k, place in enumerate(places)
        ]
        ends = [add_empty(role, (x, 0, 0)) for x, role in ((-1.9, "source"), (1.9, "listener"))]
        bpy.context.view_layer.update()
        for end, carrier in zip(ends, (made[0], made[-1]), strict=True):
            end.parent, end.matrix_parent_inverse = carrier, carrier.matrix_world.inverted()
        ends[0].haptics.source.enabled = ends[1].haptics.listener.enabled = True
        ends[0].haptics.source.frequency, ends[1].haptics.listener.radius = BAND_CENTRES[0], 0.0
        bpy.ops.object.select_all(action="DESELECT")
        for obj in made:
            obj.select_set(True)
        assert bpy.ops.haptic.make_objects() == {"FINISHED"}
        level = 20 * math.log10(traced().amplitudes[0, 0])
        spreading = -10 * math.log10(1 + 3.8 / 0.5) if name == "Soil" else 0.0
        damping = 8.686 * 3.8 * read_function(made[0].haptics).material_damping(BAND_CENTRES[0])
        assert level == pytest.approx(spreading - damping, abs=0.1)
        for obj in (*made, *ends):
            bpy.data.objects.remove(obj)
