"""Variations of the ride against the ride whose properties were edited in Blender, and a section's
checks against numbers by hand."""

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.study.baking import bake_ride
from haptic_tracing.study.checks import HT, has_pattern, wider_than_distance
from haptic_tracing.study.sensitivity import CHOSEN, variations

FRAMES = (66, 74)
SECTION = ("x", "Section", 0, 10_000)


def haptic_objects(scene):
    return [obj for obj in scene.objects if obj.haptics.enabled]


@pytest.mark.slow
def test_nothing_of_the_ride_is_tuned(mine_ride):
    """Every object that is no medium has the paper's function with the values of the library's
    preset of its name."""
    presets = {material.title: material for material in MATERIALS.values()}
    solid = [obj for obj in haptic_objects(mine_ride) if not obj.haptics.medium]
    for obj in solid:
        preset = presets[obj.haptics.material.name]
        assert obj.haptics.function == "haptic_tracing"
        assert (obj.haptics.kappa, obj.haptics.rho) == pytest.approx(
            (preset.kappa, preset.rho), rel=1e-6
        )
    assert {obj.haptics.material.name for obj in solid} == {material.title for material in CHOSEN}
    assert mine_ride.haptics.strategy == "auto"
    assert len(mine_ride.haptics.transmission_table.items) == 0


@pytest.mark.slow
def test_a_variation_is_the_ride_with_edited_properties(mine_ride):
    rider = next(
        one for one in variations() if (one.name, one.label) == ("Flesh", "double the loss")
    )
    _, ((_, varied),) = bake_ride(mine_ride, *FRAMES, variations=[rider])
    parts = [obj for obj in haptic_objects(mine_ride) if obj.haptics.material.name == "Flesh"]
    before = [(part.haptics.kappa, part.haptics.rho) for part in parts]
    for part in parts:
        part.haptics.kappa, part.haptics.rho = 0.0, MATERIALS["flesh"].k ** 2
    try:
        edited, _ = bake_ride(mine_ride, *FRAMES)
    finally:
        for part, (kappa, rho) in zip(parts, before, strict=True):
            part.haptics.kappa, part.haptics.rho = kappa, rho
    assert len(varied.soundings) == len(edited.soundings) > 0
    for one, other in zip(varied.soundings, edited.soundings, strict=True):
        assert one.amplitudes == pytest.approx(other.amplitudes, rel=1e-6, abs=1e-12)
    assert varied.renditions[Mode.HT].rms == pytest.approx(edited.renditions[Mode.HT].rms, abs=1e-8)


@pytest.mark.slow
def test_checks_of_a_section(bake):
    ride = bake(2100, 2130)
    sounding = next(s for s in ride.soundings if s.began)

    def with_amplitudes(amplitudes):
        rows = np.zeros_like(sounding.amplitudes)
        rows[HT, : len(amplitudes)] = amplitudes
        rows[HT, len(amplitudes) :] = amplitudes[-1]
        rows[2] = 0.1
        return replace(ride, soundings=(replace(sounding, amplitudes=rows),))

    assert has_pattern(with_amplitudes([0.1, 0.1]), SECTION).holds is False
    assert has_pattern(with_amplitudes([0.1 * 10 ** (2.9 / 20), 0.1]), SECTION).holds is False
    assert has_pattern(with_amplitudes([0.1 * 10 ** (3.1 / 20), 0.1]), SECTION).holds is True
    assert has_pattern(with_amplitudes([0.1, 0.0]), SECTION).holds is True
    assert wider_than_distance(with_amplitudes([0.9, 0.1]), SECTION).holds is True
    assert wider_than_distance(with_amplitudes([0.1, 0.1]), SECTION).holds is False
