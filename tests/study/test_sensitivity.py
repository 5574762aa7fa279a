"""Variations of the ride against the ride whose properties were edited in Blender, and a section's
checks against numbers by hand."""

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.study.baking import bake_ride
from haptic_tracing.study.checks import HT, has_pattern, wider_than_distance
from haptic_tracing.study.rendition import MODES
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
    assert mine_ride.haptics.strategy == "best_path"
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

    def with_margins(margins):
        amplitudes = np.full_like(sounding.amplitudes, 10 ** ((20 - sounding.loudness) / 20))
        wanted = np.resize(margins, amplitudes.shape[1])
        amplitudes[HT] = 10 ** ((wanted - sounding.loudness) / 20)
        # At 100 Hz three of four people notice 3.74 dB, whichever study is right.
        changed = replace(sounding, amplitudes=amplitudes, hertz=100.0)
        return replace(ride, soundings=(changed,))

    assert has_pattern(with_margins([10.0, 10.0]), SECTION).holds is False
    assert has_pattern(with_margins([10.0, 13.5]), SECTION).holds is False
    assert has_pattern(with_margins([10.0, 14.0]), SECTION).holds is True
    # What isn't felt counts as if it were at the threshold.
    assert has_pattern(with_margins([3.0, -20.0]), SECTION).holds is False
    assert has_pattern(with_margins([5.0, -20.0]), SECTION).holds is True
    assert has_pattern(with_margins([-1.0, -20.0]), SECTION).holds is False
    assert wider_than_distance(with_margins([30.0, 1.0]), SECTION).holds is True
    assert wider_than_distance(with_margins([10.0, 10.0]), SECTION).holds is False
    assert wider_than_distance(with_margins([-10.0, -20.0]), SECTION).holds is False


@pytest.mark.slow
def test_what_was_arranged_varies(mine_ride):
    """Blows as strong as in the paper are weaker by the ratio of the energies in all modes, and
    distances in the ground make what comes through it weaker or stronger."""
    chosen = [one for one in variations() if one.within == "Ground" or one.full_energy == 100.0]
    own, varied = bake_ride(mine_ride, *FRAMES, variations=chosen)
    fall = next(s for s in own.soundings if s.began and any("Stalactite" in o for o in s.objects))
    assert fall.amplitude == 1  # of 40 J or more
    found = {}
    for variation, ride in varied:
        same = next(s for s in ride.soundings if s.began and s.objects == fall.objects)
        found[variation.label] = same.amplitudes / np.where(fall.amplitudes, fall.amplitudes, 1.0)
        felt = ride.renditions[Mode.MD].rms / own.renditions[Mode.MD].rms.max()
        assert felt.max() == pytest.approx(found[variation.label][MODES.index(Mode.MD), 0])
    weaker = found["100 J"][fall.amplitudes > 0]
    assert np.ptp(weaker) < 1e-9 and 0.4 <= weaker[0] < 1
    assert (found["half"][HT] > 1).all() and (found["double"][HT] < 1).all()


@pytest.mark.slow
def test_a_weaker_wind_is_weaker_in_all_modes(mine_ride):
    """By its factor, and impacts not at all."""
    half = next(one for one in variations() if one.strength == 0.5)
    own, ((_, varied),) = bake_ride(mine_ride, 800, 806, variations=[half])
    assert {s.name for s in own.soundings} == {s.name for s in varied.soundings} == {"Wind"}
    for mode in (Mode.MD, Mode.MN):
        assert varied.renditions[mode].rms == pytest.approx(own.renditions[mode].rms / 2)
    for one, other in zip(varied.soundings, own.soundings, strict=True):
        assert one.amplitudes == pytest.approx(other.amplitudes / 2)
