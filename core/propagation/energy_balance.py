"""`energy_balance`: statistical energy analysis on the haptic graph.

Subsystems are objects, and regions of those that are larger than the length over which they damp
(`subsystems`). Derivation, units and limits are in ``docs/energy_balance.md``; in short, with
energies E and the powers P that the sources put in:

    m_i Λ_i E_i + Σ_j C_ij (E_i - E_j) = P_i,   Λ_i = 1 / f_i(d_i)², C_ij = Σ transmission² over the
    contacts of i and j, or m_i m_j f(d_ij)² Λ_i Λ_j between regions of one object,

where f is the object's propagation function, d_i a typical distance between contacts of i, and m_i
the mass of a region in (0, 1]. The matrix is symmetric, strictly diagonally dominant and has no
positive off-diagonal entry: there is always a solution, energy is never created, and the gain is
reciprocal.

Source: R. H. Lyon, R. G. DeJong, *Theory and Application of Statistical Energy Analysis*,
Butterworth-Heinemann 1995, chapters 2 and 3.
"""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, added_by, ranges, runs
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, distances
from ..scene.bands import BAND_COUNT
from .conjugate_gradients import Balanced, PowerBalance, solve
from .connections import band_factors, lanes_of
from .subsystems import subsystems

HOPS = 24
"""Distance from a source, in contacts, up to which subsystems are assembled at first; doubled while
farther ones may matter."""

PRECISE = 4e-3
"""Relative error allowed in the energy at a listener: 0.017 dB."""

INAUDIBLE = 1e-12
"""Error of an energy that is always accepted, relative to the injected power: an amplitude of 1e-6,
or -120 dB."""

UNDERFLOW = 1e-280
"""Squares of gains other than 0 are raised to this, so that they do not underflow."""

TINIEST = 1e-140
"""Least bound on the error of an amplitude that is not known to be 0."""

DENSE = 40
"""Objects with at least this many regions have their couplings as a matrix."""

STRAIGHTEST = 4
"""Exponent of the arriving energy in the shares of the regions around a source or listener; the
nearest region has the largest share."""
_EQUALLY_NEAR = 1 + 1e-9
"""Ratio of distances up to which regions are equally near: centres of the regions around one
contact differ by rounding alone."""


@frozen
class Energies:
    """Results of the energy balance.

    Attributes:
        gain: (s, l) amplitude gains.
        error: (s, l) bounds on their errors.
        bands: (s, l, bands) amplitude gains by band, None where no function uses bands.
        subsystems: their number.
    """

    gain: FloatArray
    error: FloatArray
    bands: FloatArray | None
    subsystems: int


def energy_gains(graph: HapticGraph, wanted: BoolArray) -> Energies:
    """Amplitude gains of the wanted pairs (s, l): the square root of the energy at each listener,
    relative to the energy of the source in a lossless, isolated subsystem."""
    gain = np.zeros(wanted.shape)
    error = np.zeros(wanted.shape)
    bands = np.zeros((*wanted.shape, BAND_COUNT)) if graph.uses_bands else None
    rows = np.flatnonzero(wanted.any(axis=1))
    columns = np.flatnonzero(wanted.any(axis=0))
    if len(rows) == 0:
        return Energies(gain, error, bands, 0)
    nodes = [graph.sources[row].nodes for row in rows.tolist()]
    size = np.array([len(part) for part in nodes])
    sources = _Terminals(
        np.array([node for part in nodes for node in part], dtype=np.int64),
        np.arange(len(rows)).repeat(size),
        (1.0 / size).repeat(size),
    )
    listeners = _Terminals(
        graph.listener_nodes[columns], np.arange(len(columns)), np.ones(len(columns))
    )
    forward = len(rows) <= len(columns)  # energies are reciprocal: solved for whichever are fewer
    level, bound, count = _energies(
        graph, *((sources, listeners) if forward else (listeners, sources))
    )
    if not forward:
        level = level.swapaxes(1, 2)
        bound = bound.T
    level = np.minimum(np.maximum(level, 0.0), 1.0) * wanted[rows][:, columns]
    amplitude = np.sqrt(level)
    most = np.sqrt(np.minimum(level[0] + bound, 1.0))
    least = np.sqrt(np.maximum(level[0] - bound, 0.0))
    pairs = rows[:, None], columns
    gain[pairs] = amplitude[0]
    # Its square may be `UNDERFLOW` in the place of a smaller one.
    rounded = (amplitude[0] > 0) & (amplitude[0] <= 2 * TINIEST)
    beyond = np.maximum(np.maximum(most - amplitude[0], amplitude[0] - least), TINIEST)
    error[pairs] = np.where(((bound > 0) | rounded) & wanted[pairs], beyond, 0.0)
    if bands is not None:
        bands[pairs] = np.moveaxis(amplitude[1:], 0, -1)
    return Energies(gain, error, bands, count)


@frozen
class _Terminals:
    """Where sources or listeners are attached to the graph.

    Attributes:
        node: (e,) numbers of the nodes; a source that feeds two objects has two.
        number: (e,) which source or listener each node belongs to, ascending.
        part: (e,) share of the source's power, or 1 for a listener.
    """

    node: IntArray
    number: IntArray
    part: FloatArray

    @property
    def count(self) -> int:
        """Number of sources or listeners."""
        return int(self.number[-1]) + 1


def _energies(
    graph: HapticGraph, driven: _Terminals, observed: _Terminals
) -> tuple[FloatArray, FloatArray, int]:
    """Energies (lanes, d, o) at each of o ``observed`` terminals due to unit power at each of d
    ``driven`` ones, bounds (d, o) on the errors of lane 0, and the number of subsystems."""
    hops = HOPS
    while True:
        found = _Assembly(graph, driven, observed, hops).solved()
        if found is not None:
            return found
        hops *= 2


@frozen
class _Attachments:
    """How the nodes of terminals belong to the subsystems of their objects.

    Attributes:
        first, size: (e,) the attachments of a node are the ``size`` from ``first`` on, in the same
            order for all nodes of an object.
        region: (a,) the subsystem.
        share: (a,) part of the node that belongs to it.
        energy: (lanes, a) that part times the squared gain from the node to the middle of the
            subsystem.
    """

    first: IntArray
    size: IntArray
    region: IntArray
    share: FloatArray
    energy: FloatArray


class _Assembly:
    """The equations of all subsystems within ``hops`` contacts from the ``driven`` terminals.

    Args:
        graph: the scene.
        driven: terminals at which power is injected.
        observed: terminals at which energy is read.
        hops: number of contacts.
    """

    # Contacts, by their nodes, between two assembled objects are *inner*, those to any other object
    # are at the *border*. A subsystem *passes* energy in a lane if its object's gain over its
    # typical distance is not 0; *decay* is its damping.

    def __init__(
        self, graph: HapticGraph, driven: _Terminals, observed: _Terminals, hops: int
    ) -> None:
        self._graph, self._driven, self._observed = graph, driven, observed
        self._lanes = lanes_of(graph)
        nodes = graph.nodes_of_contacts()[graph.transmission > 0]
        objects = graph.node_object[nodes]
        self._reached = _within(
            objects, graph.node_object[driven.node], len(graph.table.names), hops
        )
        inside = self._reached[objects]
        self._border = nodes[inside[:, 0] ^ inside[:, 1]]
        self._inner = nodes[inside.all(axis=1)]
        self._parts = subsystems(graph, np.sort(nodes[inside]))
        through = self._squares(self._parts.of_object, self._parts.distance)
        self._passes = through > 0
        self._decay = 1.0 / np.where(self._passes, through, 1.0)
        self._balance = self._equations()
        self._total = self._balance.diagonal
        self._attachments = self._attached(driven.node), self._attached(observed.node)

    def _squares(self, index: IntArray, distance: FloatArray) -> FloatArray:
        """Squares (lanes, n) of the gains of objects over distances; gains above 1 count as 1."""
        gains = self._graph.table.gains(index, distance)[None]
        if self._lanes > 1:
            gains = np.concatenate([gains, gains * band_factors(self._graph, index, distance).T])
        return np.where(gains > 0, np.maximum(np.minimum(gains, 1.0) ** 2, UNDERFLOW), 0.0)

    def _contact_squares(self, nodes: IntArray) -> FloatArray:
        """The square (lanes, c) of the gain of the contacts of nodes (c,)."""
        graph = self._graph
        contact = graph.contact[nodes]
        gains = graph.transmission[contact][None]
        if self._lanes > 1:
            bands = (
                np.ones((len(contact), BAND_COUNT))
                if graph.contact_band_gains is None
                else graph.contact_band_gains[contact]
            )
            gains = np.concatenate([gains, gains * bands.T])
        return np.minimum(gains, 1.0) ** 2

    def _equations(self) -> PowerBalance:
        """Dampings and couplings. A subsystem of gain 0 absorbs energy and has the energy 0."""
        parts = self._parts
        one, other, value = self._contact_couplings()
        within, among, through, dense = self._region_couplings()
        row = np.concatenate([one, other, within])
        column = np.concatenate([other, one, among])
        coupling = np.concatenate([value, value, through], axis=1)
        order = np.argsort(
            row.astype(np.min_scalar_type(len(parts.mass))), kind="stable"
        )  # short numbers are sorted in linear time
        row = row[order]
        column = column[order]
        coupling = coupling[:, order]
        count = len(parts.mass)
        self._border_part = self._border_couplings()
        region, _, value, _ = self._border_part
        leak = added_by(region, value, count) if len(region) else np.zeros((self._lanes, count))
        if not self._passes.all():
            blocked = ~self._passes[:, column]
            leak += added_by(row, np.where(blocked, coupling, 0.0), count)
            coupling[blocked | ~self._passes[:, row]] = 0.0
        return PowerBalance(parts.mass * self._decay, leak, row, column, coupling, dense)

    def _contact_couplings(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Couplings by contacts: subsystems on either side, and values (lanes, c)."""
        parts, nodes = self._parts, self._inner
        first = parts.node.searchsorted(nodes, side="left")
        size = parts.node.searchsorted(nodes, side="right") - first
        pairs = size.prod(axis=1)
        which = np.arange(len(nodes)).repeat(pairs)
        number = ranges(np.zeros_like(pairs), pairs)
        a = first[which, 0] + number // size[which, 1]
        b = first[which, 1] + number % size[which, 1]
        value = self._contact_squares(nodes[:, 0])[:, which] * (parts.weight[a] * parts.weight[b])
        return parts.region[a], parts.region[b], value

    def _border_couplings(self) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Couplings to objects that are not assembled: subsystem, the object beyond, value (lanes,
        c) and weight of the contact."""
        graph, parts = self._graph, self._parts
        if len(self._border) == 0:
            none = np.zeros(0, dtype=np.int64)
            return none, none, np.zeros((self._lanes, 0)), np.zeros(0)
        inside = self._reached[graph.node_object[self._border]]
        nodes = self._border[inside]
        first = parts.node.searchsorted(nodes, side="left")
        size = parts.node.searchsorted(nodes, side="right") - first
        which = np.arange(len(nodes)).repeat(size)
        place = ranges(first, size)
        beyond = graph.node_object[self._border[~inside]][which]
        return (
            parts.region[place],
            beyond,
            self._contact_squares(nodes)[:, which] * parts.weight[place],
            parts.weight[place],
        )

    def _region_couplings(
        self,
    ) -> tuple[IntArray, IntArray, FloatArray, list[tuple[int, FloatArray]]]:
        """Couplings between regions of the same object. A region of gain 0 has none.

        Returns:
            Both subsystems (c,) and the value (lanes, c) of each coupling, in both directions, in
            objects with few regions; and those in objects with at least `DENSE` regions, as the
            ``blocks`` of `PowerBalance`.
        """
        parts = self._parts
        loss = parts.mass * np.where(self._passes, self._decay, 0.0)
        begin, size = runs(parts.of_object)
        blocks = []
        for first, count in zip(
            begin[size >= DENSE].tolist(), size[size >= DENSE].tolist(), strict=True
        ):
            part = slice(first, first + count)
            apart = distances(parts.centre[part, None], parts.centre[part])
            value = self._squares(parts.of_object[part].repeat(count), apart.reshape(-1)).reshape(
                -1, count, count
            )
            value *= (loss[:, part, None] * loss[:, None, part]) * ~np.eye(count, dtype=np.bool_)
            blocks.append((first, value))
        few = (size > 1) & (size < DENSE)
        begin = begin[few]
        size = size[few]
        each = size.repeat(size)
        a = ranges(begin, size).repeat(each)
        b = ranges(begin.repeat(size), each)
        a, b = a[a != b], b[a != b]
        value = self._squares(parts.of_object[a], distances(parts.centre[a], parts.centre[b]))
        return a, b, value * loss[:, a] * loss[:, b], blocks

    def _attached(self, node: IntArray) -> _Attachments:
        """How nodes ``node`` (e,) belong to the subsystems of their objects: the more energy
        arrives from a subsystem, the larger its share.

        For a listener with an extent, that is the energy at its centre; if none arrives there, the
        nearest subsystem has the whole share. A larger extent thus never moves a listener to
        subsystems with less energy.
        """
        graph, parts = self._graph, self._parts
        index = graph.node_object[node]
        begin = parts.of_object.searchsorted(index, side="left")
        size = parts.of_object.searchsorted(index, side="right") - begin
        first = size.cumsum() - size
        which = np.arange(len(node)).repeat(size)
        region = ranges(begin, size)
        away = distances(graph.node_position[node[which]], parts.centre[region])
        squares = self._squares(index[which], away)
        arriving = squares[0]
        if graph.reach is not None:
            squares = self._squares(index[which], np.maximum(away - graph.reach[node[which]], 0.0))
            at_centre = np.zeros(len(node))
            shortest = np.full(len(node), np.inf)
            np.maximum.at(at_centre, which, arriving)
            np.minimum.at(shortest, which, away)
            arriving = np.where(
                (at_centre[which] == 0) & (away <= shortest[which] * _EQUALLY_NEAR),
                squares[0],
                arriving,
            )
        at_once = self._squares(index, np.zeros(len(index)))[:, which]
        energy = np.minimum(
            1.0, np.divide(squares, at_once, out=np.zeros_like(squares), where=at_once > 0)
        )
        nearest = np.zeros(len(node))
        np.maximum.at(nearest, which, arriving)
        share = (
            np.divide(arriving, nearest[which], out=np.zeros(len(which)), where=nearest[which] > 0)
            ** STRAIGHTEST
            * parts.mass[region]
        )
        total = np.bincount(which, weights=share, minlength=len(node))
        share = np.divide(share, total[which], out=np.zeros(len(which)), where=total[which] > 0)
        return _Attachments(
            first, size, region, share, energy * np.where(self._passes[:, region], share, 0.0)
        )

    def solved(self) -> tuple[FloatArray, FloatArray, int] | None:
        """Energies (lanes, d, o), bounds (d, o) on the errors of lane 0, and the number of
        subsystems, as `_energies`; None if subsystems outside the assembly may matter.
        """
        driven, observed = self._driven, self._observed
        lanes = self._lanes
        count = len(self._parts.mass)
        power = np.zeros((lanes, driven.count, count))
        entry, exit_ = self._attachments
        column = driven.number.repeat(entry.size)
        for lane in range(lanes):
            np.add.at(
                power[lane],
                (column, entry.region),
                entry.energy[lane] * driven.part.repeat(entry.size),
            )
        straight = self._direct_energies()
        receiver = observed.number.repeat(exit_.size)
        reached = np.bincount(
            receiver,
            weights=exit_.share * observed.part.repeat(exit_.size),
            minlength=observed.count,
        )
        unknown = np.zeros(observed.count, dtype=np.bool_)
        if len(self._border):
            unknown[observed.number[~self._reached[self._graph.node_object[observed.node]]]] = True
        reachable = np.flatnonzero((reached > 0) | unknown)
        weight = exit_.energy * observed.part.repeat(exit_.size)

        def received(energy: FloatArray) -> FloatArray:
            return straight + added_by(
                receiver, energy[:, :, exit_.region] * weight[:, None], observed.count
            )

        def good_enough(energy: FloatArray) -> FloatArray:
            return np.asarray(
                np.maximum(
                    INAUDIBLE, PRECISE * received(energy)[:, :, reachable].min(axis=2, initial=1.0)
                )
            )

        found = solve(self._balance, power, good_enough)
        outside = self._outside(found)
        if len(self._border) and np.any(outside > good_enough(found.energy)):
            return None
        bound = np.maximum(found.bound, outside)[0]
        return received(found.energy), bound[:, None] * np.where(unknown, 1.0, reached), count

    def _outside(self, found: Balanced) -> FloatArray:
        """Bounds (lanes, d) on the errors due to subsystems outside the assembly: the energy that
        flows to them, as their dampings are at least 1."""
        region, beyond, _, weight = self._border_part
        if len(region) == 0:
            return np.zeros(found.energy.shape[:2])
        objects, which = np.unique(beyond, return_inverse=True)
        flow = added_by(which, found.energy[:, :, region] * weight, len(objects))
        return np.asarray(flow.max(axis=2, initial=0.0))

    def _direct_energies(self) -> FloatArray:
        """Correction (lanes, d, o) to the energies between terminals in the same object: that on
        the straight way, less what the equations assign to it.

        The equations spread energy uniformly over a subsystem. The fraction of the injected power
        that has not left it reaches a listener by the object's function over their distance
        instead.
        """
        graph, driven, observed = self._graph, self._driven, self._observed
        a, b = np.nonzero(
            graph.node_object[driven.node][:, None] == graph.node_object[observed.node]
        )
        if len(a) == 0:
            return np.zeros((self._lanes, driven.count, observed.count))
        entry, exit_ = self._attachments
        size = entry.size[a]
        which = np.arange(len(a)).repeat(size)
        one = ranges(entry.first[a], size)
        other = ranges(exit_.first[b], size)
        region = entry.region[one]
        left = added_by(
            which,
            entry.share[one] * exit_.share[other] * (self._decay / self._total)[:, region],
            len(a),
        )
        left = np.where(size > 0, np.minimum(left, 1.0), 1.0)
        spread = added_by(
            which, entry.energy[:, one] * exit_.energy[:, other] / self._total[:, region], len(a)
        )
        directly = self._squares(
            graph.node_object[driven.node[a]],
            graph.node_distances(driven.node[a], observed.node[b]),
        )
        terms = (left * directly - spread) * driven.part[a] * observed.part[b]
        pair = driven.number[a] * observed.count + observed.number[b]
        return added_by(pair, terms, driven.count * observed.count).reshape(
            self._lanes, driven.count, observed.count
        )


def _within(contacts: IntArray, starts: IntArray, count: int, hops: int) -> BoolArray:
    """Which of ``count`` objects are at most ``hops`` contacts (c, 2) away from the objects
    ``starts``."""
    reached = np.zeros(count, dtype=np.bool_)
    reached[starts] = True
    for _ in range(hops):
        inside = reached[contacts]
        onwards = inside[:, 0] ^ inside[:, 1]
        if not onwards.any():
            break
        reached[contacts[onwards]] = True
    return reached
