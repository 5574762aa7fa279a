"""One contact patch per pair of bodies from those of their cores and triangles."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray, added_by
from ...frozen import frozen
from ..hull import hull_2d
from .core_pairs import CorePairs, by_piece
from .frames import dot, upwards
from .manifold import ROUGHNESS, Patches, contact_plane, within_of

_POINT_AREA, _TIP_AREA = 1e-12, 1e-4
"""Area [m^2] that a point counts as beside others of two cores, and that which two cores count as
beside others of their bodies even where they touch at a point: about that of a fingertip."""

MOST_CORNERS = 8


@frozen
class PairPatches:
    """Per pair of bodies, in the frame of the first: signed ``distance`` (p,) [m] (a lower bound
    beyond the limit of the query), unit ``normal`` (3, p) from first to second, ``centre`` (3, p)
    of the patch, midway between the surfaces, ``area`` (p,) [m^2], and if asked for the ``corners``
    (k, 3) of the outline of each patch."""

    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    area: FloatArray
    corners: tuple[FloatArray, ...] = ()

    def part(self, rows: slice) -> PairPatches:
        """The patches of some of the pairs, without corners."""
        return PairPatches(
            self.distance[rows], self.normal[:, rows], self.centre[:, rows], self.area[rows]
        )

    @classmethod
    def joined(cls, count: int, *parts: tuple[IntArray, PairPatches]) -> PairPatches:
        """Patches of ``count`` pairs from those of some of them, without corners."""
        result = cls(np.empty(count), np.empty((3, count)), np.empty((3, count)), np.empty(count))
        for rows, part in parts:
            result.distance[rows], result.area[rows] = part.distance, part.area
            result.normal[:, rows], result.centre[:, rows] = part.normal, part.centre
        return result


@frozen
class CoreContacts:
    """Pairs of cores in contact: ``owner`` the pair of bodies, ``cores`` the numbers of both and
    of their pieces (3, n), ``distance`` between the surfaces, ``normal``, ``centre`` of the patch,
    ``weight`` (area in square metres; that of a line is tiny, in proportion to its length),
    reported ``area``, the metres ``within`` which the contact counts beyond the nearest one of the
    same pieces, ``corners``."""

    owner: IntArray
    cores: IntArray
    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    weight: FloatArray
    area: FloatArray
    within: FloatArray
    corners: list[FloatArray] | None


def core_contacts(
    rows: CorePairs, normal: FloatArray, distance: FloatArray, patch: Patches, corners: bool
) -> CoreContacts:
    """Contacts of cores, with normals from the first body of the pair to the second.

    Args:
        rows: pairs of cores (n,).
        normal: unit normals from first to second core (3, n).
        distance: signed, between the surfaces (n,) [m].
        patch: where they touch (n,).
        corners: whether the outlines of the patches are wanted.
    """
    points = None
    if corners:
        every = zip(patch.corners.transpose(2, 1, 0), patch.used.T, patch.centre.T, strict=True)
        points = [c[u] if u.any() else m[None] for c, u, m in every]
    outward = np.where(rows.flipped, -normal, normal)
    area = np.where(patch.wide, patch.area, 0.0)
    # Triangles are parts of a face, however small: those that lie on each other belong to the patch
    # as their whole face does.
    within = np.maximum(within_of(patch.area), patch.reach)
    return CoreContacts(
        rows.owner,
        np.array([rows.first, rows.second, 0 * rows.first if rows.piece is None else rows.piece]),
        distance,
        outward,
        patch.centre,
        patch.area,
        area,
        within,
        points,
    )


def reduced(distance: FloatArray, found: list[CoreContacts], corners: bool) -> PairPatches:
    """One patch per pair of bodies from those of its cores and triangles, weighted by their areas
    and by how near they are beside the nearest one of the same pieces of two cores, and of all."""
    count = len(distance)
    normal = upwards(count)
    centre = np.zeros((3, count))
    area = np.zeros(count)
    if not found:
        return PairPatches(
            distance,
            normal,
            centre,
            area,
            tuple(np.zeros((0, 3)) for _ in range(count)) if corners else (),
        )
    owner, cores, each, normals, centres, weights, areas, within = (
        np.concatenate([getattr(f, name) for f in found], axis=-1)
        for name in ("owner", "cores", "distance", "normal", "centre", "weight", "area", "within")
    )
    if len(set(owner.tolist())) == len(owner):
        distance[owner] = np.minimum(distance[owner], each)
        normal[:, owner], centre[:, owner], area[owner] = normals, centres, areas
        kept = np.ones(len(owner), dtype=np.bool_)
    else:
        np.minimum.at(distance, owner, each)
        most_a, most_b, _ = cores.max(axis=1) + 1
        _, of = np.unique((owner * most_a + cores[0]) * most_b + cores[1], return_inverse=True)
        of = by_piece(of, cores[2])
        least = np.full(len(owner), np.inf)
        np.minimum.at(least, of, each)
        near = _near(each - least[of], within)
        weights = near * (weights + _POINT_AREA)
        above = each - distance[owner]
        of_all = _near(above, ROUGHNESS)
        near *= of_all
        weights *= of_all * (1.0 + _TIP_AREA / np.bincount(of, weights)[of])
        kept = weights > 0
        total = np.bincount(owner, weights, count)
        total = np.where(total > 0, total, 1.0)
        centre = added_by(owner, centres * weights, count) / total
        area = added_by(owner, near * areas, count)
        mean = added_by(owner, normals * weights, count)
        length = np.sqrt(dot(mean, mean))
        # Where normals cancel, as those of a body in a narrow gap, use that of the nearest contact.
        order = np.argsort(-above, kind="stable")
        normal[:, owner[order]] = normals[:, order]
        whole = length > 0.1 * total
        normal[:, whole] = mean[:, whole] / length[whole]
        alone = np.bincount(owner, minlength=count)[owner] == 1
        normal[:, owner[alone]] = normals[:, alone]
        centre[:, owner[alone]] = centres[:, alone]
    if not corners:
        return PairPatches(distance, normal, centre, area)
    parts = [c for f in found for c in (f.corners or [])]
    of_pairs: list[list[FloatArray]] = [[] for _ in range(count)]
    for k in np.flatnonzero(kept).tolist():
        of_pairs[owner[k]].append(parts[k])
    return PairPatches(distance, normal, centre, area, _outlines(of_pairs, normal))


def _near(above: FloatArray, within: FloatArray | float) -> FloatArray:
    """How much contacts (n,) count that are ``above`` the nearest one [m]: 1 up to half of
    ``within``, falling to 0."""
    return np.asarray(np.square(np.clip(2.0 - 2.0 * above / within, 0.0, 1.0)))


def _outlines(points: list[list[FloatArray]], normal: FloatArray) -> tuple[FloatArray, ...]:
    """Corners of the convex hull of each patch in its plane, at most ``MOST_CORNERS`` of them."""
    each = [np.concatenate(parts) if parts else np.zeros((0, 3)) for parts in points]
    of = np.repeat(np.arange(len(each)), [len(every) for every in each])
    flat = np.stack(
        [dot(axis[:, of], np.concatenate(each).T) for axis in contact_plane(normal)], axis=1
    )
    rounded = np.round(flat, 5).tolist()
    outlines = []
    begin = 0
    for every in each:
        first: dict[tuple[float, ...], int] = {}
        for number, place in enumerate(rounded[begin : begin + len(every)]):
            first.setdefault(tuple(place), number)
        chosen: IntArray = np.array(list(first.values()), dtype=np.int64)
        if len(chosen) > 1:
            chosen = chosen[hull_2d(flat[begin + chosen])]
        if len(chosen) > MOST_CORNERS:
            chosen = chosen[np.linspace(0, len(chosen), MOST_CORNERS, endpoint=False).astype(int)]
        outlines.append(every[chosen])
        begin += len(every)
    return tuple(outlines)
