"""Losses of the library's materials against their published ranges: within them, and in their order."""

import math
from dataclasses import replace

import pytest
from haptic_tracing.core.scene.functions import Wave
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import DAMPING, physical, wave_in

PLATE, ROD, BLOCK = (4.0, 3.0, 0.02), (0.05, 0.05, 5.0), (1.0, 1.0, 1.0)


def loss(loss_factor, speed, frequency, size):
    """Of a wave in a body of like geometry, 1/m."""
    if size is PLATE:
        return math.pi * frequency * loss_factor / (2 * math.sqrt(1.8 * speed * 0.02 * frequency))
    return math.pi * frequency * loss_factor / speed


def test_every_material_has_numbers_within_their_ranges():
    assert set(DAMPING) == set(MATERIALS)
    for name, damping in DAMPING.items():
        assert damping.loss_range[0] <= damping.loss_factor <= damping.loss_range[1], name
        assert damping.speed_range[0] <= damping.speed <= damping.speed_range[1], name


@pytest.mark.parametrize("frequency", [30.0, 100.0, 300.0])
@pytest.mark.parametrize("size", [PLATE, ROD, BLOCK], ids=["plate", "rod", "block"])
def test_order_of_losses_is_that_of_measurement_wherever_ranges_do_not_overlap(frequency, size):
    ranges, model = {}, {}
    for name, damping in DAMPING.items():
        ends = [loss(eta, speed, frequency, size) for eta in damping.loss_range for speed in damping.speed_range]
        ranges[name] = min(ends), max(ends)
        function = physical(name, size)
        if function.wave is Wave.LIMB:  # the ranges are of waves; a limb moves as a whole besides
            function = replace(function, wave=Wave.PLATE if size is PLATE else Wave.ROD, thickness=0.02)
        if size is PLATE and damping.ground:
            continue  # waves along the ground
        model[name] = float(function.damping(frequency, MATERIALS[name].kappa, MATERIALS[name].rho))
        assert ranges[name][0] <= model[name] <= ranges[name][1]
    compared = [(a, b) for a in model for b in model if ranges[a][1] < ranges[b][0]]
    assert len(compared) > 200
    assert [(a, b) for a, b in compared if model[a] >= model[b]] == []


def test_steel_passes_more_than_rubber_at_every_distance():
    """The paper's K exp(-K d) lets them cross at 2.8 m."""
    for distance in (0.1, 1.0, 2.8, 5.0, 50.0):
        steel, rubber = (
            float(physical(name, ROD).gain(distance, MATERIALS[name].kappa, MATERIALS[name].rho, 0.1)) for name in ("steel", "rubber")
        )
        assert steel > rubber


def test_walls_in_place_lose_one_to_three_decibels_per_metre():
    for name in ("concrete", "brick", "plaster"):
        function = physical(name, (6.0, 3.0, 0.2), in_a_building=True)
        for frequency in (150.0, 500.0, 1000.0):
            per_metre = 20 / math.log(10) * float(function.damping(frequency, MATERIALS[name].kappa, MATERIALS[name].rho))
            assert 1 <= per_metre <= 3


def test_the_wave_follows_from_the_shape():
    assert wave_in("concrete", (6, 4, 0.2)) == (Wave.PLATE, 0.2)
    assert wave_in("steel", (0.1, 0.1, 5)) == (Wave.ROD, 0.1)
    assert wave_in("stone", (1, 1, 1)) == (Wave.SOLID, 1)
    assert wave_in("soil", (50, 50, 1)) == (Wave.SURFACE, 1)
