"""A body of measured flesh on objects that keep the paper's function."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.perception import sensation_level
from haptic_tracing.core.render.history import still_samples
from haptic_tracing.core.scene.measured import LIMBS
from haptic_tracing.study.physical_scenes import BODIES, body_levels, body_rows

FUNCTIONS = Path(__file__).parents[3] / "docs" / "functions.md"


def test_the_measured_body_leaves_all_else_alone(add_box):
    names = {"Avatar Hand.L": "flesh", "Avatar Toes.L": "flesh", "Floor": "concrete"}
    for number, (name, preset) in enumerate(names.items()):
        box = add_box(name, (number, 0, 0), (0.2, 0.2, 0.4))
        bpy.ops.object.select_all(action="DESELECT")
        box.select_set(True)
        bpy.ops.haptic.apply_material(preset=preset)
    paper = bpy.data.objects["Floor"].haptics.function
    assert bpy.ops.haptic.physical_materials(bodies=True) == {"FINISHED"}
    functions = {name: bpy.data.objects[name].haptics.function for name in names}
    assert functions == {"Avatar Hand.L": "physical", "Avatar Toes.L": "physical", "Floor": paper} and paper != "physical"
    for name, part in (("Avatar Hand.L", "hand"), ("Avatar Toes.L", "toes")):
        assert bpy.data.objects[name].haptics.resonance == pytest.approx(LIMBS[part][0])


def test_without_a_body_it_says_so(add_box):
    add_box("Floor", (0, 0, 0), (1, 1, 1)).select_set(True)
    bpy.ops.haptic.apply_material(preset="concrete")
    with pytest.raises(RuntimeError, match="made of flesh"):
        bpy.ops.haptic.physical_materials(bodies=True)


@pytest.mark.slow
def test_the_documentation_has_what_is_felt():
    assert "\n".join(body_rows()) in FUNCTIONS.read_text(encoding="utf-8")


@pytest.mark.slow
def test_feet_feel_the_floor_that_legs_take_away():
    measured = body_levels("parts stand on the floor")[1]
    assert (measured < 0).all() and len(BODIES) == 4
    foot = bpy.data.objects["Avatar Foot.L"]
    foot.haptics.listener.enabled = True
    source = bpy.data.objects["Steel Shaker"].haptics.source
    for pitch in (80, 150, 250):
        source.frequency = pitch
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        bpy.context.view_layer.update()
        result = session.result_of(bpy.context.scene)
        number = [listener.name for listener in result.listeners].index(foot.name)
        assert np.asarray(sensation_level(still_samples(result, 1.0), result.sample_rate))[number] > 10
