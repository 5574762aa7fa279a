"""Bodies of flesh: measured by default, or felt all over."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import LIMBS
from haptic_tracing.study.physical_scenes import (
    BODIES,
    PITCHES,
    WAYS_OF_BODIES,
    body_levels,
    body_rows,
)

CLEARLY = 6.0
"""Decibels above the threshold of feeling that *Make It Felt* aims at."""
DOCUMENTATION = Path(__file__).parents[3] / "docs" / "physical.md"


@pytest.fixture
def body(add_box):
    box = add_box("Somebody", (0, 0, 0.9), (0.5, 0.3, 1.8), haptic=False)
    bpy.ops.object.select_all(action="DESELECT")
    box.select_set(True)
    bpy.context.view_layer.objects.active = box
    bpy.context.view_layer.update()
    return box


def test_bodies_change_there_and_back_and_nothing_else_does(add_box):
    loss = MATERIALS["flesh"].absorption
    names = {"Avatar Hand.L": "flesh", "Avatar Toes.L": "flesh", "Floor": "concrete"}
    for number, (name, preset) in enumerate(names.items()):
        box = add_box(name, (number, 0, 0), (0.2, 0.2, 0.4))
        bpy.ops.object.select_all(action="DESELECT")
        box.select_set(True)
        bpy.ops.haptic.apply_material(preset=preset)
    for body, absorption in (("MEASURED", 0.0), ("FELT_ALL_OVER", loss), ("MEASURED", 0.0)):
        assert bpy.ops.haptic.set_bodies(body=body) == {"FINISHED"}
        found = {
            name: (
                bpy.data.objects[name].haptics.function,
                bpy.data.objects[name].haptics.absorption,
            )
            for name in names
        }
        flesh = "physical", pytest.approx(absorption)
        assert found == {
            "Avatar Hand.L": flesh,
            "Avatar Toes.L": flesh,
            "Floor": ("haptic_tracing", 0.0),
        }
    for name, part in (("Avatar Hand.L", "hand"), ("Avatar Toes.L", "toes")):
        assert bpy.data.objects[name].haptics.resonance == pytest.approx(LIMBS[part][0])


def test_both_directions_are_one_step_of_undo(body):
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.haptic.add_default_listeners()
    bpy.ops.ed.undo_push(message="body")
    for model, function in (("PAPER", "haptic_tracing"), ("PHYSICAL", "physical")):
        before = _model()
        bpy.ops.haptic.set_model(model=model)
        bpy.ops.ed.undo_push(message=model)
        bpy.ops.ed.undo()
        assert _model() == before
        bpy.ops.ed.redo()
        assert _model() == ("best_path" if model == "PHYSICAL" else "as_in_the_paper", function)


def _model():
    haptics = bpy.context.scene.haptics
    return haptics.strategy, bpy.data.objects["Somebody"].haptics.function


def test_a_new_body_is_measured(body):
    bpy.ops.haptic.add_default_listeners()
    assert (body.haptics.function, body.haptics.resonance) == ("physical", LIMBS["body"][0])


def test_a_new_body_in_a_scene_as_in_the_paper_is_the_papers(body, scene):
    scene.haptics.strategy = "as_in_the_paper"
    bpy.ops.haptic.add_default_listeners()
    assert (body.haptics.material.name, body.haptics.function) == ("Flesh", "haptic_tracing")


def test_the_order_of_buttons_does_not_matter(body):
    body.name = "Human"
    bpy.ops.haptic.make_objects()
    assert (body.haptics.material.name, body.haptics.function) == ("Flesh", "physical")
    bpy.ops.haptic.add_default_listeners()
    assert (body.haptics.function, body.haptics.resonance) == ("physical", LIMBS["body"][0])


def test_more_listeners_leave_a_body_as_it_is(body):
    bpy.ops.haptic.add_default_listeners(parts="PAPER")
    bpy.ops.haptic.set_bodies(body="FELT_ALL_OVER")
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    assert len(body.children) == 25
    assert body.haptics.loss_factor == 0.0


@pytest.mark.parametrize("change", ["kappa", "function"])
def test_what_was_chosen_by_hand_stays(body, change):
    body.haptics.enabled = True
    if change == "kappa":
        body.haptics.kappa = 0.4
    else:
        bpy.ops.haptic.apply_material(preset="flesh")
        body.haptics.function = "constant"
    bpy.ops.haptic.add_default_listeners()
    expected = ("physical", 0.4) if change == "kappa" else ("constant", 0.25)
    assert (body.haptics.function, body.haptics.kappa) == (expected[0], pytest.approx(expected[1]))


def test_without_a_body_it_says_so(add_box):
    add_box("Floor", (0, 0, 0), (1, 1, 1)).select_set(True)
    bpy.ops.haptic.apply_material(preset="concrete")
    for body in WAYS_OF_BODIES:
        with pytest.raises(RuntimeError, match="made of flesh"):
            bpy.ops.haptic.set_bodies(body=body)


@pytest.mark.slow
def test_the_documentation_has_what_is_felt():
    assert "\n".join(body_rows()) in DOCUMENTATION.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("case", BODIES)
def test_a_measured_body_feels_what_shakes_it(case):
    """Somewhere clearly, from 80 Hz on, or from 250 Hz on a floor of concrete, which is far heavier
    than what shakes it, and then with the feet alone."""
    measured, all_over = body_levels(case)
    names = [
        obj.haptics.listener.body_part
        for obj in sorted(bpy.data.objects, key=lambda obj: obj.name)
        if obj.haptics.listener.enabled
    ]
    high = [pitch >= (250 if "floor" in case else 80) for pitch in PITCHES]
    assert (measured[high].max(axis=1) > CLEARLY).all()
    assert (all_over >= measured - 0.1)[high].all()
    if "floor" in case:
        feet = [name.startswith("foot") for name in names]
        assert (measured[high][:, feet] > CLEARLY).all() and (
            measured[high][:, [not foot for foot in feet]] < 0
        ).all()
