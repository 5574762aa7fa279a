"""`energy_balance`: statistical energy analysis on the haptic graph.

Subsystems are objects, and regions of those that are larger than the length over which they damp
(`subsystems`). Derivation, units and limits are in ``docs/energy_balance.md``; in short, with
energies E under power P at a source or listener:

    m_i (Λ_i - 1 + s_i) E_i + Σ_j C_ij (E_i - E_j) = P_i,   Λ_i = 1 / mean of f_i(d_p)²,
    C_ij = Σ transmission² over the contacts of i and j, or m_i m_j f(d_ij)² Λ_i Λ_j between regions
    of one object,

where f is the object's propagation function, d_p a typical distance from a contact p of i to the
others, m_i the mass of a region in (0, 1], and s_i what an object keeps to itself beside its
losses: 1 if it is large. Source and listener take up a third of 1 - s per energy of their objects;
what arrives then is the squared gain, but for a term that makes it f² in an object alone. It is
reciprocal and at most 1. The matrix is symmetric, strictly diagonally dominant and has no positive
off-diagonal entry: there is always a solution.

Source: R. H. Lyon, R. G. DeJong, *Theory and Application of Statistical Energy Analysis*,
Butterworth-Heinemann 1995, chapters 2 and 3.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, added_by, connected, ranges, runs
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, lengths
from ..scene.bands import BAND_COUNT
from .conjugate_gradients import EPSILON, PowerBalance, is_small, solve, summed
from .connections import band_factors, lanes_of
from .neighbourhood import Near, near
from .subsystems import subsystems

PRECISE = 4e-3
"""Relative error allowed in a squared gain: 0.017 dB."""

INAUDIBLE = 1e-12
"""Error of a squared gain that is always accepted: an amplitude of 1e-6, or -120 dB."""

OWN, OWN_IN_BANDS = 0.06, 0.2
"""Bounds at which an object's energy under power of its own is exact enough: their squares bound
its error. No error is given for bands."""

LARGE = 40_000
"""From so many products in an iteration for all observed nodes on, energies under power of these
are sought in their neighbourhoods."""

SAFETY = 2.0
"""How much more exact the energies are of which a squared gain is made."""

TERMINAL = 1 / 3
"""Damping that a source or listener adds to its object if that is small; none if it is larger than
the length over which it damps."""

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
    """Amplitude gains of the wanted pairs (s, l): roots of the energies that arrive at the
    listeners, relative to what a source gives to a lossless, isolated subsystem."""
    gain = np.zeros(wanted.shape)
    error = np.zeros(wanted.shape)
    bands = np.zeros((*wanted.shape, BAND_COUNT)) if graph.uses_bands else None
    rows = np.flatnonzero(wanted.any(axis=1))
    columns = np.flatnonzero(wanted.any(axis=0))
    if len(rows) == 0:
        return Energies(gain, error, bands, 0)
    nodes = [graph.sources[row].nodes for row in rows.tolist()]
    size = np.array([len(part) for part in nodes])
    ends = np.array([node for part in nodes for node in part]), graph.listener_nodes[columns]
    if len(ends[0]) <= len(ends[1]):  # levels are reciprocal: solved for whichever are fewer
        level, bound, count = _Assembly(graph, *ends).solved()
    else:
        level, bound, count = _Assembly(graph, *ends[::-1]).solved()
        level = level.swapaxes(1, 2)
        bound = bound.T
    begin = size.cumsum() - size
    part = size[:, None]
    level = np.add.reduceat(level, begin, axis=1) / part * wanted[rows][:, columns]
    bound = np.add.reduceat(bound, begin, axis=0) / part
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
class _Attachments:
    """How nodes (e,), the driven ones first, belong to the subsystems of their objects.

    Attributes:
        first, size: (e,) the attachments of a node are the ``size`` from ``first`` on, in the same
            order for all nodes of an object.
        node, region: (a,) of each attachment, the number of the node and that of the subsystem.
        share: (a,) part of the node that belongs to the subsystem.
        energy: (lanes, a) that part times the squared gain from the node to the middle of the
            subsystem.
        through: (lanes, e) the sum of a node's ``energy``.
        distribution: (lanes, a) parts, by subsystem, of the power that a node puts in.
        uptake: (e,) power that a node takes up per energy of its object.
    """

    first: IntArray
    size: IntArray
    node: IntArray
    region: IntArray
    share: FloatArray
    energy: FloatArray
    through: FloatArray
    distribution: FloatArray
    uptake: FloatArray


class _Assembly:
    """The equations of all subsystems that are connected to the ``driven`` nodes.

    Args:
        graph: the scene.
        driven: nodes (d,) of sources or listeners at which power is injected.
        observed: nodes (o,) at which energy is read.
    """

    # A subsystem *passes* energy in a lane if its mean squared gain is not 0; *decay* is the
    # reciprocal of that. *Ends* are the driven nodes, of which there
    # are ``_driven``, and then the observed ones.

    def __init__(self, graph: HapticGraph, driven: IntArray, observed: IntArray) -> None:
        self._graph, self._driven = graph, len(driven)
        self._nodes = np.concatenate([driven, observed])
        self._lanes = lanes_of(graph)
        contacts = graph.nodes_of_contacts()[graph.transmission > 0]
        objects = graph.node_object[contacts]
        component = connected(objects, len(graph.table.names))
        ends = component[graph.node_object[self._nodes]]
        self._connected = ends[: len(driven), None] == ends[len(driven) :]
        reached = np.zeros(len(component), dtype=np.bool_)
        reached[ends[: len(driven)]] = True
        self._contacts = contacts[reached[component[objects[:, 0]]]]
        self._parts = subsystems(graph, np.sort(self._contacts, axis=None))
        through = self._mean_squares()
        self._passes = through > 0
        self._decay = 1.0 / np.where(self._passes, through, 1.0)
        self._balance = self._equations()
        self._ends = self._attached()
        self._inputs, self._column = self._powers()
        self._columns = 1 + int(max(self._driven - 1, self._column.max(initial=0)))

    def _squares(self, index: IntArray, distance: FloatArray) -> FloatArray:
        """Squares (lanes, n) of the gains of objects over distances; gains above 1 count as 1."""
        factors = None if self._lanes == 1 else band_factors(self._graph, index, distance)
        gains = _by_lane(self._graph.table.gains(index, distance), factors)
        passes = gains > 0
        gains *= gains
        np.maximum(gains, UNDERFLOW, out=gains)
        gains *= passes
        return gains

    def _mean_squares(self) -> FloatArray:
        """Means (lanes, r) of the squared gains of subsystems over the typical distances of their
        contacts."""
        parts = self._parts
        squares = self._squares(parts.of_object.take(parts.region), parts.away)
        squares *= parts.part
        mean = added_by(parts.region, squares, len(parts.mass))
        return np.where(mean > 0, np.maximum(mean, UNDERFLOW), 0.0)

    def _contact_squares(self, nodes: IntArray) -> FloatArray:
        """The square (lanes, c) of the gain of the contacts of nodes (c,)."""
        graph = self._graph
        contact = graph.contact.take(nodes)
        bands = None
        if self._lanes > 1:
            bands = (
                np.ones((len(contact), BAND_COUNT))
                if graph.contact_band_gains is None
                else graph.contact_band_gains.take(contact, axis=0)
            )
        gains = _by_lane(graph.transmission.take(contact), bands)
        gains *= gains
        return gains

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
        row = row.take(order)
        column = column.take(order)
        coupling = coupling.take(order, axis=1)
        count = len(parts.mass)
        leak = np.zeros((self._lanes, count))
        if not self._passes.all():
            blocked = ~self._passes[:, column]
            leak += added_by(row, np.where(blocked, coupling, 0.0), count)
            coupling[blocked | ~self._passes[:, row]] = 0.0
        damping = parts.mass * (self._decay - 1.0 + parts.uptake)
        return PowerBalance(damping, leak, row, column, coupling, dense)

    def _contact_couplings(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Couplings by contacts: subsystems on either side, and values (lanes, c)."""
        parts, nodes = self._parts, self._contacts
        begin, count = runs(parts.node)
        first, size = np.zeros((2, self._graph.node_count), dtype=np.int64)
        node = parts.node.take(begin)
        first[node], size[node] = begin, count
        one, other = nodes.T
        size, wide = size.take(one), size.take(other)
        pairs = size * wide
        which = np.arange(len(nodes)).repeat(pairs)
        number = ranges(np.zeros_like(pairs), pairs)
        wide = wide.take(which)
        a = first.take(one).take(which) + number // wide
        b = first.take(other).take(which) + number % wide
        value = self._contact_squares(one).take(which, axis=1)
        value *= parts.weight.take(a) * parts.weight.take(b)
        return parts.region.take(a), parts.region.take(b), value

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
            centre = parts.centre[:, part]
            apart = lengths(*(centre[:, :, None] - centre[:, None]))
            value = self._squares(parts.of_object[part].repeat(count), apart.reshape(-1)).reshape(
                -1, count, count
            )
            value *= (loss[:, part, None] * loss[:, None, part]) * ~np.eye(count, dtype=np.bool_)
            blocks.append((first, value))
        few = (size > 1) & (size < DENSE)
        begin = begin[few]
        size = size[few]
        if len(size) == 0:
            none = np.zeros(0, dtype=np.int64)
            return none, none, np.zeros((self._lanes, 0)), blocks
        each = size.repeat(size)
        a = ranges(begin, size).repeat(each)
        b = ranges(begin.repeat(size), each)
        a, b = a[a != b], b[a != b]
        apart = lengths(*(parts.centre.take(a, axis=1) - parts.centre.take(b, axis=1)))
        value = self._squares(parts.of_object[a], apart)
        return a, b, value * loss[:, a] * loss[:, b], blocks

    def _attached(self) -> _Attachments:
        """How driven and observed nodes belong to the subsystems of their objects: the more energy
        arrives from a subsystem, the larger its share.

        For a listener with an extent, that is the energy at its centre; if none arrives there, the
        nearest subsystem has the whole share. A larger extent thus never moves a listener to
        subsystems with less energy.
        """
        graph, parts, node = self._graph, self._parts, self._nodes
        index = graph.node_object[node]
        begin = parts.of_object.searchsorted(index, side="left")
        size = parts.of_object.searchsorted(index, side="right") - begin
        first = size.cumsum() - size
        which = np.arange(len(node)).repeat(size)
        region = ranges(begin, size)
        place = graph.node_position.T.take(node[which], axis=1)
        away = lengths(*(place - parts.centre.take(region, axis=1)))
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
        passes = self._passes[:, region]
        energy *= np.where(passes, share, 0.0)
        through = added_by(which, energy, len(node))
        distribution = np.divide(
            energy,
            through[:, which],
            out=np.where(passes & (size == 1)[which], 1.0, 0.0),
            where=(through > 0)[:, which],
        )
        uptake = np.zeros(len(node))
        uptake[which] = TERMINAL * (1.0 - parts.uptake[region])
        return _Attachments(
            first, size, which, region, share, energy, through, distribution, uptake
        )

    def _direct_levels(self) -> FloatArray:
        """Correction (lanes, d, o) to the levels between nodes in the same object: that on the
        straight way, less what the equations assign to it.

        The equations spread energy uniformly over a subsystem. The fraction of the injected power
        that has not left it reaches a listener by the object's function over their distance
        instead.
        """
        graph, parts, ends, driven = self._graph, self._parts, self._ends, self._driven
        result = np.zeros((self._lanes, driven, len(self._nodes) - driven))
        index = graph.node_object[self._nodes]
        a, b = np.nonzero(index[:driven, None] == index[driven:])
        if len(a) == 0:
            return result
        size = ends.size[a]
        which = np.arange(len(a)).repeat(size)
        one = ranges(ends.first[a], size)
        other = ranges(ends.first[driven + b], size)
        total = self._balance.diagonal + parts.mass * (1.0 - parts.uptake)
        left, spread = (
            added_by(which, part[..., one] * part[..., other] * factor[:, ends.region[one]], len(a))
            for part, factor in (
                (ends.share, self._decay / total),
                (ends.energy, 1.0 / total),
            )
        )
        left = np.where(size > 0, np.minimum(left, 1.0), 1.0)
        directly = self._squares(
            index[a], graph.node_distances(self._nodes[a], self._nodes[driven + b])
        )
        result[:, a, b] = left * directly - spread
        return result

    def _powers(self) -> tuple[tuple[IntArray, IntArray, FloatArray], IntArray]:
        """The columns of the equations: one for each driven node, and one for each observed node
        that takes up power, nodes in one undivided object together.

        Returns:
            The powers, each by its column (b,), its subsystem (b,) and its size (lanes, b); and the
            column (e,) of each node, 0 of observed nodes that take up none.
        """
        ends, driven = self._ends, self._driven
        column = np.arange(len(self._nodes))
        column[driven:] = 0
        taking = driven + np.flatnonzero(ends.uptake[driven:] > 0)
        whole = ends.size[taking] == 1
        same = np.where(whole, ends.region[ends.first[taking]], -1 - taking)
        _, chosen, number = np.unique(same, return_index=True, return_inverse=True)
        column[taking] = driven + number
        alone = np.concatenate([np.arange(driven), taking[chosen]])
        size = ends.size[alone]
        place = ranges(ends.first[alone], size)
        row = np.arange(len(alone)).repeat(size)
        return (row, ends.region[place], ends.distribution[:, place]), column

    def solved(self) -> tuple[FloatArray, FloatArray, int]:
        """Squared gains (lanes, d, o), bounds (d, o) on the errors of lane 0, and the number of
        subsystems."""
        ends, driven = self._ends, self._driven
        nearby = self._near()
        columns = self._columns - nearby.own.shape[1]
        row, region, part = self._inputs
        everywhere = row < columns
        row, region, part = row[everywhere], region[everywhere], part[:, everywhere]
        column = self._column[driven:]
        power = np.zeros((len(self._parts.mass), self._lanes, columns))
        power[region, :, row] = part.T
        first = int(ends.size[:driven].sum())
        number, heard = ends.node[first:] - driven, ends.region[first:]
        weight = ends.distribution[:, first:]
        # Of nodes without a column: the most that their energy is under unit power of their own.
        most = added_by(number, weight**2 / self._balance.damping.take(heard, axis=1), len(column))
        most = np.sqrt(most)
        has_column = column > 0
        level = self._levels()
        through = ends.through[:, :driven, None] * ends.through[:, None, driven:]

        def across(energy: FloatArray) -> FloatArray:
            arriving = energy.take(heard, axis=0)[..., :driven].transpose(1, 2, 0) * weight[:, None]
            return added_by(number, arriving, len(column))

        def reception(bound: FloatArray) -> FloatArray:
            """Bounds (lanes, 1, o) on the errors of energies under power of the observed nodes."""
            return np.where(has_column, bound.take(column, axis=1), most)[:, None]

        def every(first: FloatArray, second: FloatArray) -> FloatArray:
            return np.concatenate([first, second], axis=1)

        def good_enough(energy: FloatArray, bound: FloatArray) -> FloatArray:
            own = added_by(row, part * energy[region, :, row].T, columns)
            squares = level(across(energy), every(own, nearby.own))
            allowed = np.maximum(PRECISE * squares, INAUDIBLE)
            goal = np.full(own.shape, OWN)
            goal[1:] = OWN_IN_BANDS
            known = reception(every(np.minimum(bound, goal), nearby.bound))
            least = np.maximum(SAFETY * through * known, UNDERFLOW)
            goal[:, :driven] = (allowed / least).min(axis=2, initial=OWN)
            return goal

        found = solve(self._balance, power, good_enough)
        own = every(summed((power + found.residual) * found.energy), nearby.own)
        own_error = found.bound[0] ** 2 + summed(found.rounding[:, 0] * found.energy[:, 0])
        own_error = np.concatenate([own_error, nearby.doubt[0]])
        bound = every(found.bound, nearby.bound)
        where: slice | IntArray = slice(None)
        observed = found.energy[:, :, driven:]
        if len(nearby.where):
            where, observed = nearby.where, nearby.energy
        # What the residuals add, to first order: those of a node's energies under power at another.
        taking = np.flatnonzero(has_column)
        of_observed = _beside(observed[:, :, column[taking] - driven])
        between = across(found.energy)
        rest, rounding = (
            np.einsum("kdn,kon->kdo", _beside(part[where, :, :driven]), of_observed)
            for part in (found.residual, found.rounding)
        )
        between[:, :, taking] += rest
        error = bound[0, :driven, None] * reception(bound)[0]
        error[:, taking] += rounding[0]
        squares = level(between, own)
        highest, lowest = (
            level(between[:1] + sign * error, own[:1] - sign * own_error)[0] for sign in (1.0, -1.0)
        )
        doubt = np.maximum(highest - squares[0], squares[0] - lowest)
        doubt += np.where(through[0] > 0, EPSILON * squares[0], 0.0)
        return squares, doubt * self._connected, len(self._parts.mass)

    def _near(self) -> Near:
        """The energies under power of the observed nodes from their neighbourhoods, or nothing if
        that is not exact enough or does not pay."""
        row, region, part = self._inputs
        observed = row >= self._driven
        goal = np.full((self._lanes, self._columns - self._driven), OWN_IN_BANDS)
        goal[0] = OWN
        products = len(self._balance.row) + 4 * len(self._parts.mass)
        if goal.size * products >= LARGE and not is_small(self._balance):
            inputs = row[observed] - self._driven, region[observed], part[:, observed]
            found = near(self._balance, inputs, goal)
            if (found.doubt <= goal**2).all():
                return found
        none = goal[:, :0]
        return Near(row[:0], none[None], none, none, none)

    def _levels(self) -> Callable[[FloatArray, FloatArray], FloatArray]:
        """Squared gains (lanes, d, o) by energies: those (lanes, d, o) from node to node, and those
        (lanes, columns) where the power of each column is put in."""
        ends, driven, column = self._ends, self._driven, self._column
        entry, exit_ = ends.uptake[:driven, None], ends.uptake[driven:]
        both, either = entry * exit_, np.minimum(entry, exit_)
        through = ends.through[:, :driven, None] * ends.through[:, None, driven:]
        direct = self._direct_levels()

        def level(across: FloatArray, own: FloatArray) -> FloatArray:
            across = np.maximum(across, 0.0)
            kept = 1.0 + ends.uptake * np.maximum(own, 0.0).take(column, axis=1)
            lost = kept[:, :driven, None] * kept[:, None, driven:]
            lost += across * (either - both * across)
            arriving = through * across / np.maximum(lost, 1.0) + direct
            return np.minimum(np.maximum(arriving, 0.0), 1.0)

        return level


def _by_lane(gains: FloatArray, factors: FloatArray | None) -> FloatArray:
    """Gains by lane (lanes, n), none above 1: the plain ``gains`` (n,), then the same times the
    ``factors`` (n, bands) of each band, if there are any."""
    lanes = np.empty((1 if factors is None else 1 + BAND_COUNT, len(gains)))
    lanes[0] = gains
    if factors is not None:
        np.multiply(gains, factors.T, out=lanes[1:])
    return np.minimum(lanes, 1.0, out=lanes)


def _beside(values: FloatArray) -> FloatArray:
    """Values (n, k, s) as (k, s, n): those that are summed are side by side in memory."""
    return np.ascontiguousarray(values.transpose(1, 2, 0))
