"""The subsystems of an energy balance: objects, and regions of those that are larger than the
length over which they damp.

Regions are the points of a lattice in the object's own axes about the middle of its bounding box,
spaced by the length over which its gain falls to 1/e. A contact belongs to the regions around it
with multilinear weights that add up to 1. Within half a spacing of the middle along each axis these
weights are constant, so an object no larger than that is one subsystem. Energies are therefore
continuous functions of the positions of contacts. Only regions with a contact exist.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..arrays import FloatArray, IntArray, added_by, runs
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, NoGain, ObjectTable, lengths

REGIONS, MOST_REGIONS = 128, 1024
"""Most regions of one object, about, where most of its contacts are, and where all of them are: the
lattice of a larger one is coarser."""

TAILS = 0.05, 0.15
"""Between these fractions of the contacts' strengths along an axis lie those that tell where most
contacts begin and end. The few beyond don't count: a body far away changes no lattice."""

FARTHEST = 2.0**40
"""Largest distance of a lattice point from the middle, in spacings: contacts further away belong to
the outermost point."""

LEAST = 0.005
"""Least power that a subsystem takes up per energy: no object is entirely without losses."""

HIGHEST = 1e140
"""Largest distance, whose square is still finite."""

DENSE = 64
"""Most cells per row for which rows are numbered through a table of all cells instead of by
sorting."""

CORNERS = np.array(list(itertools.product((0, 1), repeat=3))).T
"""The lattice points (3, 8) around a place, relative to the lowest."""

LIGHTEST = 1e-100
"""Least mass of a region, whose reciprocal is still finite."""

STEPS = 60
"""Most steps to the length over which the gain of a function with spreading falls to 1/e."""

SAMPLES, REFINED = 1025, 12
"""Distances at which a function without a closed form is evaluated, to find where it damps, and how
often at most the interval is narrowed."""

ROUNDING = 1e-14
"""Relative width of that interval at which it is narrow enough: energies depend on the length, and
their certified bounds do not."""


@frozen
class Subsystems:
    """Subsystems, and how contact nodes belong to them.

    Attributes:
        of_object: (r,) object of each subsystem.
        centre: (3, r) middle of its contacts [m].
        mass: (r,) in (0, 1]: of a region, the largest part of a contact in it, relative to the
            object's strongest contact; of an undivided object 1.
        uptake: (r,) power that it takes up per energy and mass if it loses nothing: `LEAST` in an
            object smaller than half the length over which that damps, 1 in a large one.
        node: (a,) contact nodes, sorted; a node is repeated for every region that it belongs to.
        region: (a,) the subsystem.
        weight: (a,) of that node, in (0, 1].
        part: (a,) of the strengths of the subsystem's contacts, adding up to 1 in each.
        away: (a,) typical distance to its other contacts [m].
    """

    of_object: IntArray
    centre: FloatArray
    mass: FloatArray
    uptake: FloatArray
    node: IntArray
    region: IntArray
    weight: FloatArray
    part: FloatArray
    away: FloatArray


def subsystems(graph: HapticGraph, nodes: IntArray) -> Subsystems:
    """The subsystems that contact nodes ``nodes`` (sorted) belong to."""
    object_of = graph.node_object[nodes]
    begin, size = runs(object_of)
    used = object_of[begin]
    slot = np.arange(len(begin)).repeat(size)
    strength = graph.weight.take(graph.contact.take(nodes))
    position = graph.node_position.T.take(nodes, axis=1)
    on_object = _on_objects(graph, position, object_of)
    which, region, weight, of_object, divided, uptake = _attached(
        graph, position, on_object, strength, used, slot, begin
    )
    place = on_object
    if divided.any():
        place = np.where(
            divided[region] > 0, position.take(which, axis=1), on_object.take(which, axis=1)
        )
    centre, part, away, largest = _extents(strength[which] * weight, place, region, len(of_object))
    mass = np.ones(len(of_object))
    if divided.any():
        strongest = np.maximum.reduceat(strength, begin)[used.searchsorted(of_object)]
        mass = np.where(divided, np.clip(largest / strongest, LIGHTEST, 1.0), 1.0)
    return Subsystems(of_object, centre, mass, uptake, nodes[which], region, weight, part, away)


def _on_objects(graph: HapticGraph, position: FloatArray, index: IntArray) -> FloatArray:
    """Places (3, n) of contacts on objects ``index`` (n,), those beyond the bounding box at its
    nearest point: an object damps no farther than it reaches."""
    frames = graph.frames
    shaped = np.flatnonzero(~np.isnan(frames.size[index, 0]))
    if len(shaped) == 0:
        return position
    index = index[shaped]
    axes, half = frames.axes[index], frames.size[index] / 2
    along = (axes * (position[:, shaped].T - frames.centre[index])[:, :, None]).sum(axis=1)
    beyond = along - np.minimum(np.maximum(along, -half), half)
    result = position.copy()
    result[:, shaped] -= (axes * beyond[:, None]).sum(axis=2).T
    return result


def _attached(
    graph: HapticGraph,
    position: FloatArray,
    on_object: FloatArray,
    strength: FloatArray,
    used: IntArray,
    slot: IntArray,
    begin: IntArray,
) -> tuple[IntArray, IntArray, FloatArray, IntArray, FloatArray, FloatArray]:
    """How contacts belong to subsystems.

    Args:
        graph: the scene.
        position: of the contacts (3, n) [m].
        on_object: the same, nowhere beyond their objects.
        strength: their weights (n,).
        used: objects with contacts (m,).
        slot: which of these each contact is on (n,), ascending.
        begin: the first contact of each object (m,).

    Returns:
        Number of the contact (a,), sorted; its subsystem (a,) and weight (a,); object of each
        subsystem (r,), whether that is divided, and its uptake (r,).
    """
    count = len(used)
    middle = graph.frames.centre.T.take(used, axis=1)
    radius = lengths(*graph.frames.size.T.take(used, axis=1)) / 2
    unknown = np.flatnonzero(np.isnan(radius))
    if len(unknown):
        first, last = _trimmed_ends(position, strength, slot, count)[..., unknown]
        middle[:, unknown] = (first + last) / 2
        radius[unknown] = lengths(*(first - last)) / 2
    about = middle.take(slot, axis=1)
    relative = np.minimum(np.maximum(position - about, -HIGHEST), HIGHEST)
    reach = np.minimum(lengths(*(on_object - about)), HIGHEST)
    farthest = np.maximum.reduceat(reach, begin)
    extent = np.minimum(2 * np.maximum(radius, farthest), HIGHEST)
    spacing = damping_lengths(graph.table, used, extent)
    divided = farthest > spacing / 2
    uptake = np.clip(2 * np.minimum(radius, spacing) / spacing - 1, LEAST, 1.0)
    everyone = np.arange(len(slot))
    if not divided.any():
        return everyone, slot, np.ones(len(slot)), used, np.zeros(count), uptake
    inside = divided[slot]
    chosen = np.flatnonzero(inside)
    axes = graph.frames.axes.transpose(1, 2, 0).take(used[slot[chosen]], axis=2)
    off = relative.take(chosen, axis=1)
    local = axes[0] * off[0] + axes[1] * off[1] + axes[2] * off[2]
    total = np.asarray(np.bincount(slot, weights=strength, minlength=count), dtype=np.float64)
    contact, cells, region, weight = _lattice(local, strength[chosen], spacing, slot[chosen], total)
    contact = chosen[contact]
    of_slot = np.concatenate([np.flatnonzero(~divided), cells])
    order = np.argsort(of_slot, kind="stable")
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    single = np.full(count, -1, dtype=np.int64)
    single[~divided] = number[: count - int(divided.sum())]
    which = np.concatenate([everyone[~inside], contact])
    regions = np.concatenate([single[slot[~inside]], number[count - int(divided.sum()) :][region]])
    weights = np.concatenate([np.ones(int((~inside).sum())), weight])
    by_contact = np.argsort(which, kind="stable")
    return (
        which[by_contact],
        regions[by_contact],
        weights[by_contact],
        used[of_slot[order]],
        divided[of_slot[order]].astype(np.float64),
        uptake[of_slot[order]],
    )


def _trimmed_ends(
    place: FloatArray, strength: FloatArray, slot: IntArray, count: int
) -> FloatArray:
    """Ends (2, 3, count) along each axis of the range in which most contacts of each object lie:
    the mean position of the contacts between the quantiles `TAILS`, and between those quantiles
    counted from the other end. Unlike the extreme contacts, these change continuously when a weak
    contact comes or goes.

    Args:
        place: of the contacts (3, n) [m].
        strength: their weights (n,).
        slot: which object each contact is on (n,), ascending.
        count: number of objects.
    """
    begin, size = runs(slot)
    ends = np.zeros((2, 3, count))
    ends[:, :, slot] = place  # whichever is last of each object
    for along, first, last in zip(place, *ends, strict=True):
        np.minimum.at(first, slot, along)
        np.maximum.at(last, slot, along)
    weight = np.maximum(strength, np.finfo(np.float64).tiny)
    weight = weight / np.bincount(slot, weights=weight, minlength=count)[slot]
    # Where the first and the last contact are more than that, their places are these means.
    many = (np.minimum.reduceat(weight, begin) < TAILS[1]).repeat(size)
    if not many.any():
        return ends
    slot = slot[many]
    weight = weight[many]
    begin, size = runs(slot)
    chosen = slot[begin]
    objects_before = np.arange(len(begin)).repeat(size)  # each adds 1 to the sum
    along = place[:, many]
    # Short numbers are sorted in linear time.
    short = slot.astype(np.min_scalar_type(count))
    order = np.lexsort((along, np.broadcast_to(short, along.shape)))
    along = np.take_along_axis(along, order, axis=1)
    part = weight[order]
    above = part.cumsum(axis=1) - objects_before
    for end, (low, high) in zip(ends, (TAILS, (1 - TAILS[1], 1 - TAILS[0])), strict=True):
        within = np.maximum(np.minimum(above, high) - np.maximum(above - part, low), 0.0)
        end[:, chosen] = np.add.reduceat(within * along, begin, axis=1) / (high - low)
    return ends


def _lattice(
    local: FloatArray,
    strength: FloatArray,
    spacing: FloatArray,
    slot: IntArray,
    total: FloatArray,
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Distribute contacts to the points of their objects' lattices, with multilinear weights.

    Args:
        local: places of the contacts in the axes of their objects, about the middle (3, n) [m].
        strength: their weights (n,).
        spacing: of the lattice of each object (m,) [m].
        slot: which object each contact is on (n,), ascending.
        total: sum of the weights of all contacts of each object (m,).

    Returns:
        Number of the contact (a,), ascending; the ``slot`` of each region (r,), that is, of each
        lattice point with a contact; region (a,); weight (a,) > 0, which add up to 1 for each
        contact.
    """
    step = _coarsened(local, strength, spacing, slot, total)[slot]
    along = np.sign(local) * np.minimum(np.maximum(np.abs(local) / step - 0.5, 0.0), FARTHEST)
    base = np.floor(along)
    x, y, z = np.stack([1.0 - (along - base), along - base], axis=-1)
    weight = (x[:, :, None, None] * y[:, None, :, None] * z[:, None, None, :]).reshape(-1)
    near = np.flatnonzero(weight)
    place = near // 8
    corner = near % 8
    cells, region = _numbered(slot, base.astype(np.int64), place, corner)
    return place, cells, region, weight[near]


def _coarsened(
    local: FloatArray,
    strength: FloatArray,
    spacing: FloatArray,
    slot: IntArray,
    total: FloatArray,
) -> FloatArray:
    """Spacings (m,) of lattices, so large that no object has many more than `REGIONS` regions where
    most of its contacts are, nor than `MOST_REGIONS` in all.

    Regions are no more than the lattice points within the extents of the contacts, nor than eight
    for each contact. The harmonic mean of the two is a continuous estimate.

    Args:
        local: places of the contacts in the axes of their objects, about the middle (3, n) [m].
        strength: their weights (n,).
        spacing: of the lattice of each object without that limit (m,) [m], which is changed.
        slot: which object each contact is on (n,), ascending.
        total: sum of the weights of all contacts of each object (m,).
    """
    around = 8 * total
    many = (around > REGIONS)[slot]
    if not many.any():
        return spacing
    local = local[:, many]
    slot = slot[many]
    begin, _ = runs(slot)
    whole = np.zeros((3, len(spacing)))
    whole[:, slot[begin]] = np.maximum.reduceat(local, begin, axis=1) - np.minimum.reduceat(
        local, begin, axis=1
    )
    inner = 1 - sum(TAILS)

    def too_many(extent: FloatArray, regions: int) -> tuple[IntArray, FloatArray]:
        """Numbers of the objects with more lattice points within their ``extent`` than so many
        ``regions`` allow, and the most that these allow (m,)."""
        most = np.divide(
            regions * around,
            around - regions,
            out=np.full(len(around), math.inf),
            where=around > regions,
        )
        points = (1.0 + extent / np.maximum(spacing, 1e-300)).prod(axis=0)
        return np.flatnonzero(points > most), most

    if len(too_many(whole / inner, REGIONS)[0]) == 0:
        return spacing
    first, last = _trimmed_ends(local, strength[many], slot, len(spacing))
    for extent, regions in (((last - first) / inner, REGIONS), (whole, MOST_REGIONS)):
        exceeded, most = too_many(extent, regions)
        for number in exceeded.tolist():
            spacing[number] = _coarse_enough(
                extent[:, number].tolist(), float(spacing[number]), float(most[number])
            )
    return spacing


def _coarse_enough(extent: list[float], spacing: float, most: float) -> float:
    """The spacing [m] at which a lattice has ``most`` points within an ``extent`` (3,) [m], by
    bisection upwards from a finer ``spacing``."""
    fine = math.log(max(spacing, 1e-300))
    coarse = math.log(max(extent)) + 1.0
    for _ in range(60):
        middle = (fine + coarse) / 2
        fine, coarse = (
            (middle, coarse)
            if math.prod([1.0 + along / math.exp(middle) for along in extent]) > most
            else (fine, middle)
        )
    return math.exp(coarse)


def _numbered(
    slot: IntArray, base: IntArray, place: IntArray, corner: IntArray
) -> tuple[IntArray, IntArray]:
    """Distinct cells in ascending order.

    Args:
        slot: which object each contact is on (n,).
        base: the lowest lattice point around each (3, n).
        place: number of the contact (a,).
        corner: number in `CORNERS` of the lattice point (a,).

    Returns:
        The ``slot`` of each cell, that is, of each object's lattice point that occurs, and the
        number of the cell (a,).
    """
    keys = np.concatenate([slot[None], base])
    low = keys.min(axis=1)
    size = (keys.max(axis=1) - low + [1, 2, 2, 2]).tolist()
    if math.prod(size) >= 2**62:
        keys = keys.take(place, axis=1)
        keys[1:] += CORNERS.take(corner, axis=1)
        _, first, which = np.unique(keys, axis=1, return_index=True, return_inverse=True)
        return keys[0, first], which.reshape(-1)
    key = np.ravel_multi_index(tuple(keys - low[:, None]), size)[place]
    key += np.ravel_multi_index(tuple(CORNERS), size[1:])[corner]
    if math.prod(size) > DENSE * len(key):
        cells, which = np.unique(key, return_inverse=True)
    else:
        taken = np.bincount(key) > 0
        cells = np.flatnonzero(taken)
        which = (taken.cumsum() - 1)[key]
    return cells // math.prod(size[1:]) + low[0], which


def _extents(
    strength: FloatArray, position: FloatArray, region: IntArray, count: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Extents of the contacts (a,) of ``count`` regions.

    The typical distance of a contact is that to the middle, in the ratio in which the root mean
    square distance between two different contacts is to that from the middle: the distance between
    two contacts, the root of 2 times that to the middle of many. Pairs are weighted by the product
    of their strengths. Where these add up to less than one pair, as while a contact parts, the
    other contact counts with itself as the rest.

    Returns:
        Middle (3, r) of each region, parts (a,) of its strengths, typical distances (a,), and the
        largest strength (r,).
    """
    strength = np.maximum(strength, np.finfo(np.float64).tiny)
    total = np.bincount(region, weights=strength, minlength=count)
    centre = added_by(region, strength * position, count) / total
    own = np.bincount(region, weights=strength * strength, minlength=count)
    ratio = total * np.sqrt(2 / np.maximum(total * total - own, 2.0))
    away = np.minimum(lengths(*(position - centre.take(region, axis=1))) * ratio[region], HIGHEST)
    largest = np.zeros(count)
    np.maximum.at(largest, region, strength)
    return centre, strength / total[region], away, largest


def damping_lengths(table: ObjectTable, index: IntArray, extent: FloatArray) -> FloatArray:
    """Length (m,) [m] over which the gain in each object falls to 1/e of its largest, infinite
    where it does not within ``extent`` (m,) [m]. ``index`` (m,): numbers of the objects."""
    lengths = np.full(len(index), math.inf)
    special = (
        np.isin(index, sorted(table.special))
        if table.special
        else np.zeros(len(index), dtype=np.bool_)
    )
    for number in np.flatnonzero(special).tolist():
        lengths[number] = _sampled_length(table, int(index[number]), float(extent[number]))
    closed = np.flatnonzero(~special)
    damped = closed[table.costs(index[closed], extent[closed])[1] > 1]
    if table.spreading is None:
        lengths[damped] = 1.0 / table.decay[index[damped]]
        return lengths
    # By Newton's method from 0, which stays below the length: costs are concave.
    chosen = index[damped]
    below = np.zeros(len(damped))
    for _ in range(STEPS):
        missing = 1.0 - table.costs(chosen, below)[1]
        slope = table.decay[chosen] + table.spreading.slope(chosen, below)
        step = np.divide(
            missing, slope, out=np.zeros_like(slope), where=(missing > 0) & (slope > 0)
        )
        reached = np.minimum(below + step, extent[damped])
        if np.array_equal(reached, below):
            break
        below = reached
    lengths[damped] = below
    return lengths


def _sampled_length(table: ObjectTable, index: int, extent: float) -> float:
    """The length of `damping_lengths` for one object, whose function has no closed form: the gain
    is sampled within ``extent`` [m]."""
    wanted, low, high = math.nan, 0.0, extent
    for _ in range(REFINED):
        along = np.linspace(low, high, SAMPLES)
        try:
            gains = table.gain(index, along)
        except NoGain:
            return math.inf
        if math.isnan(wanted):
            wanted = float(np.max(gains)) / math.e
        below = np.flatnonzero(gains < wanted)
        if len(below) == 0 or below[0] == 0:
            return math.inf if high == extent else high
        low = float(along[below[0] - 1])
        high = float(along[below[0]])
        if high - low <= ROUNDING * high:
            break
    return high
