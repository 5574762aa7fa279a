"""The library of haptic materials: shared by objects, copied, renamed, removed; applied to what is
chosen."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.authoring import materials as library
from haptic_tracing.addon.session import session
from haptic_tracing.core.render.filter_bank import bank_response
from haptic_tracing.core.render.renderer import SAMPLE_RATE
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import DAMPING, physical


def _select(*objects):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0] if objects else None


@pytest.fixture
def materials(scene):
    return scene.haptics.materials


@pytest.fixture
def boxes(add_box):
    return [add_box(f"box {k}", (k, 0, 0), (1, 1, 1)) for k in range(4)]


def test_every_preset_is_applied_with_its_values(boxes, materials):
    for name, material in MATERIALS.items():
        _select(boxes[0])
        assert bpy.ops.haptic.apply_material(preset=name) == {"FINISHED"}
        haptics = boxes[0].haptics
        assert haptics.material.name == material.title
        assert (haptics.kappa, haptics.rho) == pytest.approx((material.kappa, material.rho))
    assert len(materials.items) == len(MATERIALS)


def test_objects_of_one_material_change_together(boxes, materials):
    _select(*boxes[:3])
    bpy.ops.haptic.apply_material(preset="rubber")
    materials.items["Rubber"].kappa = 0.33
    assert [round(box.haptics.kappa, 5) for box in boxes] == [0.33, 0.33, 0.33, 0.1]
    bpy.ops.wm.context_set_string(data_path="object.haptics.material.name", value="")
    materials.items["Rubber"].kappa = 0.44
    assert [round(box.haptics.kappa, 5) for box in boxes[:2]] == [0.33, 0.44]


def test_a_material_is_applied_to_selected_children_or_collection(boxes, materials, add_empty):
    root = add_empty("root")
    boxes[1].parent = boxes[2].parent = root
    side = bpy.data.collections.new("side")
    bpy.context.scene.collection.children.link(side)
    side.objects.link(boxes[3])
    bpy.context.scene.collection.objects.unlink(boxes[3])
    _select(root)
    bpy.ops.haptic.apply_material(preset="steel", target="CHILDREN")
    _select(boxes[3])
    bpy.ops.haptic.apply_material(preset="glass", target="COLLECTION")
    _select(boxes[0])
    bpy.ops.haptic.apply_material(preset="soil", target="SELECTED")
    assert [box.haptics.material.name for box in boxes] == ["Soil", "Steel", "Steel", "Glass"]
    _select(root)
    with pytest.raises(RuntimeError, match="surface"):
        bpy.ops.haptic.apply_material(preset="steel")


def test_renaming_keeps_objects_and_names_apart(boxes, materials):
    _select(boxes[0])
    bpy.ops.haptic.apply_material(preset="steel")
    _select(boxes[1])
    bpy.ops.haptic.apply_material(preset="glass")
    materials.items["Steel"].name = "Rail"
    assert boxes[0].haptics.material.name == "Rail"
    materials.items["Glass"].name = "Rail"
    assert boxes[1].haptics.material.name == "Rail.001"
    materials.items["Rail"].name = ""
    assert materials.items[0].name == "Rail"


def test_a_removed_material_leaves_its_values(boxes, materials):
    _select(*boxes)
    bpy.ops.haptic.apply_material(preset="cork")
    bpy.ops.haptic.remove_material()
    assert len(materials.items) == 0
    assert all(
        not box.haptics.material.name and box.haptics.rho == pytest.approx(0.4) for box in boxes
    )
    with pytest.raises(RuntimeError, match="Choose a material"):
        bpy.ops.haptic.remove_material()


def test_a_material_is_chosen_by_its_name_in_the_panel(boxes, materials):
    _select(boxes[0])
    bpy.ops.haptic.apply_material(preset="stone")
    boxes[1].haptics.material.name = "Stone"
    assert boxes[1].haptics.kappa == pytest.approx(0.3)


def test_appended_objects_keep_what_they_are_made_of(boxes, materials, tmp_path):
    _select(boxes[0])
    bpy.ops.haptic.apply_material(preset="rubber")
    materials.items["Rubber"].kappa = 0.77
    path = str(tmp_path / "parts.blend")
    bpy.data.libraries.write(path, {boxes[0]})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path) as (_, wanted):
        wanted.objects = ["box 0"]
    box = wanted.objects[0]
    bpy.context.scene.collection.objects.link(box)
    assert (box.haptics.material.name, round(box.haptics.kappa, 5)) == ("Rubber", 0.77)
    _select(box)
    bpy.ops.haptic.new_material()
    assert bpy.context.scene.haptics.materials.items["Rubber"].kappa == pytest.approx(0.77)


def test_delays_are_traced_where_a_material_has_a_wave_speed(boxes, materials, traced):
    boxes[0].haptics.source.enabled = boxes[1].haptics.listener.enabled = True
    _select(*boxes[:2])
    bpy.ops.haptic.apply_material(preset="rubber")
    assert traced().propagation.delay is None
    materials.items["Rubber"].wave_speed = 60.0
    assert traced().propagation.delay is not None


def test_a_change_of_a_material_is_traced(boxes, materials, traced):
    boxes[0].haptics.source.enabled = boxes[1].haptics.listener.enabled = True
    _select(*boxes[:2])
    bpy.ops.haptic.apply_material(preset="steel")
    before = traced().amplitudes[0, 0]
    materials.items["Steel"].rho = 0.3
    assert (
        session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get()).amplitudes[0, 0]
        < before
    )


def test_every_part_of_a_material_is_shared(boxes, materials):
    _select(boxes[0])
    bpy.ops.haptic.new_material()
    item = materials.items[0]
    assert item.name == "box 0"
    item.kappa, item.rho, item.wave_speed = 0.25, 0.5, 123.0
    haptics = boxes[0].haptics
    assert (haptics.kappa, haptics.rho, haptics.wave_speed) == (0.25, 0.5, 123.0)


def test_physical_materials_follow_from_preset_and_size(add_box, traced):
    """A beam of steel and one of rubber, source and listener 4 m apart on each: gains by the closed
    form of a bending rod."""
    for name, preset, y in (("Beam", "steel", 0), ("Hose", "rubber", 5)):
        box = add_box(name, (0, y, 0), (6, 0.1, 0.1))
        _select(box)
        bpy.ops.haptic.apply_material(preset=preset)
        for role, x in (("source", -2), ("listener", 2)):
            empty = bpy.data.objects.new(f"{name} {role}", None)
            bpy.context.scene.collection.objects.link(empty)
            empty.parent, empty.location = box, (x / 6, 0, 0)  # the beam is scaled by 6
            getattr(empty.haptics, role).enabled = True
            empty.haptics.listener.radius = 0.0
    assert bpy.ops.haptic.set_model() == {"FINISHED"}
    result = traced()
    names = (
        [source.name for source in result.sources],
        [listener.name for listener in result.listeners],
    )
    # A new source emits 60 Hz. Steel loses less than half a decibel over ten metres, and therefore
    # passes all bands like the lowest one.
    for name, preset, centres in (
        ("Beam", "steel", BAND_CENTRES[:1] * 6),
        ("Hose", "rubber", BAND_CENTRES),
    ):
        damping, haptics = DAMPING[preset], bpy.data.objects[name].haptics
        assert haptics.wave == "bounded"
        assert (haptics.extent, haptics.plate_thickness) == pytest.approx((0.1, 0.1))
        bending = 2 * np.sqrt(1.8 * damping.speed * 0.1 * np.array(centres))
        alpha = np.pi * np.array(centres) * damping.loss_factor / np.minimum(bending, damping.speed)
        gain = result.amplitudes[
            names[0].index(f"{name} source"), names[1].index(f"{name} listener")
        ]
        assert gain == pytest.approx(
            bank_response(60.0, SAMPLE_RATE) @ np.exp(-4 * alpha), rel=1e-5
        )


def test_physical_flesh_has_the_resonance_of_the_part_that_it_is_named_after(add_box):
    for name, size, wave, resonance in (
        ("Avatar Hand.L", (0.1, 0.1, 0.2), "limb", 30),
        ("Avatar Lower Leg.R", (0.1, 0.1, 0.4), "limb", 25),
        ("Body", (0.4, 0.3, 1.8), "limb", 15),
        ("Lump", (0.4, 0.3, 0.3), "limb", 20),
        ("Forearm Skin", (0.3, 0.1, 0.003), "surface", 20),
    ):
        box = add_box(name, (0, 0, 0), size)
        _select(box)
        bpy.ops.haptic.apply_material(preset="flesh")
        bpy.ops.haptic.set_model()
        assert (box.haptics.wave, box.haptics.resonance) == (wave, resonance)


SIZES = {
    "Oak Beam": (4.0, 0.2, 0.2),
    "Concrete Floor": (6.0, 5.0, 0.2),
    "Soil": (9.0, 9.0, 1.0),
    "Thing": (0.3, 0.2, 0.1),
}
PRESETS = {"Oak Beam": "hardwood", "Concrete Floor": "concrete", "Soil": "soil", "Thing": "plastic"}


def _selected_boxes(add_box, sizes):
    boxes = {
        name: add_box(name, (10 * k, 0, 0), size, haptic=False)
        for k, (name, size) in enumerate(sizes.items())
    }
    bpy.context.view_layer.update()
    for box in boxes.values():
        box.select_set(True)
    return boxes


@pytest.mark.parametrize("guess", [True, False])
def test_what_is_made_haptic_is_physical(add_box, guess):
    """A thing of unknown material counts as plastic."""
    boxes = _selected_boxes(add_box, SIZES)
    bpy.ops.haptic.make_objects(guess=guess)
    for name, box in boxes.items():
        material = MATERIALS[PRESETS[name] if guess else "plastic"]
        haptics, expected = box.haptics, physical(material.name, SIZES[name])
        assert (haptics.function, haptics.wave) == ("physical", expected.wave)
        assert haptics.material.name == material.title
        assert (haptics.loss_factor, haptics.extent) == pytest.approx(
            (expected.loss_factor, expected.extent), rel=1e-6
        )
        assert haptics.material_k == pytest.approx((1 - haptics.kappa) * haptics.rho)
    assert not bpy.context.scene.haptics.transmission_table.items


def test_a_scene_as_in_the_paper_makes_what_the_paper_has(add_box, scene):
    bpy.ops.haptic.set_model(model="PAPER")
    boxes = _selected_boxes(add_box, {**SIZES, "Human": (0.5, 0.3, 1.8)})
    bpy.ops.haptic.make_objects()
    assert {box.haptics.function for box in boxes.values()} == {"haptic_tracing"}
    assert (
        scene.haptics.strategy == "as_in_the_paper" and not scene.haptics.transmission_table.items
    )


def test_another_material_brings_its_damping(add_box):
    """Soil is a half-space, what is made of something else is not; a function that was chosen
    stays."""
    (box,) = _selected_boxes(add_box, {"Soil": (9.0, 9.0, 1.0)}).values()
    bpy.ops.haptic.make_objects()
    assert box.haptics.wave == "surface"
    bpy.ops.haptic.apply_material(preset="steel")
    assert (box.haptics.wave, box.haptics.loss_factor) == (
        "bounded",
        pytest.approx(DAMPING["steel"].loss_factor),
    )
    box.haptics.function = "constant"
    bpy.ops.haptic.apply_material(preset="rubber")
    assert box.haptics.function == "constant"


@pytest.mark.parametrize(
    ("name", "stiffness"),
    [("Car Tyre", 2e5), ("Felt", 5e5 * 0.2 * 0.2 / 0.1), ("Sofa", 4e4 * 0.2 * 0.2 / 0.1)],
)
def test_a_spring_is_as_stiff_as_its_material(add_box, name, stiffness):
    """A layer by its modulus: E A / t."""
    (spring,) = _selected_boxes(add_box, {name: (0.2, 0.2, 0.1)}).values()
    bpy.ops.haptic.make_objects()
    assert spring.haptics.function == "resilient"
    assert spring.haptics.stiffness == pytest.approx(stiffness, rel=1e-4)
    bpy.ops.haptic.apply_material(preset="steel")
    assert spring.haptics.function == "physical"


def _made(*names):
    """The library's materials of the objects of these names after *Make Haptic*."""
    _select(*(bpy.data.objects[name] for name in names))
    bpy.context.view_layer.update()
    bpy.ops.haptic.make_objects()
    return [bpy.data.objects[name].haptics.material.name for name in names]


def test_nothing_of_a_robot_is_taken_for_flesh(add_box, scene):
    """Parts as files of simulators name them, parented or in a collection of their own; a person
    in the same scene is."""
    add_box("base_link", (0, 0, 0), (0.2, 0.2, 0.2), haptic=False)
    hand = add_box("panda_hand", (0, 0, 1), (0.1, 0.1, 0.1), haptic=False)
    hand.parent = bpy.data.objects["base_link"]
    quadruped = bpy.data.collections.new("a1")
    scene.collection.children.link(quadruped)
    for name in ("FR_thigh_link", "FR upper leg"):
        leg = add_box(name, (2, 0, 0), (0.1, 0.1, 0.4), haptic=False)
        scene.collection.objects.unlink(leg)
        quadruped.objects.link(leg)
    for k, name in enumerate(("Human", "Table", "Wall")):
        add_box(name, (5 + k, 0, 0), (0.5, 0.3, 1.8), haptic=False)
    assert _made("panda_hand", "FR upper leg", "Human") == ["Plastic", "Plastic", "Flesh"]


def test_the_table_of_names_is_asked_first_and_edited_once(add_box, scene):
    """Blender materials that tell nothing stand for what the table says, also for objects made
    later; then names of objects and meshes, then of collections."""
    code = bpy.data.materials.new("MAT_0817")
    for k in range(3):
        box = add_box(f"Human {k}", (k, 0, 0), (0.5, 0.3, 1.8), haptic=False)
        box.data.materials.append(code)
    assert _made("Human 0") == ["Flesh"]
    library.list_names(scene, [box])
    (row,) = scene.haptics.materials.names
    assert (row.name, row.preset) == ("MAT_0817", "NONE")
    row.preset = "glass"
    assert _made("Human 1", "Human 2") == ["Glass", "Glass"]
    _select(bpy.data.objects["Human 0"])
    assert bpy.ops.haptic.guess_material(match=True) == {"FINISHED"}
    assert bpy.data.objects["Human 0"].haptics.material.name == "Glass"
    oak = bpy.data.collections.new("Oak furniture")
    scene.collection.children.link(oak)
    oak.objects.link(add_box("Cube", (0, 4, 0), (1, 1, 1), haptic=False))
    assert _made("Cube") == [MATERIALS["hardwood"].title]
