"""The timeline of touch shows what was baked: waves, impacts at their frames, rows that fit the
region."""

from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.bake.baking import bake_job
from haptic_tracing.addon.bake.waves import computed
from haptic_tracing.addon.view.lane_layout import rows_of, threshold_strip, wave_strip
from haptic_tracing.core.render.waves import FULL_SCALE, Columns
from haptic_tracing.sample_scenes import build_sample


@pytest.mark.slow
def test_baked_waves_have_the_samples_and_impacts_of_the_track():
    scene = build_sample("hammer_nail")
    scene.haptics.bake.use_range, scene.haptics.bake.frame_end = True, 30
    baking = bake_job(scene)
    while baking.advance(1.0) is None:
        pass
    track = storage.track_of(scene)
    waves = computed(track)
    assert waves.listeners == tuple(item.name for item in track.listeners)
    # A frame's samples lead up to it.
    for number in range(track.frame_start + 1, track.frame_end + 1):
        block, found = (
            track.result(number).block * FULL_SCALE,
            waves.columns(np.array([number - 1.0, number])),
        )
        assert (found.low[:, 0] <= np.rint(block.min(axis=1))).all() and (
            found.high[:, 0] >= np.rint(block.max(axis=1))
        ).all()
    onsets = [
        scene.frame_start + item.onset * scene.render.fps
        for item in track.sources
        if item.second_object
    ]
    assert onsets and sorted(waves.impacts[0]) == pytest.approx(sorted(onsets))
    assert (
        np.isnan(waves.threshold[:, : int(min(onsets)) - 8]).all()
        and np.isfinite(waves.threshold).any()
    )


def test_rows_stay_in_their_part_of_the_region():
    names = [f"listener {k}" for k in range(10)]
    for height in (90, 120, 300, 1000):
        rows = rows_of(names, "listener 9", height, 22, 1.0)
        assert rows[-1].listener == "listener 9" and [row.listener for row in rows] == sorted(
            row.listener for row in rows
        )
        assert all(row.middle - row.half >= 22 and row.middle + row.half <= height for row in rows)
        assert all(
            upper.middle - upper.half >= lower.middle + lower.half
            for upper, lower in pairwise(rows)
        )
    assert len(rows) == 10 and rows_of(names, "", 60, 22, 1.0) == ()


def test_heights_are_decibels_and_what_is_not_known_has_none():
    (row,) = rows_of(["a"], "a", 400, 22, 1.0)
    x, low = (
        np.arange(4) + 0.5,
        np.array([[-FULL_SCALE, -round(FULL_SCALE / 1000), 0, -FULL_SCALE]], dtype=np.int16),
    )
    parts = Columns(
        low, -low, np.array([[-30.0, -60.0, np.nan, -30.0]]), np.array([True, True, True, False])
    )
    strip = wave_strip([row], x, parts, [0])[1:-1].reshape(4, 2, 2)
    tall = (strip[:, 1, 1] - strip[:, 0, 1]).tolist()
    # Full scale, 60 dB less, silence.
    assert tall == pytest.approx([2 * row.half + 1, 1, 1, 0], abs=0.05)
    # A column of samples that are all alike reaches the one before.
    jump = np.array([[0, FULL_SCALE, 0, FULL_SCALE]], dtype=np.int16)
    strip = wave_strip([row], x, Columns(jump, jump, parts.threshold, np.full(4, True)), [0])[
        1:-1
    ].reshape(4, 2, 2)
    assert (strip[:, 1, 1] - strip[:, 0, 1]).tolist() == pytest.approx([1, *3 * [row.half + 1]])
    lower, upper = threshold_strip([row], x, parts, [0]).reshape(2, -1, 2)
    assert (
        upper[1:3, 1].mean() - row.middle
        == pytest.approx(row.half / 2)
        == row.middle - lower[1:3, 1].mean()
    )
