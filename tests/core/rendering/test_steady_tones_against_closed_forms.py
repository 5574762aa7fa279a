"""What makes rendering fast gives the numbers of what is slow: tones on many paths, bands of a
tone, values between samples, the sine."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from haptic_tracing.core.render.filter_bank import bank_reach, bank_response, split_bands
from haptic_tracing.core.render.renderer import ListenerMix, Renderer
from haptic_tracing.core.render.tone_paths import TonePaths
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.signals import Adsr, Noise, Sampled, Signal, Sine
from haptic_tracing.core.signals.interpolation import interpolate, local_polynomials
from haptic_tracing.core.signals.oscillators import sine
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000.0


@given(st.integers(0, 99), st.integers(1, 5), st.integers(1, 6), st.integers(1, 700), st.booleans())
@settings(deadline=None, derandomize=True)
def test_tones_on_many_paths_are_sines_under_sums_of_curves(
    seed: int, listeners: int, voices: int, count: int, alike: bool
) -> None:
    random = np.random.default_rng(seed)
    shape, paths_shape = (listeners, voices), (1 if alike else listeners, voices)
    start, step = random.uniform(-1e5, 1e5, paths_shape), random.uniform(0, 0.5, paths_shape)
    n = np.arange(count)
    factors = random.normal(size=(4, *shape))
    curves = [np.ones(count), n / count, random.normal(size=count // 2 + 1), random.normal(size=1)]
    gains = sum(
        factor[..., None] * np.pad(curve, (0, count - len(curve)))
        for factor, curve in zip(factors, curves, strict=True)
    )
    each = gains * np.sin(2 * np.pi * ((start % 1.0)[..., None] + step[..., None] * n))
    paths = TonePaths(start, step, factors, curves, count)
    scale = np.abs(factors).sum() * 5
    assert np.abs(paths.summed() - each.sum(axis=1)).max() < 1e-10 * scale
    some = list(range(0, listeners, 2))
    assert np.abs(paths.at_listeners(some) - each[some].transpose(1, 0, 2)).max() < 1e-10 * scale


@given(st.floats(1.0, 3999.0))
@settings(deadline=None, derandomize=True)
def test_the_bands_of_a_steady_tone_are_the_tone_times_their_response(frequency: float) -> None:
    reach = bank_reach(RATE)
    samples = np.sin(2 * np.pi * frequency / RATE * np.arange(1000 + 2 * reach))
    bands = split_bands(samples, RATE)
    assert (
        np.abs(bands - bank_response(frequency, RATE)[:, None] * samples[reach:-reach]).max()
        < 1e-11
    )
    assert bank_response(frequency, RATE).sum() == pytest.approx(1.0, abs=1e-15)


@given(st.integers(0, 99), st.lists(st.floats(15.0, 183.9), min_size=1, max_size=20))
@settings(deadline=None, derandomize=True)
def test_polynomials_between_samples_hold_the_kernel(seed: int, positions: list[float]) -> None:
    samples = np.random.default_rng(seed).uniform(-1, 1, (2, 200))
    polynomials = local_polynomials(samples)
    whole = np.floor(positions)
    offset = 2 * (np.array(positions) - whole) - 1
    values = (polynomials[:, whole.astype(int) - 15] * offset[:, None] ** np.arange(9)).sum(axis=2)
    assert np.abs(values - interpolate(samples, np.array(positions))).max() < 3e-6


def test_sine_against_mpmath() -> None:
    random = np.random.default_rng(0)
    cycles = np.concatenate(
        [
            random.uniform(-1, 1, 500),
            random.uniform(-1e5, 1e5, 500),
            np.arange(-8, 9) / 8,
            [1e-300, -0.0],
        ]
    )
    with mpmath.workdps(50):
        exact = np.array(
            [float(mpmath.sin(2 * mpmath.pi * mpmath.mpf(value))) for value in cycles.tolist()]
        )
    assert np.abs(sine(cycles) - exact).max() < 1e-15
    assert np.abs(sine(np.arange(-4, 5) / 2)).max() < 1e-15 and sine(
        np.array([0.25, -0.25])
    ).tolist() == pytest.approx([1, -1], abs=1e-15)


LOADS: list[tuple[Signal, bool, bool]] = [
    (Sine(61.7, 0.9, 0.2), False, False), (Sine(61.7, 0.9, 0.2), True, False), (Sine(61.7), False, True), (Sine(333.3), True, True),
    (Sine(50.0) * Adsr() + Noise(0.2, seed=3), True, True), (Sampled(np.hanning(9000), 5000.0), True, True), (Noise(seed=1), False, True),
]  # fmt: skip


def voices(number: int, place: int) -> list[Voice]:
    """Voices of frame ``number`` whose arrays begin ``place`` doubles after a multiple of 64
    bytes."""
    random = np.random.default_rng(number)
    return [
        Voice(
            key,
            signal,
            aligned(random.uniform(0, 0.3, (10, 6) if banded else (10,)), place),
            onset=0.013 * key,
            amplitude=0.7,
            delays=aligned(random.uniform(0, 0.02, 10), place) if delayed else None,
        )
        for key, (signal, banded, delayed) in enumerate(LOADS)
    ]


def aligned(values: np.ndarray, place: int) -> np.ndarray:
    room = np.empty(values.size + 16)
    begin = (-room.ctypes.data // 8) % 8 + place
    copy = room[begin : begin + values.size].reshape(values.shape)
    copy[:] = values
    assert copy.ctypes.data % 64 == 8 * place
    return copy


LISTENERS = [ListenerMix(f"{method} {limiter}", method, s_max=0.8, limiter=limiter)  # type: ignore[arg-type]
             for method in ("cumulative", "weighted", "strongest", "power") for limiter in (False, True)] + [
                 ListenerMix("a"), ListenerMix("b")]  # fmt: skip


def test_rendering_is_the_same_to_the_last_bit_wherever_arrays_lie_in_memory() -> None:
    runs = []
    for place in (0, 1, 2, 3, 5, 7):
        renderer = Renderer(LISTENERS)
        # What the allocator gives next lies elsewhere, too.
        ballast = [np.empty(101 + 37 * place) for _ in range(place)]
        runs.append(
            np.concatenate(
                [renderer.render_frame(k / 24, (k + 1) / 24, voices(k, place)) for k in range(12)],
                axis=1,
            )
        )
        assert len(ballast) == place
    assert np.abs(runs[0]).max() > 0.5
    for run in runs[1:]:
        assert run.tobytes() == runs[0].tobytes()


def test_a_signal_is_the_same_to_the_last_bit_wherever_frames_begin() -> None:
    """Of one voice at full gain nothing depends on the frames but where they are cut."""
    for signal in (
        Sine(61.7),
        Sine(50.0) * Adsr() + Noise(0.2, seed=3),
        Sampled(np.hanning(9000), 5000.0),
    ):
        voice = Voice("a", signal, np.ones(1), onset=-1.0)
        renderer = Renderer([ListenerMix("hand", s_max=10.0)])
        whole = np.concatenate(
            [renderer.render_frame(k / 24, (k + 1) / 24, [voice]) for k in range(24)], axis=1
        )[0]
        renderer.reset()
        renderer.render_frame(0.30, 0.35, [voice])
        later = np.concatenate(
            [renderer.render_frame(k / 60, (k + 1) / 60, [voice]) for k in range(21, 60)], axis=1
        )[0]
        assert later[64:].tobytes() == whole[2864:].tobytes(), "once it has faded in"
