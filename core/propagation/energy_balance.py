"""`energy_balance`: statistical energy analysis on the haptic graph.

A subsystem is an object, or a region of one that is larger than the length over which it damps. Derivation, units and limits are in
``docs/energy_balance.md``; in short, with energies E and the powers P that the sources put in:

    Λ_i E_i + Σ_j C_ij (E_i - E_j) = P_i,   Λ_i = 1 / f_i(d_i)²,
    C_ij = Σ share · transmission² over the contacts of i and j, or f(d_ij)² Λ_i Λ_j between regions of one object,

where f is the object's propagation function and d_i a typical distance between the contacts of i. The matrix is symmetric, strictly
diagonally dominant and has no positive entry beside its diagonal: it can always be solved, energy is never created, and exchanging source
and listener changes nothing.

Source: R. H. Lyon, R. G. DeJong, *Theory and Application of Statistical Energy Analysis*, Butterworth-Heinemann 1995, chapters 2 and 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..graph.contact_patches import contact_patches
from ..graph.haptic_graph import HapticGraph, NodeKind, distances
from ..scene.bands import BAND_COUNT
from .elimination import Elimination, eliminated

REGIONS = 256
"""Regions of one object at most."""

DENSE = 1500
"""Up to so many subsystems with many couplings are solved as a dense matrix, more by conjugate gradients."""

ITERATIONS = 2000
PRECISION = 1e-15
"""Conjugate gradients stop when no energy can be wrong by more than this part of the power put in."""

HIGHEST = 1e150
"""Gains and distances above this are taken as this: their squares have to be numbers."""

SAMPLES = 65
"""Distances at which a function without a closed form is looked at, to find where it damps."""


@dataclass(frozen=True, slots=True)
class Energies:
    """Amplitude gains ``gain`` (s, l) and their bounds ``error`` (s, l); ``bands`` (s, l, bands) or None; ``subsystems`` their number;
    ``amplified`` whether a gain above 1 was taken as 1."""

    gain: FloatArray
    error: FloatArray
    bands: FloatArray | None
    subsystems: int
    amplified: bool


@dataclass(frozen=True, slots=True)
class Regions:
    """Subsystems: ``of_object`` (r,) the object of each, ``centre`` (r, 3) [m], ``distance`` (r,) typical distance between contacts [m];
    ``of_node`` (n,) the region of each node, -1 where its object lets nothing through."""

    of_object: IntArray
    centre: FloatArray
    distance: FloatArray
    of_node: IntArray


def energy_gains(graph: HapticGraph) -> Energies:
    """Amplitude gains: the square root of the energy at each listener, relative to what the source would leave at its own place."""
    regions = _regions(graph)
    gain, error, amplified = _lane(graph, regions, None)
    bands = np.stack([_lane(graph, regions, band)[0] for band in range(BAND_COUNT)], axis=-1) if graph.uses_bands else None
    return Energies(gain, error, bands, len(regions.of_object), amplified)


def _lane(graph: HapticGraph, regions: Regions, band: int | None) -> tuple[FloatArray, FloatArray, bool]:
    """Gains and error bounds (s, l) of the plain gains, or of one band."""
    inside = _energy_gain(graph, regions.of_object, regions.distance, band)
    amplified = bool(np.any(inside > 1))
    inside = np.minimum(inside, 1.0)
    # A region that lets nothing through has infinite damping: its energy is 0, and so is what its contacts pass on.
    alive = inside > 0
    damping = 1.0 / np.where(alive, inside, 1.0)
    rows, columns, coupling, created = _couplings(graph, regions, damping, alive, band)
    sources, listeners = _ends(graph, regions, band)
    total = damping + np.bincount(rows, weights=coupling, minlength=len(damping))
    power = np.zeros((len(damping), len(graph.sources)))
    for number, source in enumerate(graph.sources):
        for node in source.nodes:
            region = int(regions.of_node[node])
            if region >= 0 and alive[region]:
                power[region, number] += sources[node] / len(source.nodes)
    energy, doubt = _solve(damping, rows, columns, coupling, power)
    heard = regions.of_node[graph.listener_nodes]
    usable = (heard >= 0) & alive[heard]
    level = np.where(usable[None], energy[heard].T * listeners[None], 0.0)
    for number, source in enumerate(graph.sources):
        for node in source.nodes:
            _near(graph, regions, node, sources[node], number, len(source.nodes), damping, total, alive, listeners, band, level)
    gain = np.sqrt(np.clip(level, 0.0, 1.0))
    bound = doubt[:, None] * np.where(usable, listeners, 0.0)[None]
    error = np.maximum(np.sqrt(level.clip(0.0) + bound) - gain, gain - np.sqrt(np.maximum(level - bound, 0.0)))
    return gain, np.where(bound > 0, np.clip(error, 0.0, 1.0), 0.0), amplified or created


def _near(
    graph: HapticGraph,
    regions: Regions,
    node: int,
    injected: float,
    number: int,
    sides: int,
    damping: FloatArray,
    total: FloatArray,
    alive: BoolArray,
    listeners: FloatArray,
    band: int | None,
    level: FloatArray,
) -> None:
    """In the source's own region: the part of the energy that has not left it yet reaches a listener straight, by the object's function."""
    region = int(regions.of_node[node])
    if region < 0 or not alive[region]:
        return
    same = np.flatnonzero(regions.of_node[graph.listener_nodes] == region)
    straight = distances(graph.node_position[graph.listener_nodes[same]], graph.node_position[node])
    direct = np.minimum(1.0, _energy_gain(graph, np.full(len(same), regions.of_object[region]), straight, band))
    level[number, same] += (damping[region] * direct - injected * listeners[same]) / total[region] / sides


def _energy_gain(graph: HapticGraph, index: IntArray, distance: FloatArray, band: int | None) -> FloatArray:
    """Squares of the gains of objects over distances, of the plain gain or in a band."""
    gains = graph.table.factor[index] * np.exp(-graph.table.decay[index] * distance)
    for number in set(index.tolist()) & graph.table.special:
        chosen = np.flatnonzero(index == number)
        gains[chosen] = graph.table.gain(number, distance[chosen])
    if band is not None:
        if graph.table.band_gains is not None:
            gains = gains * graph.table.band_gains[index, band]
        if graph.table.band_decays is not None:
            gains = gains * np.exp(-graph.table.band_decays[index, band] * distance)
    gains = np.minimum(gains, HIGHEST)
    return np.asarray(gains * gains)


def _lengths(graph: HapticGraph, extents: FloatArray) -> FloatArray:
    """(objects,) distance over which the energy falls to 1/e, infinite where it does not within the object's extent."""
    with np.errstate(divide="ignore"):
        lengths = np.asarray(1.0 / (2.0 * graph.table.decay))
    for index in graph.table.special:
        along = np.linspace(0.0, extents[index], SAMPLES)
        energy = np.square(np.minimum(graph.table.gain(index, along), HIGHEST))
        below = np.flatnonzero(energy < np.max(energy) / math.e)
        lengths[index] = along[below[0]] if len(below) and below[0] > 0 else math.inf
    return lengths


def _regions(graph: HapticGraph) -> Regions:
    """Objects, or boxes of their contacts no larger than the length over which they damp: halved along their longest side until then."""
    count = len(graph.table.names)
    contacts = np.flatnonzero(graph.node_kind == NodeKind.CONTACT)
    objects = graph.node_object[contacts]
    low, high = np.full((count, 3), math.inf), np.full((count, 3), -math.inf)
    filled, first = np.unique(objects, return_index=True)
    if len(filled):
        low[filled] = np.minimum.reduceat(graph.node_position[contacts], first, axis=0)
        high[filled] = np.maximum.reduceat(graph.node_position[contacts], first, axis=0)
    extents = np.zeros(count)
    extents[filled] = distances(high[filled], low[filled])
    used = np.unique(graph.node_object)
    of_object, of_node = [used], np.full(graph.node_count, -1, dtype=np.int64)
    of_node[:] = np.searchsorted(used, graph.node_object)
    lengths = _lengths(graph, extents)
    with np.errstate(invalid="ignore"):
        large = np.flatnonzero(extents > lengths)
    following = len(used)
    for index in large.tolist():
        parts = _halved(graph, contacts[objects == index], float(lengths[index]))
        for part in parts[1:]:
            of_node[part] = following
            following += 1
        of_object.append(np.full(len(parts) - 1, index))
    numbers = np.concatenate(of_object)
    centre, distance = _centres(graph, contacts, of_node, len(numbers))
    empty = np.setdiff1d(np.arange(len(numbers)), of_node[contacts])
    free = np.flatnonzero(graph.node_kind != NodeKind.CONTACT)
    for region in empty.tolist():  # no contacts: only what is inside hears it, straight
        here = free[of_node[free] == region]
        centre[region] = graph.node_position[here].mean(axis=0) if len(here) else 0.0
    for node in free[np.isin(graph.node_object[free], large)].tolist():
        candidates = np.flatnonzero(numbers == graph.node_object[node])
        of_node[node] = candidates[np.argmin(distances(centre[candidates], graph.node_position[node]))]
    return Regions(numbers, centre, distance, of_node)


def _halved(graph: HapticGraph, nodes: IntArray, length: float) -> list[IntArray]:
    """Groups of nodes: boxes cut in the middle of their longest side, the largest box first, until all are small enough or enough."""
    parts = [nodes]
    sizes = [math.inf]
    while len(parts) < REGIONS:
        largest = max(range(len(parts)), key=lambda k: sizes[k])
        if sizes[largest] <= length:
            break
        group = parts[largest]
        position = graph.node_position[group]
        low, high = position.min(axis=0), position.max(axis=0)
        size = float(distances(high, low))
        if sizes[largest] == math.inf and size <= length:
            sizes[largest] = size
            continue
        axis = int(np.argmax(high - low))
        below = position[:, axis] <= low[axis] + (high[axis] - low[axis]) / 2
        if below.all():  # coincident up to rounding
            sizes[largest] = 0.0
            continue
        parts[largest], sizes[largest] = group[below], math.inf
        parts.append(group[~below])
        sizes.append(math.inf)
    return parts


def _centres(graph: HapticGraph, contacts: IntArray, of_node: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Centre of the contacts of each region, and the root mean square distance between two of them; points of one patch count as one."""
    region, share = of_node[contacts], graph.share[graph.contact[contacts]]
    weight = np.bincount(region, weights=share, minlength=count)
    safe = np.where(weight > 0, weight, 1.0)
    position = graph.node_position[contacts]
    centre = np.stack([np.bincount(region, weights=share * position[:, k], minlength=count) for k in range(3)], axis=1) / safe[:, None]
    spread = np.bincount(region, weights=share * np.minimum(distances(position, centre[region]), HIGHEST) ** 2, minlength=count)
    patch = contact_patches(graph)[graph.contact[contacts]]
    keys, which = np.unique(np.column_stack([region, patch]), axis=0, return_inverse=True)
    of_patch = np.bincount(which.reshape(-1), weights=share, minlength=len(keys))
    own = np.bincount(keys[:, 0], weights=of_patch**2, minlength=count) if len(keys) else np.zeros(count)
    pairs = weight - own / safe
    several = pairs > 1e-9 * safe
    return centre, np.where(several, np.sqrt(2 * spread / np.where(several, pairs, 1.0)), 0.0)


def _couplings(
    graph: HapticGraph, regions: Regions, damping: FloatArray, alive: BoolArray, band: int | None
) -> tuple[IntArray, IntArray, FloatArray, bool]:
    """Both directions of every coupling: row, column and value; and whether a transmission above 1 was taken as 1."""
    nodes = np.flatnonzero(graph.partner >= 0)
    one, other = regions.of_node[nodes], regions.of_node[graph.partner[nodes]]
    contact = graph.contact[nodes]
    gain = graph.transmission[contact]
    if band is not None and graph.contact_band_gains is not None:
        gain = gain * graph.contact_band_gains[contact, band]
    value = graph.share[contact] * np.minimum(gain, 1.0) ** 2
    rows, columns, values = [one], [other], [value]
    several = np.flatnonzero(np.bincount(regions.of_object) > 1)
    for index in several.tolist():
        here = np.flatnonzero(regions.of_object == index)
        a, b = np.nonzero(~np.eye(len(here), dtype=np.bool_))
        a, b = here[a], here[b]
        through = np.minimum(_energy_gain(graph, np.full(len(a), index), distances(regions.centre[a], regions.centre[b]), band), 1.0)
        rows.append(a)
        columns.append(b)
        values.append(through * damping[a] * damping[b])
    row, column, coupling = np.concatenate(rows), np.concatenate(columns), np.concatenate(values)
    kept = np.flatnonzero(alive[row] & alive[column] & (coupling > 0))
    order = kept[np.lexsort((column[kept], row[kept]))]
    return row[order], column[order], coupling[order], bool(np.any(gain > 1))


def _ends(graph: HapticGraph, regions: Regions, band: int | None) -> tuple[FloatArray, FloatArray]:
    """Part of the energy that gets from each node (n,) to the middle of its region, relative to no distance; the same of listeners (l,)."""
    region = regions.of_node
    distance = np.where(region >= 0, distances(graph.node_position, regions.centre[region]), 0.0)
    there = _energy_gain(graph, graph.node_object, distance, band)
    at_once = _energy_gain(graph, graph.node_object, np.zeros_like(distance), band)
    part = np.minimum(1.0, there / np.where(at_once > 0, at_once, 1.0))
    return part, part[graph.listener_nodes]


def _solve(
    damping: FloatArray, rows: IntArray, columns: IntArray, coupling: FloatArray, power: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Energies (r, s), and for each source (s,) a bound of how wrong any of them is: 0 where all of it is elimination."""
    parts = Elimination(damping, rows, columns, coupling)
    passed = parts.forward(power)
    equations = parts.damping, parts.rows, parts.columns, parts.coupling, passed[parts.core]
    energy, doubt = (eliminated(*equations), np.zeros(power.shape[1])) if len(parts.core) <= DENSE else _iterated(*equations)
    return parts.back(energy, passed), doubt


def _iterated(
    damping: FloatArray, rows: IntArray, columns: IntArray, coupling: FloatArray, power: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """By conjugate gradients. The rows of the matrix add up to the damping, so ``|M⁻¹ r| <= max |r_i| / Λ_i``: the residual of any solution
    bounds its error."""
    total = damping + np.bincount(rows, weights=coupling, minlength=len(damping))
    filled, first = np.unique(rows, return_index=True)

    def apply(values: FloatArray) -> FloatArray:
        result = total[:, None] * values
        if len(filled):
            result[filled] -= np.add.reduceat(coupling[:, None] * values[columns], first, axis=0)
        return result

    energy = power / total[:, None]
    residual = power - apply(energy)
    direction = residual / total[:, None]
    product = (residual * direction).sum(axis=0)
    goal = PRECISION * np.abs(power).max(axis=0)
    for _ in range(ITERATIONS):
        doubt = (np.abs(residual) / damping[:, None]).max(axis=0)
        if np.all(doubt <= goal) or not np.any(product > 0):
            break
        applied = apply(direction)
        curvature = (direction * applied).sum(axis=0)
        step = np.where(curvature > 0, product / np.where(curvature > 0, curvature, 1.0), 0.0)
        energy += step * direction
        residual -= step * applied
        scaled = residual / total[:, None]
        following = (residual * scaled).sum(axis=0)
        direction = scaled + np.where(product > 0, following / np.where(product > 0, product, 1.0), 0.0) * direction
        product = following
    least: FloatArray = np.maximum(energy, 0.0)
    doubt = (np.abs(power - apply(least)) / damping[:, None]).max(axis=0)
    return least, doubt
