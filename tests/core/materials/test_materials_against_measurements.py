"""Losses of the library's materials against their published ranges: within them, and in their
order."""

import math
from dataclasses import replace

import pytest
from haptic_tracing.core.scene.functions import Wave
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import DAMPING, SPRINGS, physical

PLATE, ROD, BLOCK = (4.0, 3.0, 0.02), (0.05, 0.05, 5.0), (1.0, 1.0, 1.0)


def loss(loss_factor, speed, frequency, size, ground):
    """Of a wave in a body of like geometry, 1/m: bending waves are slower where the body is thin;
    waves along the ground don't bend."""
    bending = 2 * math.sqrt(1.8 * speed * min(size) * frequency)
    return math.pi * frequency * loss_factor / (speed if ground else min(speed, bending))


def test_every_material_has_numbers_within_their_ranges():
    assert set(DAMPING) | set(SPRINGS) == set(MATERIALS)
    assert not set(DAMPING) & set(SPRINGS)
    for name, damping in DAMPING.items():
        assert damping.loss_range[0] <= damping.loss_factor <= damping.loss_range[1], name
        assert damping.speed_range[0] <= damping.speed <= damping.speed_range[1], name


@pytest.mark.parametrize("frequency", [30.0, 100.0, 300.0])
@pytest.mark.parametrize("size", [PLATE, ROD, BLOCK], ids=["plate", "rod", "block"])
def test_order_of_losses_is_that_of_measurement_wherever_ranges_do_not_overlap(frequency, size):
    ranges, model = {}, {}
    for name, damping in DAMPING.items():
        ends = [
            loss(eta, speed, frequency, size, damping.ground)
            for eta in damping.loss_range
            for speed in damping.speed_range
        ]
        ranges[name] = min(ends), max(ends)
        function = physical(name, size)
        if function.wave is Wave.LIMB:  # the ranges are of waves; a limb moves as a whole besides
            function = replace(function, wave=Wave.BOUNDED)
        model[name] = float(function.damping(frequency, MATERIALS[name].kappa, MATERIALS[name].rho))
        assert ranges[name][0] <= model[name] <= ranges[name][1]
    compared = [(a, b) for a in model for b in model if ranges[a][1] < ranges[b][0]]
    assert len(compared) > 200
    assert [(a, b) for a, b in compared if model[a] >= model[b]] == []


def test_steel_passes_more_than_rubber_at_every_distance():
    """The paper's K exp(-K d) lets them cross at 2.8 m."""
    for distance in (0.1, 1.0, 2.8, 5.0, 50.0):
        steel, rubber = (
            float(
                physical(name, ROD).gain(distance, MATERIALS[name].kappa, MATERIALS[name].rho, 0.1)
            )
            for name in ("steel", "rubber")
        )
        assert steel > rubber


def test_walls_in_place_lose_one_to_three_decibels_per_metre():
    for name in ("concrete", "brick", "plaster"):
        function = physical(name, (6.0, 3.0, 0.2), in_a_building=True)
        for frequency in (150.0, 500.0, 1000.0):
            per_metre = (
                20
                / math.log(10)
                * float(function.damping(frequency, MATERIALS[name].kappa, MATERIALS[name].rho))
            )
            assert 1 <= per_metre <= 3


def test_the_wave_follows_from_material_and_sizes():
    for name, size in (("concrete", (6, 4, 0.2)), ("steel", (0.1, 0.1, 5)), ("stone", (1, 1, 1))):
        function = physical(name, size)
        assert (function.wave, function.thickness, function.extent) == (
            Wave.BOUNDED,
            *sorted(size)[:2],
        )
    for name, size, is_half_space in (
        ("soil", (50, 50, 1), False),
        ("soil", (1, 1, 1), False),
        ("concrete", (90, 90, 0.1), True),
    ):
        assert physical(name, size, is_half_space=is_half_space).wave is Wave.SURFACE


@pytest.mark.parametrize("distance", [0.3, 3.0, 30.0])
def test_the_ground_is_the_same_whatever_its_thickness(distance):
    """From 0.1 to 20 m."""
    for name, is_half_space in (("soil", False), ("gravel", False), ("concrete", True)):
        own = MATERIALS[name].kappa, MATERIALS[name].rho, 0.1
        gains = {
            float(physical(name, (40, 40, h), is_half_space=is_half_space).gain(distance, *own))
            for h in (0.1, 1.0, 5.0, 20.0, 60.0)
        }
        assert len(gains) == 1
