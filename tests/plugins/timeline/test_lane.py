"""The timeline of touch shows what was baked: waves, impacts at their frames, rows that fit the
region."""

from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.bake.baking import bake_job
from haptic_tracing.addon.blender.text import text_width
from haptic_tracing.core.render.integers import FULL_SCALE
from haptic_tracing.core.render.levels import vibration_rms
from haptic_tracing.core.scene.values import Listener
from haptic_tracing.plugins.timeline.baked import computed
from haptic_tracing.plugins.timeline.rows import Colours, names, rows_of, snapped, stems, strip
from haptic_tracing.sample_scenes import build_sample


@pytest.mark.slow
def test_baked_waves_have_the_samples_and_impacts_of_the_track():
    scene = build_sample("hammer_nail")
    scene.frame_end = 30
    baking = bake_job(scene)
    while baking.advance(1.0) is None:
        pass
    track = storage.track_of(scene)
    waves = computed(
        track, [Listener(item.name, item.name, radius=0.0) for item in track.listeners]
    )
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
        latest = vibration_rms(track.samples_until(number, 0.25), track.sample_rate)
        with np.errstate(divide="ignore"):
            assert waves.level[:, number - track.frame_start - 1] == pytest.approx(
                20 * np.log10(latest), abs=0.1
            )
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
    listeners = [f"listener {k}" for k in range(10)]
    sources = ["engine", "pump"]
    for height in (44, 90, 120, 300, 1000):
        rows = rows_of(sources, listeners, ("listener 9", "pump"), height, 1.0)
        shown = [row.name for row in rows]
        assert shown == [name for name in (*sources, *listeners) if name in shown]
        assert {"listener 9", "pump"} <= set(shown) or len(shown) < 2
        assert all(
            row.low >= (22 if height > 100 else 1) and row.low + row.height <= height
            for row in rows
        )
        assert height == 44 or all(
            upper.low >= lower.low + lower.height for upper, lower in pairwise(rows)
        )
        assert [row.is_source for row in rows] == [name in sources for name in shown]
    assert len(rows) == 12 and rows_of(sources, listeners, (), 30, 1.0) == ()


def test_a_source_and_a_listener_share_the_only_place():
    sources, listeners = ["engine", "pump"], ["hand", "foot"]
    for first, shown in (((), ["engine", "hand"]), (("foot", "pump"), ["pump", "foot"])):
        rows = rows_of(sources, listeners, first, 44, 1.0)
        assert [row.name for row in rows] == shown
        assert [(row.low, row.height) for row in rows] == [(1, 17)] * 2
    (row,) = rows_of([], listeners, (), 44, 1.0)
    assert row.name == "hand"


def test_names_do_not_overlap():
    colours = Colours((0, 0, 0, 1), (1, 1, 1), (1, 0.5, 0), (0, 1, 0.5))
    for height in (44, 120):
        rows = rows_of(["a source with a long name"], ["hand", "foot"], ("foot",), height, 1.0)
        texts = names(rows, [], 3 - len(rows), colours, 1.0)
        places = [(*text.position, text_width(text.words, text.size)) for text in texts.texts]
        assert len(places) == len(rows) and min(left for left, _, _ in places) > 14
        for (a, low, width), (b, other, _) in pairwise(places):
            assert low - other >= 10 or b >= a + width


def test_half_of_few_rows_are_sources():
    sources, listeners = [f"s{k}" for k in range(5)], [f"l{k}" for k in range(5)]
    rows = rows_of(sources, listeners, (), 114.0, 1.0)
    assert len(rows) == 6 and sum(row.is_source for row in rows) == 3
    assert [row.name for row in rows] == ["s0", "s1", "s2", "l0", "l1", "l2"]


def test_bands_fill_their_row_and_what_is_not_known_has_no_area():
    (row,) = rows_of([], ["a"], (), 400, 1.0)
    x, low = np.arange(4) + 0.5, np.zeros((1, 4))
    high, known = np.array([[1.0, 0.5, 0.0, 1.0]]), np.array([True, True, True, False])
    corners = strip([row], x, low, high, known)[1:-1].reshape(4, 2, 2)
    tall = (corners[:, 1, 1] - corners[:, 0, 1]).tolist()
    assert tall == pytest.approx([row.height + 1.5, row.height / 2 + 1.5, 1.5, 0], abs=1e-3)
    assert corners[:, 0, 0].tolist() == x.tolist()
    # Two rows are one strip: between them its triangles have no area.
    rows = rows_of([], ["a", "b"], (), 400, 1.0)
    whole = strip(rows, x, np.zeros((2, 4)), np.ones((2, 4)), np.ones(4, dtype=bool))
    a, b, c = whole[:-2], whole[1:-1], whole[2:]
    areas = np.abs(np.cross(np.c_[b - a, np.zeros(len(a))], np.c_[c - a, np.zeros(len(a))])[:, 2])
    assert areas.sum() / 2 == pytest.approx(2 * 3 * (rows[0].height + 1.5), rel=1e-4)


def test_an_impact_is_as_high_as_a_level():
    rows = rows_of([], ["a", "b"], (), 400, 1.0)
    ends = stems(rows, np.array([5.0, 9.0]), np.array([[1.0, 0.0], [0.1, 0.001]])).reshape(-1, 2, 2)
    assert ends[:, :, 0].tolist() == [[5, 5], [9, 9], [9, 9]]
    tall = ends[:, 1, 1] - ends[:, 0, 1]
    assert tall == pytest.approx([rows[0].height, rows[0].height * 2 / 3, 0.0], abs=1e-4)


def test_what_is_dragged_snaps_to_the_nearest_target_or_to_a_frame():
    targets = np.array([10.4, 20.0])
    assert snapped(10.9, targets, 0.6) == 10.4 and snapped(11.2, targets, 0.6) == 11.0
    assert snapped(15.2, np.zeros(0), 5.0) == 15.0
