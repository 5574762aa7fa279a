"""Materials: enough of them, within their ranges, different from each other; guesses from names,
shapes and masses."""

import math

import pytest
from haptic_tracing.core.scene.bands import BAND_CENTRES, BAND_COUNT
from haptic_tracing.core.scene.functions import HapticTracing, Spectrum
from haptic_tracing.core.scene.materials import MATERIALS, absorption, guess, named_in
from hypothesis import example, given, settings
from hypothesis import strategies as st


def test_there_are_the_materials_that_designers_ask_for():
    wanted = [
        "stone",
        "hardwood",
        "softwood",
        "steel",
        "glass",
        "rubber",
        "soil",
        "sand",
        "concrete",
        "fabric",
        "ribbon",
        "flesh",
        "bone",
        "water",
        "air",
    ]
    assert set(wanted) <= set(MATERIALS)
    assert len(MATERIALS) >= 20


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_values_make_a_function(material):
    assert 0 < material.kappa < 1
    assert 0 < material.rho <= 1
    assert 0.02 < material.k < 0.95
    assert len(material.band_decays) == BAND_COUNT
    function = HapticTracing(
        spectrum=Spectrum(band_decays=material.band_decays, wave_speed=material.wave_speed)
    )
    assert 0 < function.gain(1.0, material.kappa, material.rho, 0.1) < 1
    assert material.words[0] == material.name


def test_no_word_means_two_materials():
    words = [
        word for material in MATERIALS.values() for word in (*material.words, *material.things)
    ]
    assert len(words) == len(set(words))


def test_absorption_is_that_of_a_lossy_plane_wave():
    """exp(i k x) with k = (omega / c) (1 + i eta / 2): the amplitude falls by the imaginary
    part."""
    eta, speed = 0.06, 200.0
    k = 2 * math.pi * 100.0 / (speed * (1 - 1j * eta) ** 0.5)
    assert absorption(eta, speed) == pytest.approx(abs(k.imag) * (1 + eta**2) ** 0.5, rel=5e-3)


def test_bands_fall_with_frequency():
    decays = MATERIALS["rubber"].band_decays
    assert [d / f for d, f in zip(decays, BAND_CENTRES, strict=True)] == pytest.approx(
        [decays[0] / BAND_CENTRES[0]] * BAND_COUNT
    )


@pytest.mark.parametrize(
    ("name", "material"),
    [
        ("Oak Bench.001", "hardwood"), ("rusty_metal_2", "steel"), ("WoodenCrate", "softwood"), ("Steinmauer", None), ("Stein", "stone"),
        ("Ground", "soil"), ("Cube", None), ("Airplane", None), ("Metallic", "steel"), ("GLASS", "glass"), ("Character_Body", "flesh"),
        ("", None),
        ("Floor", "concrete"), ("Wooden Floor", "softwood"), ("Floorboards", "softwood"), ("Fußboden", "concrete"),
        ("Forest Ground", "soil"),
        ("Glass Table", "glass"), ("Oak Plank", "hardwood"), ("Anvil", "steel"), ("Rocky cliff", "stone"), ("tiles.012", "ceramic"),
    ],
)  # fmt: skip
def test_names_tell_the_material(name, material):
    found = named_in(name)
    assert (found.name if found else None) == material


def test_shape_and_mass_tell_where_no_name_does():
    assert guess(["Plane"], (20.0, 10.0, 0.0)).name == "soil"
    assert guess(["Cube"], (1.0, 1.0, 1.0), 7500.0).name == "steel"
    assert guess(["Cube"], (1.0, 1.0, 1.0), 30.0).name == "foam"
    assert guess(["Cube"], (2.0, 2.0, 2.0)) is None
    assert guess(["Cube"]) is None
    assert guess(["Plane", "Old Marble"], (20.0, 10.0, 0.0)).name == "stone"


@settings(derandomize=True, deadline=None)
@example([], (16.0, 3e4, 2e5), 2e-313)
@given(
    st.lists(st.text(max_size=30), max_size=3),
    st.tuples(*[st.floats(0, 1e6)] * 3),
    st.none() | st.floats(0, 1e9),
)
def test_anything_may_be_guessed_at(names, size, mass):
    found = guess(names, size, mass)
    assert found is None or found.name in MATERIALS
