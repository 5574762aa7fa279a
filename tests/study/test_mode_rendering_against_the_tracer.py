"""A traced frame rendered in another mode is what the tracer gives when it runs in that mode."""

import numpy as np
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.addon.session.timeline import steps
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.study.baking import ModeRendering

FIRST, LAST = 2108, 2120  # the shock wave: several impacts at a time


@pytest.mark.slow
def test_same_gains_and_samples_as_traced_in_that_mode(mine_ride):
    mine_ride.haptics.mode = "HT"
    renderings = {mode: ModeRendering(mode) for mode in Mode}
    rendered = {mode: [] for mode in Mode}
    for step in steps(mine_ride, FIRST, LAST):
        settings = session.of(mine_ride).reading.settings
        for mode, rendering in renderings.items():
            rendered[mode].append(rendering.of(step.result, settings))
    assert sum(len(result.impacts) for result in rendered[Mode.HT]) >= 4
    for mode in Mode:
        mine_ride.haptics.mode = mode
        traced = [step.result for step in steps(mine_ride, FIRST, LAST)]
        assert traced[0].block is None and rendered[mode][0].block is None
        for ours, theirs in zip(rendered[mode], traced, strict=True):
            assert np.array_equal(ours.amplitudes, theirs.amplitudes)
            assert ours.block is theirs.block or np.array_equal(ours.block, theirs.block)
    mine_ride.haptics.mode = "HT"


@pytest.mark.slow
def test_a_jump_starts_afresh(mine_ride):
    rendering = ModeRendering(Mode.MD)
    settings = None
    for first in (2112, 3044):
        results = []
        for step in steps(mine_ride, first, first + 3):
            settings = session.of(mine_ride).reading.settings
            results.append(rendering.of(step.result, settings))
        assert [result.block is None for result in results] == [True, False, False, False]
        assert results[-1].time == pytest.approx((first + 2) / 24)
