"""Contacts in Blender: by the impedances of bodies, by rules, by the force of a rigid body."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.session import session
from written_scenes import read_scene


@pytest.fixture
def standing(add_box, scene):
    """A source on a floor, a listener on a box upon it."""
    floor, box = add_box("Floor", (0, 0, -0.5), (4, 4, 1)), add_box("Box", (0, 0, 0.5), (1, 1, 1))
    floor.haptics.source.enabled = box.haptics.listener.enabled = True
    for obj in (floor, box):
        obj.haptics.function = "constant"
        obj.haptics.constant = 1.0
    bpy.context.view_layer.update()
    return floor, box


def add_rule(scene, function, **values):
    assert bpy.ops.haptic.add_rule(table="transmission_table") == {"FINISHED"}
    row = scene.haptics.transmission_table.items[-1]
    row.first_kind = "ANY"
    row.second_kind = "ANY"
    row.function = function
    for name, value in values.items():
        setattr(row, name, value)
    bpy.context.view_layer.update()
    return row


def gain(scene):
    return float(session.result_of(scene).propagation.gain[0, 0])


def test_without_impedances_everything_passes(standing, scene):
    assert gain(scene) == pytest.approx(1.0)


def test_without_a_rule_physical_bodies_pass_what_both_can_take(standing, scene):
    """2 Z1 / (Z1 + Z2) from a floor of 8 kg into a box of 40 times that, which simulation moves:
    compact, both are masses in the lowest band."""
    for obj in standing:
        held = obj.haptics
        held.function, held.loss_factor, held.material_k = "physical", 0.0, 0.8
        held.phase_speed, held.density, held.reference_distance = 5000.0, 1000.0, 100.0
        held.length, held.extent, held.plate_thickness = 0.2, 0.2, 0.2
    _, box = standing
    with bpy.context.temp_override(object=box, active_object=box, selected_objects=[box]):
        bpy.ops.rigidbody.object_add()
    box.rigid_body.mass = 320.0
    bpy.context.view_layer.update()
    assert session.result_of(scene).propagation.band_gain[0, 0, 0] == pytest.approx(
        2 / 41, rel=0.01
    )
    add_rule(scene, "identity")
    assert gain(scene) == pytest.approx(1.0)


def test_a_heavier_box_passes_more(standing, scene):
    _, box = standing
    with bpy.context.temp_override(object=box, active_object=box, selected_objects=[box]):
        bpy.ops.rigidbody.object_add()
    box.rigid_body.mass = 2.0
    add_rule(scene, "normal_force", reference=1000.0, exponent=1.0)
    assert gain(scene) == pytest.approx(2.0 * 9.81 / 1000.0, rel=1e-3)
    box.rigid_body.mass = 20.0
    bpy.context.view_layer.update()
    assert gain(scene) == pytest.approx(20.0 * 9.81 / 1000.0, rel=1e-3)


def test_a_formula_of_a_contact_may_use_its_area(standing, scene):
    add_rule(scene, "expression", expression="min(1, area / 4)")
    assert gain(scene) == pytest.approx(0.25, rel=1e-3)


def test_rules_are_written_to_files(standing, scene, tmp_path):
    row = add_rule(scene, "resilient", stiffness=2e4, spring_frequency=8.0)
    row.first_kind, row.first = "OBJECT", "Box"
    path = tmp_path / "scene.json"
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path)) == {"FINISHED"}
    assert session.result_of(scene).contacts.transmissions[-1].frequency == 8.0
    (rule,) = read_scene(path).rules.transmission_table.rows
    assert [side.object for side in rule.between] == ["Box", ""]
    assert (rule.value.name, rule.value.frequency, rule.value.stiffness) == ("resilient", 8.0, 2e4)


def test_two_selected_objects_get_a_rule_of_their_own_that_counts_more_than_any_other(
    standing, scene
):
    for obj in standing:
        obj.select_set(True)
    bpy.ops.haptic.add_rule(table="transmission_table")
    row = scene.haptics.transmission_table.items[0]
    assert (row.first_kind, row.first, row.second_kind, row.second) == (
        "OBJECT",
        "Box",
        "OBJECT",
        "Floor",
    )
    row.function, row.constant = "constant", 0.3
    other = add_rule(scene, "constant", constant=0.9)
    other.first_kind, other.first = "OBJECT", "Floor"
    bpy.context.view_layer.update()
    assert gain(scene) == pytest.approx(0.3)
