"""Solutions of power balances, with a certified bound on the error: by the inverse of the matrix
for few subsystems, by conjugate gradients for many.

The equations ``(Λ_i + Σ_j C_ij) E_i - Σ_j C_ij E_j = P_i`` have a symmetric M-matrix A. Without its
damping Λ it is positive semidefinite, so ``r·A⁻¹ r <= Σ r_i² / Λ_i`` for any residual r. For two
approximate solutions E and E' under powers P and P', with residuals r and r', the energy between
them is ``P'·A⁻¹ P = P'·E + E'·r + r'·A⁻¹ r``: what is not known of it is at most the product of the
roots of both bounds.

Rows and columns are scaled to a diagonal of ones. Subsystems without couplings to each other are
eliminated: what they receive is a sum over their neighbours, so the iteration has fewer unknowns,
and it converges in about two thirds of the steps. What is left is an M-matrix again, in which the
damping of the eliminated subsystems counts as their neighbours'.

The iteration starts from zero (M. R. Hestenes, E. Stiefel, Journal of Research of the National
Bureau of Standards 49, 1952). Every column is iterated separately until its bound suffices, without
BLAS: the result depends bit by bit neither on the other columns, nor on earlier frames, nor on the
number of threads. Neither does that of the inverse.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import cached_property

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, added_by, runs
from ..frozen import frozen

ITERATIONS = 2000
"""Most iterations."""

FIRST_CHECK, CHECKED = 8, 4
"""Iterations before the first evaluation of the error, and between two evaluations."""

FEW, CUBES = 100, 1_200_000
"""Matrices of fewer subsystems, for which LAPACK takes one thread, are inverted, as long as the
cubes of their sizes add up to less: beyond, iterations are faster."""

INVERTED = 1e-7
"""Largest bound after that; with a larger one the equations are iterated. It adds 1e-14 to a
squared gain."""

WORTHWHILE, ROUNDS = 4096, 4
"""Number of couplings, in all systems together, from which on subsystems are eliminated; and of
passes over the subsystems in which those to eliminate are chosen."""

NEVER = 2**62
"""Rank of subsystems that are not eliminated."""

WIDEST, ADDITION = 24, 3
"""Most values in a row of a matrix, and products that cost as much as the addition of a further
row."""

TOGETHER = 2**19
"""Products up to which several systems are multiplied together: more do not stay in the cache."""

KEPT = 0.75
"""Part of the columns, when no more are left to be iterated, from which on the others are left
out."""

SMALLEST = 1e-300
"""Added to divisors, so that a column that is solved exactly does not change."""

EPSILON = 64 * float(np.finfo(np.float64).eps)
"""Relative rounding error of one row of a product."""

_WHOLE = np.zeros(1, dtype=np.int64)


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
        energy: (n, k, s), 0 or more.
        residual: (n, k, s) power less what the energies lose.
        rounding: (n, k, s) bounds on the rounding errors of the residuals.
        bound: (k, s) on the root of ``r·A⁻¹ r`` for the residuals r, rounding included.
    """

    energy: FloatArray
    residual: FloatArray
    rounding: FloatArray
    bound: FloatArray


def solve(
    balance: PowerBalance,
    power: FloatArray,
    good_enough: Callable[[FloatArray, FloatArray], FloatArray],
) -> Balanced:
    """The energies of k systems under s powers each.

    Args:
        balance: the systems.
        power: (n, k, s), 0 or more.
        good_enough: gives the tolerated ``bound`` (k, s) of approximate energies (n, k, s) with
            the bounds (k, s).
    """
    count, systems, columns = power.shape
    if count == 0:
        return Balanced(power, power, power, np.zeros((systems, columns)))
    if is_small(balance) and (found := _inverted(balance, power)):
        return found
    matrix = _Matrix(balance)
    place, scale = matrix.place, matrix.scale[:, :, None]
    scaled = power.take(matrix.order, axis=0) * scale
    together = max(1, TOGETHER // (matrix.products * columns))
    groups = [
        _Iteration(matrix, scaled, slice(first, min(first + together, systems)))
        for first in range(0, systems, together)
    ]
    done, left = 0, [True]
    while any(left) and done < ITERATIONS:
        steps = min(CHECKED if done else FIRST_CHECK, ITERATIONS - done)
        for group in groups:
            group.iterate(steps)
        done += steps
        energy = _joined([group.found for group in groups])
        bound = np.concatenate([group.bound for group in groups])
        wanted = good_enough((energy * scale).take(place, axis=0), bound)
        left = [group.close(wanted[group.systems]) for group in groups]
    energy = np.maximum(energy, 0.0)
    residual = scaled - _joined([group.lost(energy) for group in groups])
    rounding = EPSILON * (2 * energy + scaled)
    square = (np.abs(residual) + rounding) ** 2 * matrix.decay[:, :, None]
    return Balanced(
        (energy * scale).take(place, axis=0),
        (residual / scale).take(place, axis=0),
        (rounding / scale).take(place, axis=0),
        np.sqrt(summed(square[: matrix.kept])) + np.sqrt(summed(square[matrix.kept :])),
    )


def is_small(balance: PowerBalance) -> bool:
    """Whether the matrix is inverted."""
    systems, count = balance.damping.shape
    return bool(count < FEW and systems * count**3 < CUBES)


def _inverted(balance: PowerBalance, power: FloatArray) -> Balanced | None:
    """The same by the inverse of the whole matrix; None if that is too close to singular."""
    matrix = _dense(balance)
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return None
    put_in = np.ascontiguousarray(power.transpose(1, 2, 0))
    energy = np.maximum(np.einsum("kij,ksj->ksi", inverse, put_in), 0.0)
    lost = np.einsum("kij,ksj->ksi", matrix, energy)
    found = _certified(balance, power, energy.transpose(2, 0, 1), lost.transpose(2, 0, 1))
    return found if found.bound.max(initial=0.0) < INVERTED else None


def solve_at_once(balance: PowerBalance, power: FloatArray) -> Balanced | None:
    """The same in less time, where the bits of a column may depend on the others; None if the
    matrix is singular."""
    matrix = _dense(balance)
    try:
        energy = np.maximum(np.linalg.solve(matrix, power.transpose(1, 0, 2)), 0.0)
    except np.linalg.LinAlgError:
        return None
    lost = matrix @ energy
    return _certified(balance, power, energy.transpose(1, 0, 2), lost.transpose(1, 0, 2))


def _dense(balance: PowerBalance) -> FloatArray:
    """The matrices (k, n, n)."""
    systems, count = balance.damping.shape
    coupling = added_by(balance.row * count + balance.column, balance.coupling, count * count)
    matrix = -coupling.reshape(systems, count, count)
    for begin, block in balance.blocks:
        part = slice(begin, begin + block.shape[1])
        matrix[:, part, part] -= block
    matrix.reshape(systems, -1)[:, :: count + 1] += balance.diagonal
    return matrix


def _certified(
    balance: PowerBalance, power: FloatArray, energy: FloatArray, lost: FloatArray
) -> Balanced:
    """Approximate energies (n, k, s) with certified bounds on their errors, from the power that
    they lose by the equations, ``lost`` (n, k, s), and the ``power`` (n, k, s) put in."""
    residual = power - lost
    rounding = EPSILON * (2 * balance.diagonal.T[:, :, None] * energy + power)
    square = (np.abs(residual) + rounding) ** 2
    square /= (balance.damping + balance.leak).T[:, :, None]
    return Balanced(energy, residual, rounding, np.sqrt(summed(square)))


def summed(values: FloatArray) -> FloatArray:
    """Sums over the first axis, each in an order that does not depend on how many there are."""
    if len(values) == 0:
        return np.zeros(values.shape[1:])
    return np.asarray(np.add.reduceat(values, _WHOLE, axis=0)[0])


def _joined(parts: list[FloatArray]) -> FloatArray:
    """Values (n, all k, s) of groups of systems."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)


class _Iteration:
    """The iteration of the columns (pairs of a system and a power) of some systems, until they are
    good enough.

    Attributes:
        systems: their numbers.
        found: (n, k, s) energies, in the order and scale of the `_Matrix`.
        bound: (k, s) on their errors, rounding left out.
    """

    def __init__(self, matrix: _Matrix, power: FloatArray, systems: slice) -> None:
        power = power[:, systems]
        count, _, columns = power.shape
        kept = matrix.kept
        self.systems = systems
        self.found = np.zeros_like(power)
        self.bound = np.zeros(power.shape[1:])
        self._matrix = matrix
        self._factors = self._all_factors = matrix.factors(systems, columns)
        flat = power.reshape(count, -1)
        self._passed_on = flat[kept:]
        # Directions; below them what follows from these for the subsystems that are eliminated.
        self._direction = np.zeros_like(flat)
        self._direction[kept:] = self._passed_on
        self._residual = flat[:kept] + matrix.received(self._factors, self._direction)
        self._direction[:kept] = self._residual
        self._energy = np.zeros_like(self._residual)
        self._product = summed(self._residual**2)
        self._decay = matrix.decay[:kept, systems].repeat(columns, axis=1)
        # Of the columns that are iterated, the numbers, and which are not good enough yet.
        self._column = np.arange(len(self._product))
        self._open = np.ones(len(self._product), dtype=np.bool_)

    def iterate(self, steps: int) -> None:
        """So many steps of conjugate gradients."""
        if not self._open.any():
            return
        matrix, factors, residual = self._matrix, self._factors, self._residual
        direction = self._direction[: matrix.kept]
        for _ in range(steps):
            matrix.eliminate(factors, self._direction)
            applied = matrix.received(factors, self._direction)
            np.subtract(direction, applied, out=applied)
            step = self._product / (summed(direction * applied) + SMALLEST)
            self._energy += step * direction
            applied *= step
            residual -= applied
            following = summed(np.multiply(residual, residual, out=applied))
            direction *= following / (self._product + SMALLEST)
            direction += residual
            self._product = following
        bound = np.sqrt(summed(np.multiply(residual**2, self._decay)))
        energy = self._energy
        if len(self._passed_on):
            energy = np.concatenate([energy, self._passed_on])
            matrix.eliminate(factors, energy)
            energy[matrix.kept :] += self._passed_on
        number = self._column[self._open]
        self.found.reshape(len(energy), -1)[:, number] = energy[:, self._open]
        self.bound.reshape(-1)[number] = bound[self._open]

    def close(self, wanted: FloatArray) -> bool:
        """Iterate only those columns further whose bounds are above the ``wanted`` (k, s) ones.
        Returns whether there are any."""
        above = self.bound > wanted
        self._open &= above.reshape(-1)[self._column] & (self._product > 0)
        left = np.flatnonzero(self._open)
        if 0 < len(left) <= KEPT * len(self._open):
            self._factors = self._factors.chosen(left)
            self._column = self._column[left]
            self._open = self._open[left]
            self._product = self._product[left]
            self._residual, self._energy, self._direction, self._decay, self._passed_on = (
                part.take(left, axis=1)
                for part in (
                    self._residual,
                    self._energy,
                    self._direction,
                    self._decay,
                    self._passed_on,
                )
            )
        return len(left) > 0

    def lost(self, energy: FloatArray) -> FloatArray:
        """Power (n, k, s) that ``energy`` (n, all k, s) loses."""
        mine = energy[:, self.systems]
        flat = np.ascontiguousarray(mine).reshape(len(mine), -1)
        received = flat.copy()
        self._matrix.eliminate(self._all_factors, received)
        received[: self._matrix.kept] = self._matrix.received(self._all_factors, flat)
        return mine - received.reshape(mine.shape)


class _Factors:
    """What multiplies columns of vectors.

    Attributes:
        rows, eliminated: values (w, m, c) of the rows that are kept and of the others.
    """

    def __init__(self, rows: FloatArray, eliminated: FloatArray, system: IntArray) -> None:
        self.rows, self.eliminated, self._system = rows, eliminated, system

    @cached_property
    def runs(self) -> list[tuple[slice, int]]:
        """Runs of columns of the same system, and its number."""
        begin, size = runs(self._system)
        return [
            (slice(first, first + count), int(self._system[first]))
            for first, count in zip(begin.tolist(), size.tolist(), strict=True)
        ]

    def chosen(self, columns: IntArray) -> _Factors:
        """The factors of these ``columns`` alone."""
        return _Factors(
            self.rows.take(columns, axis=-1),
            self.eliminated.take(columns, axis=-1),
            self._system[columns],
        )


class _Matrix:
    """The matrix of every system, scaled to a diagonal of ones, from which subsystems without
    couplings to each other are eliminated.

    Attributes:
        kept: number of those that are not.
        order: (n,) numbers of the subsystems: those that are kept, then the others. All arrays that
            follow, and vectors, have this order.
        place: (n,) place of each subsystem in it.
        scale: (n, k) root of the reciprocal diagonal, by which rows and columns are multiplied.
        decay: (n, k), such that ``r·A⁻¹ r`` of a scaled residual r of those that are kept, or of
            the others, is at most the sum of its squares times these.
        products: number of products in a multiplication by a vector.
    """

    def __init__(self, balance: PowerBalance) -> None:
        eliminated = _independent(balance)
        chosen = np.flatnonzero(~eliminated)
        self.kept = len(chosen)
        self.order = np.concatenate([chosen, np.flatnonzero(eliminated)])
        self.place = np.empty_like(self.order)
        self.place[self.order] = np.arange(len(self.order))
        scale = np.sqrt(1.0 / balance.diagonal)
        value = balance.coupling * scale.take(balance.row, axis=1)
        value *= scale.take(balance.column, axis=1)
        row, column = self.place.take(balance.row), self.place.take(balance.column)
        kept = row < self.kept
        inside = np.flatnonzero(kept)
        self._rows = _Rows(
            row.take(inside), column.take(inside), value.take(inside, axis=1), self.kept
        )
        self._eliminated = None
        if self.kept < len(self.order):
            inside = np.flatnonzero(~kept)
            row = row.take(inside) - self.kept
            count = len(self.order) - self.kept
            self._eliminated = _Rows(row, column.take(inside), value.take(inside, axis=1), count)
        self.products = self._rows.products
        self._blocks = []
        for begin, block in balance.blocks:
            part = slice(begin, begin + block.shape[1])
            scaled = block * (scale[:, part, None] * scale[:, None, part])
            self._blocks.append((int(self.place[begin]), scaled))
        self.scale = scale.T.take(self.order, axis=0)
        lost = (balance.damping + balance.leak).T.take(self.order, axis=0)
        self.decay = self._decay(lost * self.scale)

    def _decay(self, damping: FloatArray) -> FloatArray:
        """See `_Matrix`; ``damping`` (n, k) with what leaks, scaled."""
        if self._eliminated is not None:
            passed_on = damping.copy()
            passed_on[: self.kept] = 0.0
            systems = slice(0, damping.shape[1])
            damping[: self.kept] += self.received(self.factors(systems, 1), passed_on)
        return np.asarray(1.0 / (self.scale * damping))

    def factors(self, systems: slice, columns: int) -> _Factors:
        """The factors of so many columns of each of the ``systems``."""
        system = np.arange(systems.start, systems.stop).repeat(columns)
        eliminated = np.zeros((0, 0, len(system)))
        if self._eliminated is not None:
            eliminated = self._eliminated.repeated(systems, columns)
        return _Factors(self._rows.repeated(systems, columns), eliminated, system)

    def eliminate(self, factors: _Factors, vectors: FloatArray) -> None:
        """Write into the last rows of ``vectors`` (n, c) what the subsystems that are eliminated
        receive."""
        if self._eliminated is not None:
            vectors[self.kept :] = self._eliminated.times(factors.eliminated, vectors)

    def received(self, factors: _Factors, vectors: FloatArray) -> FloatArray:
        """What those that are kept receive (kept, c) from energies ``vectors`` (n, c)."""
        result = self._rows.times(factors.rows, vectors)
        for begin, block in self._blocks:
            part = slice(begin, begin + block.shape[1])
            # No BLAS: bits are independent of threads and of other columns.
            for mine, system in factors.runs:
                among = np.ascontiguousarray(vectors[part, mine].T)
                result[part, mine] += np.einsum("ij,kj->ki", block[system], among).T
        return result


class _Rows:
    """Some rows of matrices with the same sparsity and different values.

    They are padded with zeros to the same number of values, and what a row has beyond is in further
    rows.

    Args:
        row, column: (c,) of each value, sorted by row.
        value: (k, c).
        count: number of rows.

    Attributes:
        products: number of products in a multiplication by a vector.
    """

    def __init__(self, row: IntArray, column: IntArray, value: FloatArray, count: int) -> None:
        size = np.bincount(row, minlength=count)
        widths = np.arange(1, 1 + min(WIDEST, int(size.max(initial=1))))
        further = np.maximum(size - 1, 0) // widths[:, None]
        more = further.sum(axis=1)
        best = int((widths * (count + more) + ADDITION * more).argmin())
        width, further = int(widths[best]), further[best]
        end = further.cumsum()
        number = np.arange(len(row)) - (size.cumsum() - size)[row]
        place = (
            number % width,
            np.where(number < width, row, count - 1 + (end - further)[row] + number // width),
        )
        shape = width, count + int(more[best])
        self.products = shape[0] * shape[1]
        self._values = np.zeros((*shape, len(value)))
        self._values[place] = value.T
        self._source = np.zeros(shape, dtype=np.int64)
        self._source[place] = column
        self._count = count
        self._longer = np.flatnonzero(further)
        self._begin = (end - further)[self._longer]

    def repeated(self, systems: slice, columns: int) -> FloatArray:
        """The padded values (w, m, c), for so many columns of each of the ``systems``."""
        values = self._values[:, :, systems]
        beside = np.broadcast_to(values[..., None], (*values.shape, columns))
        return beside.reshape(*values.shape[:2], values.shape[2] * columns)

    def times(self, values: FloatArray, vectors: FloatArray) -> FloatArray:
        """The rows times ``vectors`` (n, c), of which each has its ``values`` (w, m, c)."""
        # All are in range: this mode is only the quickest.
        terms = vectors.take(self._source, axis=0, mode="wrap")
        terms *= values
        sums = np.add.reduce(terms, axis=0)
        result = sums[: self._count]
        if len(self._longer):
            result[self._longer] += np.add.reduceat(sums[self._count :], self._begin, axis=0)
        return np.asarray(result)


def _independent(balance: PowerBalance) -> BoolArray:
    """Which subsystems (n,) are eliminated: of each that is, no neighbour is, and rather those with
    few couplings."""
    systems, count = balance.damping.shape
    chosen = np.zeros(count, dtype=np.bool_)
    if systems * len(balance.row) < WORTHWHILE:
        return chosen
    begin, size = runs(balance.row)
    node = balance.row[begin]
    rank = np.full(count, NEVER)
    # Those with equally many are told apart by numbers that are as good as random.
    rank[node] = (size << 32) + node * 2654435761 % 2**32
    for first, block in balance.blocks:
        rank[first : first + block.shape[1]] = NEVER
    for _ in range(ROUNDS):
        found = node[rank[node] < np.minimum.reduceat(rank[balance.column], begin)]
        chosen[found] = True
        rank[found] = NEVER
        rank[balance.column[chosen[balance.row]]] = NEVER
    return chosen
