"""The three limits on a drive: ceiling, rise, and the running mean square."""

import math

import numpy as np
import pytest
from haptic_tracing.core.devices.limits import DriveLimits
from hypothesis import given
from hypothesis import strategies as st

calls = st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 0.010)), min_size=1, max_size=300)


@given(
    calls=calls,
    ceiling=st.floats(0.05, 1.0),
    slew=st.floats(1.0, 1000.0),
    maximum=st.floats(0.05, 1.0),
    seconds=st.floats(0.02, 20.0),
)
def test_no_limit_is_ever_passed(calls, ceiling, slew, maximum, seconds):
    limits = DriveLimits(np.array([ceiling]), slew, maximum, seconds, interval=0.010)
    before = 0.0
    for wanted, elapsed in calls:
        driven = limits.limited(np.array([wanted]), elapsed)[0]
        assert 0.0 <= driven <= min(wanted, ceiling) + 1e-12
        assert driven <= before + slew * elapsed + 1e-12
        assert limits._mean_square[0] <= maximum**2 + 1e-9
        before = driven


@given(calls=calls)
def test_what_is_within_the_limits_is_driven_as_wanted(calls):
    limits = DriveLimits(
        np.array([1.0]), slew=1e4, sustained_maximum=1.0, sustained_seconds=10.0, interval=0.010
    )
    for wanted, elapsed in calls:
        assert limits.limited(np.array([wanted]), max(elapsed, 1e-3))[0] == pytest.approx(
            min(wanted, 1.0), abs=1e-12
        )


def test_full_drive_lasts_as_long_as_the_formula_says_and_goes_on_at_the_sustained_maximum():
    """The running mean square of a constant 1 is 1 - exp(-t / T); it reaches the square of the
    maximum at T ln(1 / (1 - max²))."""
    interval, seconds, maximum = 0.010, 10.0, 0.7
    limits = DriveLimits(np.array([1.0, 1.0]), 50.0, maximum, seconds, interval)
    driven = np.array([limits.limited(np.array([1.0, 0.6]), interval) for _ in range(2000)])
    full = np.count_nonzero(driven[:, 0] == 1.0) * interval
    assert full == pytest.approx(seconds * math.log(1.0 / (1.0 - maximum**2)), abs=0.05)
    assert driven[-1] == pytest.approx([maximum, 0.6], abs=1e-3)


def test_a_pause_gives_the_strength_back():
    limits = DriveLimits(np.array([1.0]), 1e4, 0.7, 10.0, 0.010)
    for _ in range(2000):
        limits.limited(np.array([1.0]), 0.010)
    limits.limited(np.array([0.0]), 0.010)
    assert limits.limited(np.array([1.0]), 30.0)[0] == 1.0


def test_falling_is_never_held_back():
    limits = DriveLimits(np.array([1.0]), 50.0, 0.7, 10.0, 0.010)
    for _ in range(10):
        limits.limited(np.array([1.0]), 0.010)
    assert limits.limited(np.array([0.0]), 0.0)[0] == 0.0
