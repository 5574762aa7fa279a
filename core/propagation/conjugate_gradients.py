"""Conjugate gradients for power balances, with a certified bound on the error.

The equations ``(Λ_i + Σ_j C_ij) E_i - Σ_j C_ij E_j = P_i`` have a symmetric M-matrix A. Without its
damping Λ it is positive semidefinite, so ``r·A⁻¹ r <= Σ r_i² / Λ_i`` for any residual r. For two
approximate solutions E and E' under powers P and P', with residuals r and r', the energy between
them is ``P'·A⁻¹ P = P'·E + E'·r + r'·A⁻¹ r``: what is not known of it is at most the product of the
roots of both bounds.

The iteration starts from zero with a Jacobi preconditioner (M. R. Hestenes, E. Stiefel, Journal of
Research of the National Bureau of Standards 49, 1952). Every column is iterated separately until
its bound suffices, without BLAS: the result depends bit by bit neither on the other columns,
nor on earlier frames, nor on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, added_by, runs
from ..frozen import frozen

ITERATIONS = 2000
"""Most iterations."""

FIRST_CHECK, CHECKED = 4, 4
"""Iterations before the first evaluation of the error, and between two evaluations."""

FEW, AT_LEAST = 100, 8
"""With fewer subsystems, whose iterations cost next to nothing, so many come before the first
evaluation: often that is exact to rounding."""

PADDED = 3
"""Times that padding to the longest row may enlarge a matrix."""

TOGETHER = 2**17
"""Products up to which several systems are multiplied together: more do not stay in the cache."""

SMALLEST = 1e-300
"""Added to divisors, so that a column that is solved exactly does not change."""

EPSILON = 64 * float(np.finfo(np.float64).eps)
"""Relative rounding error of one row of a product."""


@frozen
class PowerBalance:
    """k systems with the same sparsity of couplings and different values.

    Attributes:
        damping: (k, n) Λ > 0.
        leak: (k, n) couplings to subsystems with energy 0.
        row, column: (c,) subsystems of each coupling, both directions present, sorted by row.
        coupling: (k, c) C >= 0.
        blocks: couplings (k, r, r) among all of r subsystems that follow each other, and the first
            of these; 0 in the diagonal.
        diagonal: (k, n) power that a subsystem loses per unit of its energy.
    """

    damping: FloatArray
    leak: FloatArray
    row: IntArray
    column: IntArray
    coupling: FloatArray
    blocks: Sequence[tuple[int, FloatArray]] = ()
    diagonal: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        diagonal = (
            self.damping + self.leak + added_by(self.row, self.coupling, self.damping.shape[1])
        )
        for begin, block in self.blocks:
            diagonal[:, begin : begin + block.shape[1]] += block.sum(axis=2)
        object.__setattr__(self, "diagonal", diagonal)


@frozen
class Balanced:
    """Energies under each of s powers.

    Attributes:
        energy: (k, s, n), 0 or more.
        residual: (k, s, n) power less what the energies lose.
        rounding: (k, s, n) bounds on the rounding errors of the residuals.
        bound: (k, s) on the root of ``r·A⁻¹ r`` for the residuals r, rounding included.
    """

    energy: FloatArray
    residual: FloatArray
    rounding: FloatArray
    bound: FloatArray


def solve(
    balance: PowerBalance,
    power: FloatArray,
    good_enough: Callable[[FloatArray], FloatArray],
) -> Balanced:
    """The energies of k systems under s powers each.

    Args:
        balance: the systems.
        power: (k, s, n), 0 or more.
        good_enough: gives the tolerated ``bound`` (k, s) of approximate energies (k, s, n).
    """
    systems, columns, count = power.shape
    matrix = _Matrix(balance, columns)
    found = np.zeros((systems * columns, count))
    state = _Iteration(
        matrix,
        power.reshape(found.shape),
        np.repeat(balance.damping, columns, axis=0),
    )
    first = FIRST_CHECK if count >= FEW else AT_LEAST
    for iteration in range(ITERATIONS):
        if iteration >= first and (iteration - first) % CHECKED == 0:
            found[state.column] = state.energy
            wanted = good_enough(found.reshape(power.shape)).reshape(-1)
            state.restrict((state.product > 0) & (state.error_bounds() > wanted[state.column]))
        if len(state.column) == 0:
            break
        state.iterate()
    found[state.column] = state.energy
    energy = np.maximum(found, 0.0)
    matrix.restrict(np.arange(len(found)))
    residual = power.reshape(energy.shape) - matrix.times(energy)
    rounding = EPSILON * (2 * matrix.diagonal * energy + power.reshape(energy.shape))
    left = np.abs(residual) + rounding
    square = (left**2 / np.repeat(balance.damping, columns, axis=0)).sum(axis=1)
    return Balanced(
        energy.reshape(power.shape),
        residual.reshape(power.shape),
        rounding.reshape(power.shape),
        np.sqrt(square).reshape(systems, columns),
    )


class _Iteration:
    """The iteration of those columns (pairs of a system and a power) that are not good enough yet;
    ``column`` (c,): their numbers."""

    def __init__(self, matrix: _Matrix, power: FloatArray, damping: FloatArray) -> None:
        self._matrix = matrix
        self._inverse = 1.0 / matrix.diagonal
        self._damping = damping
        self.column = np.arange(len(power))
        self.energy: FloatArray = np.zeros_like(power)
        self._residual = power.copy()
        self._direction = power * self._inverse
        self.product: FloatArray = (power * self._direction).sum(axis=1)
        self.restrict(self.product > 0)

    def error_bounds(self) -> FloatArray:
        """Bounds (c,) on the errors, rounding left out."""
        return np.asarray(np.sqrt((self._residual**2 / self._damping).sum(axis=1)))

    def restrict(self, chosen: BoolArray) -> None:
        """Iterate only the ``chosen`` (c,) columns from now on."""
        if chosen.all():
            return
        self.column = self.column[chosen]
        self.product = self.product[chosen]
        self.energy = self.energy[chosen]
        self._residual = self._residual[chosen]
        self._direction = self._direction[chosen]
        self._inverse = self._inverse[chosen]
        self._damping = self._damping[chosen]
        self._matrix.restrict(self.column)

    def iterate(self) -> None:
        """One step of conjugate gradients."""
        direction = self._direction
        applied = self._matrix.times(direction)
        curvature = (direction * applied).sum(axis=1)
        step = (self.product / (curvature + SMALLEST))[:, None]
        self.energy += step * direction
        applied *= step
        self._residual -= applied
        scaled = np.multiply(self._residual, self._inverse, out=applied)
        following = (self._residual * scaled).sum(axis=1)
        direction *= (following / (self.product + SMALLEST))[:, None]
        direction += scaled
        self.product = following


class _Matrix:
    """The matrix of every system, multiplied by several vectors of each.

    Its rows, which begin with the diagonal, are padded with zeros to the same number of values. If
    few are long, that is about the mean, and what a row has beyond is in further rows.
    """

    def __init__(self, balance: PowerBalance, columns: int) -> None:
        systems, count = balance.damping.shape
        size = np.bincount(balance.row, minlength=count) + 1
        width = int(size.max(initial=1))
        if width * count > PADDED * size.sum():
            width = -(-int(size.sum()) // count)
        further = (size - 1) // width
        end = further.cumsum()
        number = np.arange(len(balance.row)) - (size.cumsum() - size)[balance.row] + balance.row + 1
        place = (
            number % width,
            np.where(
                number < width,
                balance.row,
                count - 1 + (end - further)[balance.row] + number // width,
            ),
        )
        shape = width, count + further.sum()
        self._column = np.zeros(shape, dtype=np.int64)
        self._column[0, :count] = np.arange(count)
        self._column[place] = balance.column
        self._system_values = np.zeros((systems, *shape))
        self._system_values[:, 0, :count] = balance.diagonal
        self._system_values[:, *place] = -balance.coupling
        self._longer = np.flatnonzero(further)
        self._begin = (end - further)[self._longer]
        self._blocks = balance.blocks
        self._system = np.arange(systems).repeat(columns)
        self.diagonal = balance.diagonal[self._system]
        self.restrict(np.arange(len(self._system)))

    def restrict(self, chosen: IntArray) -> None:
        """Multiply only the vectors of these numbers, which ascend, from now on."""
        values, system = self._system_values, self._system[chosen]
        begin, size = runs(system)
        self._runs = [
            (slice(first, first + count), int(system[first]))
            for first, count in zip(begin.tolist(), size.tolist(), strict=True)
        ]
        together = len(values) > 1 and len(chosen) * self._column.size < TOGETHER
        self._groups = (
            [(slice(0, len(chosen)), values[system])]
            if together
            else [(mine, values[number]) for mine, number in self._runs]
        )
        longest = max((mine.stop - mine.start for mine, _ in self._groups), default=0)
        self._terms = np.empty((longest, *self._column.shape))

    def times(self, vectors: FloatArray) -> FloatArray:
        """The matrix times ``vectors`` (b, n), one for each of the chosen numbers."""
        result = np.empty_like(vectors)
        count = vectors.shape[1]
        for mine, values in self._groups:
            terms = self._terms[: mine.stop - mine.start]
            # All are in range: this mode is only the quickest.
            vectors[mine].take(self._column, axis=1, out=terms, mode="wrap")
            terms *= values
            sums = terms.sum(axis=1)
            if len(self._longer):
                further = np.add.reduceat(sums[:, count:], self._begin, axis=1)
                sums[:, self._longer] += further
            result[mine] = sums[:, :count]
        for begin, block in self._blocks:
            part = slice(begin, begin + block.shape[1])
            # No BLAS: bits are independent of threads and of other columns.
            for mine, system in self._runs:
                result[mine, part] -= np.einsum("ij,kj->ki", block[system], vectors[mine, part])
        return result
