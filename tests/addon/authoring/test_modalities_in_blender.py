"""Warmth in Blender: the properties follow from the modality's data, and what is felt is what the
core says."""

import math

import bpy
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.modalities import MODALITIES, THERMAL
from haptic_tracing.core.modalities.thermal import JOINT
from haptic_tracing.sample_scenes import build_sample


@pytest.fixture
def fireplace(add_box, add_empty, scene):
    """A hearth and a bench of stone that touch; a fire on the one, a listener on the other."""
    hearth, bench = add_box("hearth", (0, 0, 0), (1, 1, 1)), add_box("bench", (1, 0, 0), (1, 1, 1))
    fire, seat = add_empty("fire", (-0.4, 0, 0), hearth), add_empty("seat", (0.4, 0, 0), bench)
    seat.haptics.listener.enabled = True
    fire.haptics.modalities.thermal.is_source = True
    for obj in (hearth, bench):
        obj.haptics.modalities.thermal.conductivity = 2.8
        obj.haptics.modalities.thermal.thickness = 0.3
    scene.haptics.modalities.thermal.enabled = True
    bpy.context.view_layer.update()
    return hearth, bench, fire, seat


def test_warmth_is_felt_through_stone(fireplace, traced, scene):
    traced()
    (felt,) = sessions.felt_in(scene)
    m = math.sqrt(20 / (2.8 * 0.3))
    far = 0.9 + 0.9
    assert felt.values[0] == pytest.approx(
        60 * math.exp(-m * far) * JOINT / (JOINT + 2.8 * m), rel=0.03
    )
    assert felt.paths[0, 0] == ("hearth", "bench")


def test_materials_bring_their_conductivity(fireplace, traced, scene):
    bench = fireplace[1]
    traced()
    stone = sessions.felt_in(scene)[0].values[0]
    bpy.context.view_layer.objects.active = bench
    bench.select_set(True)
    bpy.ops.haptic.apply_material(preset="hardwood")
    traced()
    assert 0 < sessions.felt_in(scene)[0].values[0] < 0.2 * stone


def test_it_costs_nothing_where_it_is_switched_off(fireplace, traced, scene):
    scene.haptics.modalities.thermal.enabled = False
    traced()
    assert sessions.felt_in(scene) == ()


def test_an_expression_that_gives_no_gain_is_a_problem_in_words(fireplace, traced, scene):
    hearth = fireplace[0]
    hearth.haptics.modalities.thermal.function = "expression"
    hearth.haptics.modalities.thermal.expression = "x * foo"
    result = traced()
    assert result is not None
    assert any(
        "Warmth" in problem.message and "foo" in problem.message
        for problem in session.problems_of(scene)
    )


def test_contacts_that_only_warmth_needs_are_found_while_previewing(fireplace, scene):
    session.trace(scene, bpy.context.evaluated_depsgraph_get(), True)
    assert sessions.felt_in(scene)[0].values[0] > 0


@pytest.mark.parametrize("modality", MODALITIES.values(), ids=MODALITIES)
def test_properties_are_those_of_the_data(modality, add_box):
    group = getattr(add_box("box", (0, 0, 0), (1, 1, 1)).haptics.modalities, modality.name)
    for name, quantity in modality.quantities.items():
        found = group.bl_rna.properties[name]
        expected = (modality.defaults()[name], quantity.low, quantity.high)
        assert (found.default, found.hard_min, found.hard_max) == pytest.approx(expected)
    assert [item.identifier for item in group.bl_rna.properties["function"].enum_items] == list(
        modality.functions
    )
    assert group.function == modality.default_function
    assert THERMAL in MODALITIES.values()


@pytest.mark.slow
def test_the_sample_with_a_fire_warms_the_side_that_faces_it():
    build_sample("fireplace")
    bpy.context.scene.frame_set(2)
    assert session.problems_of(bpy.context.scene) == ()
    (felt,) = sessions.felt_in(bpy.context.scene)
    warmth = dict(zip(felt.listeners, felt.values, strict=True))
    assert (
        min(warmth["ear.L"], warmth["upper_leg.L"])
        > 1.2 * max(warmth["upper_back.L"], warmth["middle_back.R"])
        > 0
    )
    assert all(path[:2] == ("Fire", "Air") for path in felt.paths.values())
