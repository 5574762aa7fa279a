"""A body of measured flesh on objects that keep the paper's function: the default of new bodies, with the paper's one click away."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from haptic_tracing.core.scene.measured import LIMBS
from haptic_tracing.study.physical_scenes import BODIES, FUNCTIONS, PITCHES, body_levels, body_rows

DOCUMENTATION = Path(__file__).parents[3] / "docs" / "functions.md"


@pytest.fixture
def body(add_box):
    box = add_box("Somebody", (0, 0, 0.9), (0.5, 0.3, 1.8), haptic=False)
    bpy.ops.object.select_all(action="DESELECT")
    box.select_set(True)
    bpy.context.view_layer.objects.active = box
    bpy.context.view_layer.update()
    return box


def test_bodies_change_there_and_back_and_nothing_else_does(add_box):
    names = {"Avatar Hand.L": "flesh", "Avatar Toes.L": "flesh", "Floor": "concrete"}
    for number, (name, preset) in enumerate(names.items()):
        box = add_box(name, (number, 0, 0), (0.2, 0.2, 0.4))
        bpy.ops.object.select_all(action="DESELECT")
        box.select_set(True)
        bpy.ops.haptic.apply_material(preset=preset)
    for function in ("physical", "haptic_tracing", "physical"):
        assert bpy.ops.haptic.set_bodies(function=function) == {"FINISHED"}
        functions = {name: bpy.data.objects[name].haptics.function for name in names}
        assert functions == {"Avatar Hand.L": function, "Avatar Toes.L": function, "Floor": "haptic_tracing"}
    for name, part in (("Avatar Hand.L", "hand"), ("Avatar Toes.L", "toes")):
        assert bpy.data.objects[name].haptics.resonance == pytest.approx(LIMBS[part][0])


def test_both_directions_are_one_step_of_undo(body):
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.haptic.add_default_listeners()
    bpy.ops.ed.undo_push(message="body")
    for function, before in (("haptic_tracing", "physical"), ("physical", "haptic_tracing")):
        bpy.ops.haptic.set_bodies(function=function)
        bpy.ops.ed.undo_push(message=function)
        bpy.ops.ed.undo()
        assert bpy.data.objects["Somebody"].haptics.function == before
        bpy.ops.ed.redo()
        assert bpy.data.objects["Somebody"].haptics.function == function


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
    assert (body.haptics.material.name, body.haptics.function) == ("Flesh", "haptic_tracing")
    bpy.ops.haptic.add_default_listeners()
    assert body.haptics.function == "physical"


def test_more_listeners_leave_a_body_as_it_is(body):
    bpy.ops.haptic.add_default_listeners(parts="PAPER")
    bpy.ops.haptic.set_bodies(function="haptic_tracing")
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    assert len(body.children) == 25
    assert body.haptics.function == "haptic_tracing"


@pytest.mark.parametrize("change", ["kappa", "function"])
def test_what_was_chosen_by_hand_stays(body, change):
    body.haptics.enabled = True
    if change == "kappa":
        body.haptics.kappa = 0.4
    else:
        bpy.ops.haptic.apply_material(preset="flesh")
        body.haptics.function = "constant"
    bpy.ops.haptic.add_default_listeners()
    assert body.haptics.function == ("haptic_tracing" if change == "kappa" else "constant")


def test_without_a_body_it_says_so(add_box):
    add_box("Floor", (0, 0, 0), (1, 1, 1)).select_set(True)
    bpy.ops.haptic.apply_material(preset="concrete")
    for function in FUNCTIONS:
        with pytest.raises(RuntimeError, match="made of flesh"):
            bpy.ops.haptic.set_bodies(function=function)


@pytest.mark.slow
def test_the_documentation_has_what_is_felt():
    assert "\n".join(body_rows()) in DOCUMENTATION.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("case", BODIES)
def test_a_measured_body_feels_what_shakes_it(case):
    """Somewhere, from 80 Hz on, and 30 Hz more than with the paper's function; who stands on a floor feels it with the feet alone."""
    paper, measured = body_levels(case)
    names = [obj.haptics.listener.body_part for obj in sorted(bpy.data.objects, key=lambda obj: obj.name) if obj.haptics.listener.enabled]
    high = [pitch >= 80 for pitch in PITCHES]
    assert (measured[high].max(axis=1) > 9).all()
    assert measured[0].max() > paper[0].max(), "30 Hz"
    if "floor" in case:
        feet = [name.startswith("foot") for name in names]
        assert (measured[high][:, feet] > 9).all() and (measured[high][:, [not foot for foot in feet]] < 0).all()
