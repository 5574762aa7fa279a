"""The band filters against direct convolution, and their sum against the signal."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.render.filter_bank import bank_reach, low_pass, split_bands
from haptic_tracing.core.scene.bands import BAND_CENTRES, BAND_COUNT, BAND_EDGES
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000.0


@pytest.mark.parametrize("rate", [100.0, 1000.0, 8000.0, 48_000.0])
def test_bands_are_differences_of_convolutions_and_add_up(rate: float) -> None:
    reach = bank_reach(rate)
    samples = np.random.default_rng(0).normal(size=3000 + 2 * reach)
    bands = split_bands(samples, rate)
    assert bands.shape == (BAND_COUNT, 3000)
    low = [np.convolve(samples, low_pass(edge, rate), "valid") for edge in BAND_EDGES[1:-1]]
    expected = np.diff([np.zeros(3000), *low, samples[reach : reach + 3000]], axis=0)
    assert np.abs(bands - expected).max() < 1e-12
    assert np.abs(bands.sum(axis=0) - samples[reach : reach + 3000]).max() < 1e-12


def tone_levels(frequency: float) -> np.ndarray:
    reach = bank_reach(RATE)
    tone = np.sin(2 * np.pi * frequency * np.arange(-reach, 16_000 + reach) / RATE)
    return np.abs(split_bands(tone, RATE)).max(axis=1)


@pytest.mark.parametrize("band", range(BAND_COUNT))
def test_a_tone_at_a_bands_centre_is_in_that_band(band: int) -> None:
    levels = tone_levels(BAND_CENTRES[band])
    assert levels[band] > 0.8
    assert np.delete(levels, band).max() < 0.21


@pytest.mark.parametrize("edge", BAND_EDGES[1:-1])
def test_a_tone_at_an_edge_is_halved(edge: float) -> None:
    levels = tone_levels(edge)
    index = BAND_EDGES.index(edge)
    assert levels[[index - 1, index]] == pytest.approx([0.5, 0.5], abs=0.01)
    assert np.delete(levels, [index - 1, index]).max() < 0.02


def test_what_lies_outside_belongs_to_the_outer_bands() -> None:
    assert tone_levels(5.0)[0] > 0.99
    assert tone_levels(3000.0)[-1] > 0.99


@given(st.integers(1, 900), st.integers(0, 99))
@settings(deadline=None)
def test_blocks_give_the_same_bands(cut: int, seed: int) -> None:
    reach = bank_reach(RATE)
    samples = np.random.default_rng(seed).normal(size=1000 + 2 * reach)
    whole = split_bands(samples, RATE)
    parts = [split_bands(samples[: cut + 2 * reach], RATE), split_bands(samples[cut:], RATE)]
    assert np.abs(np.concatenate(parts, axis=1) - whole).max() < 1e-12
