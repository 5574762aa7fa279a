"""What the page on stability promises, on scenes small enough for the suite."""

from __future__ import annotations

import mpmath
from haptic_tracing.benchmarks import stability


def test_extremes_against_closed_forms():
    with mpmath.workdps(60):
        for case in stability.cases(0.01):
            for row in stability.worst_errors(*case):
                assert row.error < stability.ROUNDING, row
