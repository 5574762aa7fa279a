"""Noise against published outputs of SplitMix64 and against what uniform random numbers are."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.signals import Noise
from haptic_tracing.core.signals.noise import splitmix64

# The outputs that Vigna's reference splitmix64.c gives for these seeds, as used to test many ports
# of it.
PUBLISHED = {
    1234567: (
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ),
    0: (0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F, 0xF88BB8A8724C81EC),
}


@pytest.mark.parametrize("seed", PUBLISHED)
def test_published_outputs(seed: int) -> None:
    expected = PUBLISHED[seed]
    assert splitmix64(seed, np.arange(len(expected), dtype=np.uint64)).tolist() == list(expected)


def test_samples_on_the_grid_are_the_hash() -> None:
    expected = (splitmix64(7, np.arange(1000, dtype=np.uint64)) >> np.uint64(11)).astype(
        float
    ) * 2.0**-52 - 1.0
    assert np.abs(Noise(0.5, seed=7).sample(0, 1000, 8000.0) - 0.5 * expected).max() < 1e-9


def test_uniform_and_white() -> None:
    samples = Noise(seed=3).sample(0, 1 << 17, 8000.0)
    assert abs(samples.mean()) < 0.01
    assert samples.var() == pytest.approx(1 / 3, rel=0.01)
    spectrum = np.abs(np.fft.rfft(samples)) ** 2
    parts = np.array([part.mean() for part in np.array_split(spectrum[1:], 16)])
    assert (np.abs(parts / parts.mean() - 1) < 0.06).all()


def test_straight_lines_between_values() -> None:
    slow = Noise(seed=11, rate=100.0).sample(0, 8001, 8000.0)
    keys = slow[::80]
    assert np.abs(slow - np.interp(np.arange(8001), np.arange(101) * 80, keys)).max() < 1e-12


def test_seeds_differ() -> None:
    first, second = (Noise(seed=seed).sample(0, 8000, 8000.0) for seed in (1, 2))
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.05


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("seed", -1),
        ("seed", 2**64),
        ("seed", 1.5),
        ("rate", 0.0),
        ("rate", 1e6),
        ("amplitude", 1e9),
    ],
)
def test_bad_arguments_are_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        Noise(**{name: value})  # type: ignore[arg-type]
