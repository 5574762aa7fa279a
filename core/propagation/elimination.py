"""Positive symmetric equations by elimination without a subtraction.

The energies of subsystems with dampings Λ and couplings C under powers P obey ``(Λ_i + Σ_j C_ij) E_i - Σ_j C_ij E_j = P_i``. To eliminate
subsystem k is to exchange a star of couplings for a mesh: with ``T = Λ_k + Σ_j C_kj``,

    C_ij += C_ik C_kj / T,   Λ_i += C_ik Λ_k / T,   P_i += C_ik P_k / T,

and afterwards ``E_k = (P_k + Σ_j C_kj E_j) / T``. All terms are positive, so every energy, however small, is right to rounding relative to
itself. Kept is the damping, not the diagonal of the matrix that it would have to be subtracted from.

Source: W. K. Grassmann, M. I. Taksar, D. P. Heyman, "Regenerative analysis and steady state distributions for Markov chains", Operations
Research 33, 1985. The order is that of the fewest couplings first: W. F. Tinney, J. W. Walker, Proceedings of the IEEE 55, 1967.
"""

from __future__ import annotations

import heapq

import numpy as np

from ..arrays import FloatArray, IntArray

MESH = 12
"""Subsystems with more couplings than this are left to the core, which is solved as a dense matrix."""

PANEL, TILE = 32, 64
"""A matrix is eliminated by so many rows at a time, then updated in squares of this size: small enough that no library for linear algebra
divides a product among threads, whose number would show in the last bits (and waiting for which costs more than they save)."""

Star = tuple[int, list[int], FloatArray, float]
"""An eliminated subsystem, those it was coupled to, the couplings by T, and 1 / T."""


class Elimination:
    """Subsystems with few couplings eliminated; ``core`` (k,) those left, ``damping`` (k,), ``rows``, ``columns`` (numbers in the core) and
    ``coupling`` of the equations among these."""

    def __init__(self, damping: FloatArray, rows: IntArray, columns: IntArray, coupling: FloatArray) -> None:
        self._stars: list[Star] = []
        near: list[dict[int, float]] = [{} for _ in damping]
        for a, b, value in zip(rows.tolist(), columns.tolist(), coupling.tolist(), strict=True):
            near[a][b] = near[a].get(b, 0.0) + value
        own = damping.tolist()
        left = self._eliminate(near, own)
        number = {index: k for k, index in enumerate(left)}
        self.core = np.array(left, dtype=np.int64)
        self.damping = np.array([own[index] for index in left], dtype=np.float64)
        self.rows = np.repeat(np.arange(len(left)), [len(near[index]) for index in left])
        self.columns = np.array([number[other] for index in left for other in sorted(near[index])], dtype=np.int64)
        self.coupling = np.array([near[index][other] for index in left for other in sorted(near[index])], dtype=np.float64)

    def _eliminate(self, near: list[dict[int, float]], own: list[float]) -> list[int]:
        queue = [(len(others), index) for index, others in enumerate(near)]
        heapq.heapify(queue)
        done = [False] * len(near)
        while queue and queue[0][0] <= MESH:
            degree, index = heapq.heappop(queue)
            others = near[index]
            if done[index] or degree != len(others):
                continue
            done[index] = True
            ends = sorted(others)
            total = own[index] + sum(others[end] for end in ends)
            factors = [others[end] / total for end in ends]
            for end, factor in zip(ends, factors, strict=True):
                own[end] += factor * own[index]
                del near[end][index]
            for place, end in enumerate(ends):
                here = near[end]
                for second in range(place):
                    other = ends[second]
                    here[other] = near[other][end] = here.get(other, 0.0) + others[end] * factors[second]
            for end in ends:
                heapq.heappush(queue, (len(near[end]), end))
            self._stars.append((index, ends, np.array(factors, dtype=np.float64), 1.0 / total))
        return [index for index in range(len(near)) if not done[index]]

    def forward(self, power: FloatArray) -> FloatArray:
        """Powers (n, s) with what is put into subsystems passed on to those that are eliminated later, and to the core."""
        passed = power.copy()
        busy = [bool(value) for value in np.atleast_1d(power.any(axis=1))]
        for index, ends, factors, _ in self._stars:
            if busy[index]:
                for end, factor in zip(ends, factors.tolist(), strict=True):
                    passed[end] += factor * passed[index]
                    busy[end] = True
        return passed

    def back(self, energy: FloatArray, passed: FloatArray) -> FloatArray:
        """Energies (n, s) of all from those of the core (k, s). No error in these grows: the factors of a star add up to less than 1."""
        result = np.zeros_like(passed)
        result[self.core] = energy
        busy = [bool(value) for value in np.atleast_1d(passed.any(axis=1))]
        for index, ends, factors, inverse in reversed(self._stars):
            result[index] = (factors[:, None] * result[ends]).sum(axis=0)
            if busy[index]:
                result[index] += passed[index] * inverse
        return result


def eliminated(damping: FloatArray, rows: IntArray, columns: IntArray, coupling: FloatArray, power: FloatArray) -> FloatArray:
    """Energies (n, s) of subsystems that are solved as a dense matrix: by the same elimination, which needs its upper half alone."""
    count = len(damping)
    own, passed, inverse = damping.copy(), power.copy(), np.empty(count)
    matrix = np.zeros((count, count))
    matrix[rows, columns] += coupling
    for first in range(0, count, PANEL):
        last = min(first + PANEL, count)
        behind = np.empty((last - first, count - last))
        for index in range(first, last):
            row = matrix[index, index + 1 :]
            inverse[index] = 1.0 / (own[index] + row.sum())
            factor = row * inverse[index]
            left = last - index - 1
            matrix[index + 1 : last, index + 1 :] += factor[:left, None] * row
            own[index + 1 :] += factor * own[index]
            passed[index + 1 :] += factor[:, None] * passed[index]
            behind[index - first] = row[left:]
            matrix[index, index + 1 :] = factor
        factors = matrix[first:last, last:].T
        for top in range(0, count - last, TILE):
            for begin in range(top, count - last, TILE):
                tile = matrix[last + top : last + top + TILE, last + begin : last + begin + TILE]
                tile += factors[top : top + TILE] @ behind[:, begin : begin + TILE]
    energy = passed * inverse[:, None]
    for index in range(count - 2, -1, -1):
        energy[index] += (matrix[index, index + 1 :, None] * energy[index + 1 :]).sum(axis=0)
    return energy
