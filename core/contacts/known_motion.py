"""Hits of bodies whose motion between two frames is known, as that of keyed objects by their
curves: exact times and speeds, also where they brake, bounce or stop between frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray, among
from ..frozen import frozen
from .body_poses import columns_of
from .body_table import BodyTable
from .hit_search import HitSearch
from .impacts import Hits
from .motion import spins
from .narrow.frames import dot, relative_pose, turned, turned_back

_TOUCH, _APART = 1e-5, 1e-4
"""Distances [m] below which bodies touch, and above which they have parted."""

_KEPT = 0.5
"""Part of its speed up to which what goes on within the tolerance has been stopped there."""

_STRIDE = 8
"""Samples from one to the next of those at which distances are always computed."""


@frozen(eq=False)
class KnownMotion:
    """Motion of some bodies from one frame to the next.

    Attributes:
        step: between two samples [s].
        poses: by name of the body, its rigid world transforms (k, 4, 4) at samples of which the
            third is the frame before and the last is this frame; of k - 3 a multiple of 8.
    """

    step: float
    poses: Mapping[str, FloatArray]

    def numbered(self, names: Sequence[str]) -> Samples:
        """The samples of these bodies, by their places in ``names``."""
        number = {name: k for k, name in enumerate(names)}
        poses = {number[name]: columns_of(poses) for name, poses in self.poses.items()}
        return Samples(self.step, poses)


@frozen(eq=False)
class Samples:
    """`KnownMotion` with ``poses`` (12, k) by number of the body."""

    step: float
    poses: Mapping[int, FloatArray]

    @property
    def bodies(self) -> IntArray:
        """The bodies (m,)."""
        return np.array(list(self.poses), dtype=np.int64)

    def speeds(self, reach: FloatArray) -> FloatArray:
        """The greatest speed (m,) of any point of each of the bodies [m/s]. ``reach`` (n,): of all
        about their origins [m]."""
        return np.array(
            [self.travels(body, float(reach[body])).max() / self.step for body in self.poses]
        )

    def travels(self, body: int, reach: float) -> FloatArray:
        """How far any point of a body moves from one sample to the next (k - 1,) [m]."""
        return _travels(self.poses[body][:9], self.poses[body][9:], reach)

    def extents(self, table: BodyTable, grow: float) -> FloatArray:
        """How far each body extends on its way (2, 3, m), see `BodyTable.extents`."""
        found = [
            table.extents(np.full(poses.shape[1], body), poses, grow).max(axis=2)
            for body, poses in self.poses.items()
        ]
        return np.array(found).transpose(1, 2, 0)


class KnownHits:
    """The hits between bodies of a ``search`` of which ``samples`` of their motion are known, and
    bodies that stand still until they are hit.

    Attributes:
        keys: (k,) the near pairs with such bodies alone, by key, ascending.
    """

    def __init__(self, search: HitSearch, samples: Samples) -> None:
        self._search, self._samples, self._step = search, samples, samples.step
        known = np.zeros(len(search.table), dtype=np.bool_)
        known[samples.bodies] = True
        paths, table = search.paths, search.table
        still = (paths.start == paths.end).all(axis=0)
        still |= table.dynamic & (np.abs(paths.start - paths.earlier) <= table.rest_limits).all(0)
        near, able = search.near, search.able
        a, b = near.larger[able], near.smaller[able]
        both = (known | still)[a] & (known | still)[b] & (known[a] | known[b])
        self.keys: IntArray = near.key[able[both]]

    def _posed(self, body: int, samples: IntArray) -> FloatArray:
        """Poses (12, k) of a body at some of the samples (k,)."""
        known = self._samples.poses.get(body)
        if known is not None:
            return known[:, samples]
        return self._search.paths.start[:, [body]].repeat(len(samples), axis=1)

    @property
    def _count(self) -> int:
        return int(next(iter(self._samples.poses.values())).shape[1])

    def _relative_travel(self, pair: IntArray) -> FloatArray:
        """How far any point of one body of a pair moves, as seen from the other one, from one
        sample to the next (k - 1,) [m]."""
        reach = self._search.table.reach[pair]
        large, small = pair[np.argsort(-reach)].tolist()
        samples = np.arange(self._count)
        turn, offset = relative_pose(self._posed(large, samples), self._posed(small, samples))
        return _travels(turn.reshape(9, -1), offset, float(reach.min()))

    def _distances(self, pair: IntArray) -> FloatArray:
        """Signed distances (k,) of a pair at all samples, where they may come within the tolerance;
        elsewhere bounds above 0 [m]."""
        count = self._count
        a, b = pair.tolist()
        coarse = np.array([0, 1, *range(2, count, _STRIDE)])

        def measured(samples: IntArray) -> FloatArray:
            placing = relative_pose(self._posed(a, samples), self._posed(b, samples))
            return self._search.table.narrow.clearances(np.tile(pair, (len(samples), 1)), *placing)

        table = self._search.table
        moved = self._relative_travel(pair)
        # Until the bodies may touch, or part, one distance tells; of those that move together none.
        if moved.sum() <= _TOUCH:
            return np.zeros(count)
        found = np.full(count, measured(np.array([2]))[0])
        farthest = table.tolerance(pair[:1], pair[1:], self._search.settings.tolerance)[0]
        if not -moved[2:].sum() <= found[2] <= moved[2:].sum() + farthest:
            return found
        found = np.full(count, np.inf)
        found[coarse] = measured(coarse)
        near = []
        for begin in range(2, count - 1, _STRIDE):
            ends, way = found[[begin, begin + _STRIDE]], moved[begin : begin + _STRIDE].sum()
            if max(ends) < -way:
                found[begin : begin + _STRIDE] = max(ends)
            elif min(ends) <= way + farthest:
                near += [k for k in range(begin - 2, begin + _STRIDE) if np.isinf(found[k])]
        if near:
            samples = np.unique(near)
            found[samples] = measured(samples)
        return found

    def hits(self) -> Hits:
        """The hits of these pairs, each time that they have been apart."""
        found = Hits.none()
        table, tolerance = self._search.table, self._search.settings.tolerance
        for pair in table.numbers(self.keys):
            reach = table.tolerance(pair[:1], pair[1:], tolerance)[0]
            for sample, after in touches(self._distances(pair), self._step, reach):
                found = found.joined(self._hit(pair, sample, after))
        return found.approaching()

    def _hit(self, pair: IntArray, sample: int, after: float) -> Hits:
        """The hit of a pair ``after`` seconds from a sample, by its motion up to there."""
        search, step = self._search, self._step
        paths = search.paths
        start, velocity, acceleration, spin = (
            values.copy()
            for values in (paths.start, paths.velocity, paths.acceleration, paths.spin)
        )
        for body in pair.tolist():
            before, last, now = self._posed(body, np.arange(sample - 2, sample + 1)).T
            start[:, body] = now
            bend = acceleration[:, body] = (now - 2 * last + before)[9:] / step**2
            velocity[:, body] = (now - last)[9:] / step + bend * (step / 2)
            late, early = (
                spins(one[:, None], other[:, None], step)[:, 0]
                for one, other in ((last, now), (before, last))
            )
            spin[:, body] = late + (late - early) * (0.5 + after / step)
        local = replace(
            paths,
            duration=step,
            start=start,
            velocity=velocity,
            acceleration=acceleration,
            spin=spin,
            trend=np.zeros_like(paths.trend),
        )
        hit = search.table.time_of_impact.hits_after(local, pair[None], np.array([after]))
        since = hit.after + (sample - 2) * step
        return replace(hit, after=since, time=since)

    def landed(self, hits: Hits) -> Hits:
        """Landings, at the ends of the paths, with the times and speeds at which the points of
        these pairs that land do so; those that come to rest before are dropped."""
        rows = among(self._search.table.keys(hits.pairs), self.keys)
        kept = hits.chosen(~rows)
        for k in rows.nonzero()[0].tolist():
            gaps = self._gaps(hits, k)
            for sample, after in touches(gaps, self._step)[:1]:
                rate = 3 * gaps[sample] - 4 * gaps[sample - 1] + gaps[sample - 2]
                bend = gaps[sample] - 2 * gaps[sample - 1] + gaps[sample - 2]
                approach = -(rate / 2 + bend * after / self._step) / self._step
                since = np.array([after + (sample - 2) * self._step])
                one = hits.chosen(np.array([k]))
                kept = kept.joined(
                    replace(one, after=since, time=since, approach=np.array([approach]))
                )
        return kept.approaching()

    def _gaps(self, hits: Hits, k: int) -> FloatArray:
        """How far apart along the normal the material of both bodies is, at all samples (k,), that
        meets in hit number ``k`` [m]."""
        places = []
        for side, body in enumerate(hits.pairs[k].tolist()):
            end = hits.poses[k, side][:, None]
            local = turned_back(end[:9].reshape(3, 3, 1), hits.centre[k][:, None] - end[9:])
            poses = self._posed(body, np.arange(self._count))
            places.append(turned(poses[:9].reshape(3, 3, -1), local) + poses[9:])
        return np.asarray(hits.normal[k] @ (places[1] - places[0]))


def _travels(turn: FloatArray, place: FloatArray, reach: float) -> FloatArray:
    """How far any point within ``reach`` [m] of the origin of a body moves from one of its poses to
    the next (k - 1,) [m]: rotations ``turn`` (9, k) and places (3, k)."""
    way, turned_by = np.diff(place, axis=1), np.diff(turn, axis=1)
    return np.asarray(np.sqrt(dot(way, way)) + np.sqrt((turned_by**2).sum(axis=0)) * reach)


def touches(distances: FloatArray, step: float, reach: float = 0.0) -> list[tuple[int, float]]:
    """When bodies begin to touch that have been apart, by their signed ``distances`` (k,) [m] at
    samples every ``step`` seconds, from the third on: the sample before, and the seconds from it.
    Between two samples they go on as before; so what bounces back within a step is found, too.
    What loses most of its speed at a sample, within ``reach``, has touched there."""
    found: list[tuple[int, float]] = []
    apart = False
    for k in range(2, len(distances) - 1):
        now, then = distances[k], distances[k + 1]
        apart = apart or now > _APART
        turned = bool(found) and k < found[-1][0] + 3  # some of these samples are before it
        if not apart or turned or not np.isfinite(distances[k - 2 : k + 1]).all():
            continue
        rate = (3 * now - 4 * distances[k - 1] + distances[k - 2]) / 2
        bend = now - 2 * distances[k - 1] + distances[k - 2]
        root = rate**2 - 2 * bend * now
        part = 2 * now / (-rate + np.sqrt(root)) if root >= 0 and rate < 0 else np.inf
        if then <= _TOUCH or part <= 1:
            found.append((k, float(min(part, 1.0)) * step))
            apart = False
        elif now <= reach and np.isfinite(then) and now - then < -_KEPT * rate:
            found.append((k, 0.0))
            apart = False
    return found
