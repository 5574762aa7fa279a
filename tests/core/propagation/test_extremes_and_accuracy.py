"""What the pages on accuracy and stability promise, on scenes small enough for the suite."""

from __future__ import annotations

import mpmath
import pytest
from haptic_tracing.benchmarks import bench_accuracy, stability


@pytest.mark.slow
def test_extremes_against_mpmath_and_closed_forms():
    """Exact to rounding by best paths and sums; by the energy balance within its certified
    bound."""
    with mpmath.workdps(60):
        for case in stability.cases(0.01):
            for row in stability.worst_errors(*case):
                assert row.bounded, row
                if row.strategy != "energy_balance":
                    assert row.error < 1e-12, row


@pytest.mark.slow
def test_the_default_is_as_accurate_as_its_page_says():
    """In a pile of a hundred the default is within 0.1 dB of the most exact setting, and a tenth of
    the threshold changes nothing."""
    errors = {
        (point.dial, point.setting): point
        for point in bench_accuracy.propagation_points(100, least=0.0)
    }
    assert errors["default", ""].largest < 0.1
    assert (
        errors["threshold", "0"].largest
        == errors["threshold", "0.0001"].largest
        == errors["default", ""].largest
    )
    assert errors["threshold", "0.1"].largest > 3  # a listener who would feel something is cut off
    assert errors["connections", "1"].largest > 3
    extents = {point.setting: point for point in bench_accuracy.extent_points(100, least=0.0)}
    assert extents["mean_power"].largest < 0.05 < extents["strongest"].largest < 1
