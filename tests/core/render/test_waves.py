"""The waves that a timeline shows: columns are the minima and maxima of the samples in them, at
every zoom."""

import numpy as np
import pytest
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.core.render.waves import FULL_SCALE, Waves, threshold_of

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
            np.full(3, -20.0),
        )
    for edges in (np.linspace(-5, 90, 40), np.linspace(20, 30, 400)):
        a, b = whole.columns(edges), pieces.columns(edges)
        assert (a.low == b.low).all() and (a.high == b.high).all() and (a.known == b.known).all()


def test_only_what_was_filled_is_known():
    waves = Waves("a", 1.0, 100.0, np.zeros((1, 1000), dtype=np.int16), filled=False)
    waves.write(300, np.ones((1, 100)), np.zeros(1))
    assert waves.columns(np.arange(0.0, 13.0)).known.tolist() == [k == 4 for k in range(12)]
    waves.write(950, np.ones((1, 100)), np.zeros(1))  # over the end
    waves.write(2000, np.ones((1, 100)), np.zeros(1))  # beyond it
    assert waves.columns(np.arange(0.0, 13.0)).high[0, 10] == FULL_SCALE


def test_the_threshold_of_a_sine_is_that_of_its_frequency_however_strong_it_is():
    time = np.arange(2000) / RATE
    for frequency in (60.0, 250.0):
        sine = np.array([0.3, 0.01])[:, None] * np.sin(2 * np.pi * frequency * time)
        assert threshold_of(sine, RATE) == pytest.approx(float(threshold_level(frequency)), abs=0.2)
    assert np.isnan(threshold_of(np.zeros((1, 2000)), RATE)).all()


def test_impacts_of_a_frame_go_when_it_is_played_again():
    waves = Waves("a", 1.0, 100.0, np.zeros((1, 1000), dtype=np.int16), filled=False)
    for frame in (3.0, 4.5):
        waves.add_impacts(np.array([frame]), np.ones((1, 1)))
    waves.write(300, np.ones((1, 100)), np.zeros(1))
    assert waves.impacts[0].tolist() == [3.0]
