"""Frames of any rate cut time into samples without a gap or an overlap, however their times were
computed."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.core.render.renderer import ListenerMix, Renderer, sample_index
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.signals import Sine

MINUTES_30 = 1800
RATES = [Fraction(24), Fraction(25), Fraction(30_000, 1001), Fraction(60)]


@pytest.mark.parametrize("frames_per_second", RATES)
@pytest.mark.parametrize("sample_rate", [8000, 44_100])
def test_half_an_hour_of_frames(frames_per_second: Fraction, sample_rate: int) -> None:
    count = int(MINUTES_30 * frames_per_second)
    exact = [
        -((-number * sample_rate * frames_per_second.denominator) // frames_per_second.numerator)
        for number in range(count + 1)
    ]
    fps, fps_base = (
        (30.0, 1.001) if frames_per_second.denominator == 1001 else (float(frames_per_second), 1.0)
    )
    begins = [sample_index(number * fps_base / fps, sample_rate) for number in range(count + 1)]
    ends = [
        sample_index((number - 1) * fps_base / fps + 1.0 / (fps / fps_base), sample_rate)
        for number in range(1, count + 1)
    ]
    assert begins == exact
    assert ends == exact[1:]
    assert sum(end - begin for begin, end in zip(begins, ends, strict=False)) == exact[-1]


@pytest.mark.parametrize("frames_per_second", RATES)
def test_rendered_frames_are_one_unbroken_tone(frames_per_second: Fraction) -> None:
    renderer = Renderer([ListenerMix("hand")])
    voice = Voice("tone", Sine(60.0), np.ones(1))
    first = 1790 * frames_per_second
    frames = range(int(first), int(first + 10 * frames_per_second))
    times = [float(number / frames_per_second) for number in (*frames, frames.stop)]
    blocks = [renderer.render_frame(start, end, [voice]) for start, end in pairwise(times)]
    samples = np.concatenate(blocks, axis=1)[0]
    begin, end = (-(-frame * 8000 // frames_per_second) for frame in (frames.start, frames.stop))
    expected = np.sin(2 * np.pi * 60 * (np.arange(int(begin), int(end)) / 8000))
    assert len(samples) == end - begin
    # It fades in over the first frame, and 8 ms to round the corner.
    settled = blocks[0].shape[1] + 64
    assert np.abs(samples - expected)[settled:].max() < 1e-9


def test_a_gap_is_refused_and_a_reset_allows_it() -> None:
    renderer = Renderer([ListenerMix("hand")])
    renderer.render_frame(0.0, 0.04, [])
    with pytest.raises(ValueError, match=r"^start: "):
        renderer.render_frame(0.08, 0.12, [])
    renderer.render_frame(0.04, 0.08, [])
    renderer.reset()
    assert renderer.render_frame(5.0, 5.04, []).shape == (1, 320)


@pytest.mark.parametrize(
    ("start", "end"),
    [(1.0, 0.5), (float("nan"), 1.0), (0.0, float("inf")), (0.0, 100.0), (1e7, 1e7 + 1)],
)
def test_impossible_frames_are_refused(start: float, end: float) -> None:
    with pytest.raises(ValueError, match=r"^end: "):
        Renderer([ListenerMix("hand")]).render_frame(start, end, [])


def test_frames_shorter_than_a_sample() -> None:
    renderer = Renderer([ListenerMix("hand")], 1000.0)
    voice = Voice("tone", Sine(60.0), np.ones(1), onset=0.0)
    blocks = [
        renderer.render_frame(number / 2400, (number + 1) / 2400, [voice]) for number in range(2400)
    ]
    samples = np.concatenate(blocks, axis=1)[0]
    assert np.abs(samples - np.sin(2 * np.pi * 60 * np.arange(1000) / 1000)).max() < 1e-9
