"""Design by Wish chooses materials so that listeners have the wished levels, says what can't be
met, and is one step of undo."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.render.history import still_samples


@pytest.fixture
def row(add_box, scene):
    """A hum, and two listeners on boxes beside it, of a material each."""
    boxes = [
        add_box(name, (k, 0, 0), (1, 1, 1)) for k, name in enumerate(("Motor", "Plank", "Pad"))
    ]
    boxes[0].haptics.source.enabled = True
    boxes[0].haptics.source.frequency = 60.0
    for obj, preset in zip(boxes, ("steel", "softwood", "rubber"), strict=True):
        with bpy.context.temp_override(selected_objects=[obj], object=obj, active_object=obj):
            bpy.ops.haptic.apply_material(preset=preset)
    for obj in boxes[1:]:
        obj.haptics.listener.enabled = True
        obj.haptics.listener.use_wish = True
    bpy.context.view_layer.update()
    return boxes


def levels(scene):
    """By their definition: the root of the mean square of a quarter second, in decibels of full
    scale."""
    import numpy as np

    bpy.context.view_layer.update()
    return (
        10 * np.log10((still_samples(session.result_of(scene), 0.25) ** 2).mean(axis=1))
    ).tolist()


def test_levels_become_what_is_wished(row, scene):
    plank, pad = (obj.haptics.listener for obj in row[1:])
    names = [item.name for item in session.result_of(scene).listeners]
    before = dict(zip(names, levels(scene), strict=True))
    plank.wish, pad.wish = before["Plank"] - 4.0, before["Pad"] - 1.0
    for item in scene.haptics.materials.items:
        item.is_free = item.name in ("Softwood", "Rubber")
    assert bpy.ops.haptic.design_by_wish() == {"FINISHED"}
    after = dict(zip(names, levels(scene), strict=True))
    assert after["Plank"] == pytest.approx(plank.wish, abs=0.3)
    assert after["Pad"] == pytest.approx(pad.wish, abs=0.3)
    assert scene.haptics.materials.items["Steel"].kappa == pytest.approx(0.10)


def test_bounds_hold_and_what_can_not_be_met_is_said(row, scene, capfd):
    row[1].haptics.listener.use_wish = False
    row[2].haptics.listener.wish = 0.0
    rubber = scene.haptics.materials.items["Rubber"]
    rubber.is_free, rubber.most_k = True, 0.3
    assert bpy.ops.haptic.design_by_wish() == {"FINISHED"}
    assert (1 - rubber.kappa) * rubber.rho <= 0.3 + 1e-6
    assert "0 of 1 wishes are met; off by: Pad -" in capfd.readouterr().out


def test_without_a_wish_or_a_free_material_nothing_changes(row, scene):
    assert bpy.ops.haptic.design_by_wish() == {"CANCELLED"}
