"""The waves that a timeline shows: columns are the minima and maxima of the samples in them, at
every zoom."""

import numpy as np
import pytest
from haptic_tracing.core.render import lane
from haptic_tracing.core.render.integers import FULL_SCALE
from haptic_tracing.plugins.timeline.waves import Waves, wave_band

RATE, PER_FRAME = 8000.0, 8000 / 24


def noise(listeners, count):
    return (
        np.random.default_rng(1)
        .integers(-FULL_SCALE, FULL_SCALE, (listeners, count))
        .astype(np.int16)
    )


@pytest.mark.parametrize("first, last", [(0, 240), (3.5, 11.25), (100, 100.7), (239, 240)])
def test_a_column_spans_its_samples(first, last):
    samples = noise(2, round(240 * PER_FRAME))
    waves = Waves(("a", "b"), 0.0, PER_FRAME, samples, filled=True)
    edges = np.linspace(first, last, 101)
    found = waves.columns(edges)
    # Samples on either side that may count as well.
    step = 8 ** max(int(np.log(max((edges[1] - edges[0]) * PER_FRAME, 1)) / np.log(8)), 0)
    for k in range(100):
        start, end = edges[k] * PER_FRAME, edges[k + 1] * PER_FRAME
        inner = samples[:, int(np.ceil(start / step)) * step : int(end // step) * step]
        outer = samples[
            :,
            int(start // step) * step : max(
                int(np.ceil(end / step)) * step, int(start // step) * step + step
            ),
        ]
        assert (found.low[:, k] >= outer.min(axis=1)).all() and (
            found.high[:, k] <= outer.max(axis=1)
        ).all()
        if inner.shape[1]:
            assert (found.low[:, k] <= inner.min(axis=1)).all() and (
                found.high[:, k] >= inner.max(axis=1)
            ).all()
    assert found.known.all()


def test_what_is_written_frame_by_frame_is_what_was_there_at_once():
    samples = noise(3, 8000)
    whole = Waves("abc", 1.0, 100.0, samples, filled=True)
    pieces = Waves("abc", 1.0, 100.0, np.zeros_like(samples), filled=False)
    assert not pieces.columns(np.linspace(0, 90, 50)).known.any()
    for number in (*range(40, 80), *range(40)):
        pieces.write(
            100 * number,
            samples[:, 100 * number : 100 * number + 100] / FULL_SCALE,
            np.full(3, -10.0),
            np.full(3, -20.0),
        )
    for edges in (np.linspace(-5, 90, 40), np.linspace(20, 30, 400)):
        a, b = whole.columns(edges), pieces.columns(edges)
        assert (a.low == b.low).all() and (a.high == b.high).all() and (a.known == b.known).all()


def test_only_what_was_filled_is_known():
    waves = Waves("a", 1.0, 100.0, np.zeros((1, 1000), dtype=np.int16), filled=False)
    waves.write(300, np.ones((1, 100)), np.zeros(1), np.zeros(1))
    assert waves.columns(np.arange(0.0, 13.0)).known.tolist() == [k == 4 for k in range(12)]
    waves.write(950, np.ones((1, 100)), np.zeros(1), np.zeros(1))  # over the end
    waves.write(2000, np.ones((1, 100)), np.zeros(1), np.zeros(1))  # beyond it
    assert waves.columns(np.arange(0.0, 13.0)).high[0, 10] == FULL_SCALE


def test_levels_of_a_tone_rise_within_a_quarter_second_and_fall_after_it():
    """A sine of 100 Hz from second 1 to 2, in 25 frames a second."""
    time = np.arange(24000) / RATE
    samples = 0.5 * np.sin(2 * np.pi * 100 * time) * ((time >= 1) & (time < 2))
    waves = Waves("a", 0.0, RATE / 25, np.rint(samples * FULL_SCALE).astype("i2")[None], True)
    waves.find_levels(RATE)
    tone = 20 * np.log10(0.5 / np.sqrt(2))
    ends = (np.arange(75) + 1) / 25
    share = np.clip(np.minimum(ends, 2) - np.maximum(ends - 0.25, 1), 0, 0.25) / 0.25
    with np.errstate(divide="ignore"):
        expected = tone + 10 * np.log10(share)
    np.testing.assert_allclose(waves.level[0], expected, atol=0.05)
    # Columns of many frames show the highest of them.
    assert waves.columns(np.array([0.0, 75.0])).level[0, 0] == pytest.approx(tone, abs=0.01)


def test_bands_are_levels_in_decibels_and_what_is_felt_is_above_the_threshold():
    tone = 0.1 * np.sqrt(2) * np.sin(2 * np.pi * 250 * np.arange(8000) / RATE)
    waves = Waves("a", 0.0, 320.0, np.rint(tone * FULL_SCALE).astype("i2")[None], True)
    waves.find_levels(RATE)
    parts = waves.columns(np.linspace(10, 20, 11))
    felt, threshold, level = lane.bands(parts.level, parts.threshold)
    assert level.low == pytest.approx(1 - 20 / 60, abs=1e-3) and (level.low == level.high).all()
    assert (felt.high == level.high).all() and (felt.low == threshold.low).all()
    assert (threshold.low < level.low).all()
    wave = wave_band(parts)
    peak = 1 + 20 * np.log10(0.1 * np.sqrt(2)) / 60
    assert wave.high.max() == pytest.approx(0.5 + peak / 2, abs=0.01)
    assert wave.low.min() == pytest.approx(0.5 - peak / 2, abs=0.01)


def test_a_steep_wave_is_one_line():
    jump = np.repeat(np.array([[0, FULL_SCALE, 0, -FULL_SCALE]], dtype=np.int16), 50, axis=1)
    waves = Waves("a", 0.0, 50.0, jump, True)
    wave = wave_band(waves.columns(np.linspace(0, 4, 201)))
    assert (wave.low[:, 1:] <= wave.high[:, :-1]).all()
    assert (wave.high[:, 1:] >= wave.low[:, :-1]).all()


def test_impacts_of_a_frame_go_when_it_is_played_again():
    waves = Waves("a", 1.0, 100.0, np.zeros((1, 1000), dtype=np.int16), filled=False)
    for frame in (3.0, 4.5):
        waves.add_impacts(np.array([frame]), np.ones((1, 1)))
    waves.write(300, np.ones((1, 100)), np.zeros(1), np.zeros(1))
    assert waves.impacts[0].tolist() == [3.0]
