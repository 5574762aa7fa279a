"""Overlapping bounds against comparing all with all."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts import broad_phase
from haptic_tracing.core.contacts.broad_phase import overlapping_pairs
from hypothesis import given, settings
from hypothesis import strategies as st


def brute_force(bounds, moved=None):
    low, high = bounds[:, 0], bounds[:, 1]
    met = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    if moved is not None:
        met &= moved[:, None] | moved[None]
    return np.argwhere(np.triu(met, 1))


@pytest.mark.parametrize("chunk", [50, 1_000_000])
@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(0, 120),
    spread=st.sampled_from([0.0, 1.0, 10.0, 1e4]),
    size=st.sampled_from([0.0, 0.3, 3.0]),
    share=st.sampled_from([0.0, 0.1, 0.9, 1.0]),
)
def test_pairs_are_those_of_comparing_all_with_all(chunk, seed, count, spread, size, share):
    generator = np.random.default_rng(seed)
    low = np.round(generator.uniform(-spread, spread, (count, 3)), 1)
    extent = np.round(generator.uniform(0, size, (count, 3)), 1)
    if count > 3:
        low[0], extent[0] = -2 * spread, 4 * spread  # a ground under everything
        low[1] = np.nan  # what is left out
    bounds = np.stack([low, low + extent], axis=1)
    moved = generator.random(count) < share
    kept, broad_phase._CHUNK = broad_phase._CHUNK, chunk
    try:
        found = overlapping_pairs(*bounds.transpose(1, 2, 0), moved)
    finally:
        broad_phase._CHUNK = kept
    pairs = np.stack(np.divmod(found, max(count, 1)), axis=1)
    np.testing.assert_array_equal(pairs, brute_force(bounds, moved).reshape(-1, 2))
