"""Least squares within bounds, beside SciPy's two solvers, which work differently."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.least_squares import bounded_least_squares
from scipy.optimize import lsq_linear, nnls


@pytest.mark.parametrize("softness", [1e-8, 1e-5, 1e-2, 1.0])
def test_the_minimum_is_scipys(softness):
    generator = np.random.default_rng(5)
    for _ in range(40):
        m, n = generator.integers(1, 14, 2)
        matrix, target = generator.normal(size=(m, n)), 3 * generator.normal(size=m)
        low, high = -generator.random(n), generator.random(n)
        whole = np.vstack([matrix / np.sqrt(softness), np.eye(n)])
        right = np.concatenate([target / np.sqrt(softness), np.zeros(n)])
        expected = lsq_linear(whole, right, (low, high), method="bvls", tol=1e-15).x
        found = bounded_least_squares(matrix, target, low, high, softness)
        assert np.all((found >= low) & (found <= high))
        assert np.sum((whole @ found - right) ** 2) <= np.sum((whole @ expected - right) ** 2) * (
            1 + 1e-10
        )


def test_without_an_upper_bound_as_nnls():
    generator = np.random.default_rng(6)
    for _ in range(40):
        matrix, target = generator.normal(size=(12, 6)), generator.normal(size=12)
        expected, norm = nnls(matrix, target)
        found = bounded_least_squares(matrix, target, np.zeros(6), np.full(6, np.inf), 1e-7)
        assert found == pytest.approx(expected, abs=1e-5)
        assert np.linalg.norm(matrix @ found - target) == pytest.approx(norm, rel=1e-9)


def test_of_several_solutions_the_smallest():
    """A load on three supports side by side: with the middle one at the load, x = 1/3 each."""
    matrix = np.array([[1.0, 1.0, 1.0], [-1.0, 0.0, 1.0]])
    found = bounded_least_squares(
        matrix, np.array([1.0, 0.0]), np.zeros(3), np.full(3, np.inf), 1e-12
    )
    assert found == pytest.approx([1 / 3] * 3, abs=1e-9)
