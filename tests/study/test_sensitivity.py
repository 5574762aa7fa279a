"""Variations of the ride against the ride whose properties were edited in Blender, and a section's checks against numbers by hand."""

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.study.baking import bake_ride
from haptic_tracing.study.checks import HT, has_pattern, wider_than_distance
from haptic_tracing.study.sensitivity import TUNED, variations

FRAMES = (66, 74)
SECTION = ("x", "Section", 0, 10_000)


def haptic_names(scene):
    return {obj.name for obj in scene.objects if obj.haptics.enabled}


@pytest.mark.slow
def test_tuned_decays_are_those_of_the_scene(mine_ride):
    names = haptic_names(mine_ride)
    for tuned in TUNED:
        own = {name for name in names if tuned.belongs(name)}
        assert own
        assert {round(mine_ride.objects[name].haptics.alpha, 6) for name in own} == {tuned.decay}
    all_tuned = [name for name in names for tuned in TUNED if tuned.belongs(name)]
    assert len(all_tuned) == len(set(all_tuned))


@pytest.mark.slow
@pytest.mark.parametrize("label", ["double", "the paper's function"])
def test_a_variation_is_the_ride_with_edited_properties(mine_ride, label):
    rider = next(one for one in variations() if (one.name, one.label) == ("rider", label))
    _, ((_, varied),) = bake_ride(mine_ride, *FRAMES, variations=[rider])
    parts = [mine_ride.objects[name] for name in haptic_names(mine_ride) if rider.belongs(name)]
    before = [(part.haptics.function, part.haptics.alpha) for part in parts]
    for part in parts:
        part.haptics.function = "haptic_tracing" if label != "double" else "exponential"
        part.haptics.alpha = 6.0
    try:
        edited, _ = bake_ride(mine_ride, *FRAMES)
    finally:
        for part, (function, alpha) in zip(parts, before, strict=True):
            part.haptics.function, part.haptics.alpha = function, alpha
    assert len(varied.soundings) == len(edited.soundings) > 0
    for one, other in zip(varied.soundings, edited.soundings, strict=True):
        assert one.gains == pytest.approx(other.gains, rel=1e-9, abs=1e-12)
    assert varied.renditions[Mode.HT].rms == pytest.approx(edited.renditions[Mode.HT].rms, abs=1e-9)


def test_checks_of_a_section(bake):
    ride = bake(2100, 2130)
    sounding = next(s for s in ride.soundings if s.began)

    def with_gains(gains):
        rows = np.zeros_like(sounding.gains)
        rows[HT, : len(gains)] = gains
        rows[HT, len(gains) :] = gains[-1]
        rows[2] = 0.1
        return replace(ride, soundings=(replace(sounding, gains=rows),))

    assert has_pattern(with_gains([0.1, 0.1]), SECTION).holds is False
    assert has_pattern(with_gains([0.1 * 10 ** (2.9 / 20), 0.1]), SECTION).holds is False
    assert has_pattern(with_gains([0.1 * 10 ** (3.1 / 20), 0.1]), SECTION).holds is True
    assert has_pattern(with_gains([0.1, 0.0]), SECTION).holds is True
    assert wider_than_distance(with_gains([0.9, 0.1]), SECTION).holds is True
    assert wider_than_distance(with_gains([0.1, 0.1]), SECTION).holds is False
