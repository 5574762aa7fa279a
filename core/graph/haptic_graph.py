"""The haptic graph: nodes as arrays sorted by object, inter-connections stored, intra-connections
implied by the object.

All nodes of one object are connected to each other, so the number of connections is quadratic in
theirs and connections are not stored. An object's nodes are one slice, and the gain between two of
them is its propagation function at their distance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from ..arrays import FloatArray, IntArray, differing, with_rows
from ..contacts.authored import ARRAYS, rows_of
from ..contacts.contact_set import ContactSet
from ..contacts.forces import contact_forces
from ..frozen import frozen
from ..scene.bands import BAND_COUNT
from ..scene.functions import ModulationFunction
from ..scene.functions.spreading import Spreading
from ..scene.rules import Motion
from ..scene.spectra import leading_band
from ..scene.values import HapticObject, HapticScene, Listener, Source, SourceKind, Vector
from .impedances import Bodies, passed_by_bodies
from .object_frames import ObjectFrames


class NoGain(ValueError):
    """Error for an expression without a valid gain; ``objects``: the name of its object, or those
    of the contact's two objects."""

    def __init__(self, message: str, objects: tuple[str, ...]) -> None:
        super().__init__(message)
        self.objects = objects


@frozen(eq=False)
class ObjectTable:
    """The propagation functions of all objects as arrays, in the order of their sorted names.

    The gain of an object over d metres is ``factor * exp(-decay * d)``, times that of its
    `Spreading`. The cost ``-log(gain)`` is therefore a constant plus a metric, a concave function
    of distance that is 0 at distance 0.

    Attributes:
        factor, decay: (n,); NaN for the objects in ``special``.
        loss: (n,) ``-log(factor)``, accurate also for a factor close to 1.
        spreading: the laws (n,); None if no object has any.
        special: numbers of the objects whose function has another form.
        band_gains: (n, bands), or None if no object uses them.
        band_decays: (n, bands) [1/m], or None.
        slowness: (n,) [s/m], or None.
        properties: (2, n) kappa and rho, which transmission functions may depend on.
    """

    names: tuple[str, ...]
    objects: tuple[HapticObject, ...]
    factor: FloatArray
    decay: FloatArray
    loss: FloatArray
    spreading: Spreading | None
    special: frozenset[int]
    epsilon: float
    band_gains: FloatArray | None
    band_decays: FloatArray | None
    slowness: FloatArray | None
    properties: FloatArray
    _index: dict[str, int] = field(init=False, repr=False, compare=False)
    _in_bands: dict[int, ObjectTable] = field(
        init=False, repr=False, compare=False, default_factory=dict
    )
    _bodies: list[Bodies] = field(init=False, repr=False, compare=False, default_factory=list)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_index", {name: i for i, name in enumerate(self.names)})

    def in_band(self, band: int) -> ObjectTable:
        """A table with the gains of a frequency band in place of the plain ones; functions without
        a closed form keep theirs. Returns itself if nothing differs."""
        if band not in self._in_bands:
            loss, decay = self.loss, self.decay
            with np.errstate(divide="ignore"):
                loss = loss if self.band_gains is None else loss - np.log(self.band_gains[:, band])
            decay = decay if self.band_decays is None else decay + self.band_decays[:, band]
            same = np.array_equal(loss, self.loss, equal_nan=True) and np.array_equal(
                decay, self.decay, equal_nan=True
            )
            self._in_bands[band] = (
                self if same else replace(self, factor=np.exp(-loss), loss=loss, decay=decay)
            )
        return self._in_bands[band]

    @classmethod
    def of(cls, objects: Sequence[HapticObject], epsilon: float) -> ObjectTable:
        """Tabulate the objects (each name once). Sorting by name makes every result independent of
        their order."""
        ordered = tuple(sorted(objects, key=lambda o: o.name))
        # Large scenes are of few materials: each function is asked once.
        keys = [(id(o.propagation), o.kappa, o.rho) for o in ordered]
        alike = dict(zip(keys, ordered, strict=True))
        number = {key: k for k, key in enumerate(alike)}
        of = np.array([number[key] for key in keys], dtype=np.int64)
        kinds = tuple(alike.values())
        pairs = [o.propagation.log_linear(o.kappa, o.rho, epsilon) for o in kinds]
        forms = np.array(
            [
                (math.nan, math.nan, math.nan)
                if pair is None
                else (*pair, o.propagation.loss(o.kappa, o.rho, epsilon))
                for o, pair in zip(kinds, pairs, strict=True)
            ],
            dtype=np.float64,
        ).reshape(-1, 3)
        factor, decay, loss = forms.T.take(of, axis=1)
        bands, decays, slowness = (
            None if values is None else values.take(of, axis=0)
            for values in _spectrum_arrays(
                [o.propagation for o in kinds],
                [o.propagation.band_decays(o.kappa, o.rho) for o in kinds],
            )
        )
        special = np.array([pair is None for pair in pairs], dtype=np.bool_)
        return cls(
            names=tuple(o.name for o in ordered),
            objects=ordered,
            factor=factor,
            decay=decay,
            loss=loss,
            spreading=Spreading.of([o.propagation.spreading_law() for o in kinds], of),
            special=frozenset(np.flatnonzero(special[of]).tolist()),
            epsilon=epsilon,
            band_gains=bands,
            band_decays=decays,
            slowness=slowness,
            properties=np.array([(o.kappa, o.rho) for o in kinds], dtype=np.float64)
            .reshape(-1, 2)
            .T.take(of, axis=1),
        )

    @property
    def bodies(self) -> Bodies:
        """The bodies of the objects, by whose impedances contacts pass on."""
        if not self._bodies:
            self._bodies.append(Bodies.of(self.objects))
        return self._bodies[0]

    def index(self) -> Mapping[str, int]:
        """Number of each object by name."""
        return self._index

    def gain(self, index: int, distance: FloatArray) -> FloatArray:
        """Gains of object ``index`` over ``distance`` (metres, any shape). Raises NoGain if its
        expression gives none, and ValueError for a distance that is negative or not finite."""
        if not np.all((distance >= 0) & (distance < math.inf)):
            raise ValueError("distance: must be finite and at least 0 m")
        if index not in self.special:
            gains = self.factor[index] * np.exp(-self.decay[index] * distance)
            return np.asarray(
                gains
                if self.spreading is None
                else gains * np.exp(-self.spreading.cost(index, distance))
            )
        haptic_object = self.objects[index]
        try:
            return haptic_object.propagation.gain(
                distance, haptic_object.kappa, haptic_object.rho, self.epsilon
            )
        except ValueError as error:
            raise NoGain(f"object {haptic_object.name!r}: {error}", (haptic_object.name,)) from None

    def gains(
        self,
        index: IntArray,
        distance: FloatArray,
        ends: tuple[FloatArray, FloatArray] | None = None,
    ) -> FloatArray:
        """Gains (n,) of objects ``index`` (n,) over ``distance`` (n,). ``ends``: as in
        `Spreading.cost`. Raises as `gain` does."""
        gains = self.factor[index] * np.exp(-self.decay[index] * distance)
        if self.spreading is not None:
            gains *= np.exp(-self.spreading.cost(index, distance, ends))
        for number in self._special_among(index):
            chosen = np.flatnonzero(index == number)
            gains[chosen] = self.gain(number, distance[chosen])
        return gains

    def costs(
        self,
        index: IntArray,
        distance: FloatArray,
        ends: tuple[FloatArray, FloatArray] | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """``-log`` of `gains` in two terms (n,), the constant one and that of the distance."""
        constant = self.loss[index]
        varying = self.decay[index] * distance
        if self.spreading is not None:
            varying += self.spreading.cost(index, distance, ends)
        for number in self._special_among(index):
            chosen = np.flatnonzero(index == number)
            with np.errstate(divide="ignore"):
                constant[chosen] = 0.0
                varying[chosen] = -np.log(self.gain(number, distance[chosen]))
        return constant, varying

    def _special_among(self, index: IntArray) -> set[int]:
        return set(index.tolist()) & self.special if self.special else set()


def _spectrum_arrays(
    functions: Sequence[ModulationFunction], band_decays: Sequence[tuple[float, ...]]
) -> tuple[FloatArray | None, FloatArray | None, FloatArray | None]:
    """Band gains (n, bands), band decays (n, bands) and slowness (n,) of functions; each None if
    none of them uses it."""
    gains = decays = slowness = None
    spectra = [f.spectrum for f in functions]
    band_gains = [f.band_gains() for f in functions]
    if any(band_gains):
        gains = np.array([values or (1.0,) * BAND_COUNT for values in band_gains], dtype=np.float64)
    if any(band_decays):
        decays = np.array(
            [values or (0.0,) * BAND_COUNT for values in band_decays], dtype=np.float64
        )
    if any(s.wave_speed for s in spectra):
        slowness = np.array(
            [1.0 / s.wave_speed if s.wave_speed else 0.0 for s in spectra], dtype=np.float64
        )
    return gains, decays, slowness


@frozen
class SourceNodes:
    """A source in the graph: one node, or one on each side of the contact for an impact. ``band``:
    its lowest strong band, see `core.scene.spectra.leading_band`; 0 if the graph has no bands."""

    name: str
    nodes: tuple[int, ...]
    amplitude: float
    kind: SourceKind
    band: int = 0


@frozen(eq=False)
class Transmitted:
    """What contacts pass on by their functions and weights, alike in both directions: ``losses``
    (c,), ``band_gains`` (c, bands) and ``delay`` (c,) as in `HapticGraph`."""

    losses: FloatArray
    band_gains: FloatArray | None
    delay: FloatArray | None


@frozen(eq=False)
class Conducted:
    """The contacts of a graph, from which that of a later frame takes over what has not changed.

    Attributes:
        given: as they were given.
        ordered: each pair's smaller object first, sorted.
        place: (c,) where each of those given stands among these; None where several join the same
            objects, whose order depends on where they lie.
        on: (k,) objects of the nodes of sources and listeners.
        rank: (n,) as in `_inter_connections`.
        own: what they pass on without the impedances of their bodies.
    """

    given: ContactSet
    ordered: ContactSet
    place: IntArray | None
    on: IntArray
    rank: IntArray
    own: Transmitted

    def is_like(self, contacts: ContactSet, on: IntArray) -> bool:
        """Whether ``contacts`` join the same objects by the same functions, most of them where they
        were: to make all anew is faster than to replace many."""
        if (
            self.place is None
            or contacts.transmissions != self.given.transmissions
            or not np.array_equal(on, self.on)
            or not np.array_equal(contacts.pairs, self.given.pairs)
        ):
            return False
        moved = contacts.positions[:, 0] != self.given.positions[:, 0]
        return bool(2 * np.count_nonzero(moved) <= len(contacts))


@frozen(eq=False)
class HapticGraph:
    """``G = (V, {P, T})`` with the intra-connections P implied.

    Attributes:
        table: propagation functions of the objects.
        start: (o + 1,) nodes are sorted by object; those of object k are ``start[k] : start[k +
            1]``.
        node_object: (n,) object of each node.
        node_position: (n, 3) [m, world].
        partner: (n,) the node at the other end of its inter-connection, or -1.
        contact: (n,) number of its contact, or -1.
        side: (n,) which of the two objects of its contact a node lies on: 0 the one of the lower
            number, 1 the other.
        transmission_loss: (c, 2) cost ``-log(gain)``, at least 0, of each inter-connection,
            including the contact's weight: from the object of the lower number into the other, and
            back.
        contact_band_gains: (c, 2, bands) in the same two directions, or None.
        contact_delay: (c,) [s], or None.
        sources, listeners: by name, with their nodes.
        listener_nodes: (l,) node of each listener.
        frames: centres, axes and sizes of the objects.
        forces: (c,) normal forces of the contacts [N], NaN if unknown, 0 for contacts whose
            function does not use it; None if no function does.
        reach: (n,) radius [m] about a listener's node within which distances to it are 0, 0 for
            other nodes; None if all are 0.
        fronts: (2, n) `Spreading.fronts` of the nodes' patches; None if all are points.
        conducted: its contacts.
    """

    table: ObjectTable
    start: IntArray
    node_object: IntArray
    node_position: FloatArray
    partner: IntArray
    contact: IntArray
    side: IntArray
    transmission_loss: FloatArray
    contact_band_gains: FloatArray | None
    contact_delay: FloatArray | None
    sources: tuple[SourceNodes, ...]
    listeners: tuple[str, ...]
    listener_nodes: IntArray
    frames: ObjectFrames
    conducted: Conducted
    forces: FloatArray | None = None
    reach: FloatArray | None = None
    fronts: FloatArray | None = None

    @property
    def node_count(self) -> int:
        return len(self.node_object)

    @property
    def contact_count(self) -> int:
        return len(self.transmission_loss)

    @property
    def uses_bands(self) -> bool:
        """True if any function has band gains or band decays."""
        return (
            self.table.band_gains is not None
            or self.table.band_decays is not None
            or self.contact_band_gains is not None
        )

    @property
    def uses_delays(self) -> bool:
        """True if any function has a wave speed."""
        return self.table.slowness is not None or self.contact_delay is not None

    def in_band(self, band: int) -> HapticGraph:
        """The graph whose plain gains are those of a frequency band, see `ObjectTable.in_band`."""
        loss = self.transmission_loss
        table = self.table.in_band(band)
        if self.contact_band_gains is None and table is self.table:
            return self
        if self.contact_band_gains is not None:
            with np.errstate(divide="ignore"):
                loss = loss - np.log(self.contact_band_gains[..., band])
        return replace(self, table=table, transmission_loss=loss)

    def crossing_costs(self, backwards: bool = False) -> FloatArray:
        """Cost (n,) of leaving through each node over its contact, or, ``backwards``, of coming
        over it to the node; infinite where there is none."""
        loss = np.append(self.transmission_loss.reshape(-1), [math.inf] * 2)
        return np.asarray(loss[2 * self.contact + (1 - self.side if backwards else self.side)])

    def crossing_lanes(self) -> FloatArray:
        """Gain (n, lanes) of leaving through each node over its contact: the plain gain, then,
        where bands are used, that in each band; 0 where there is none."""
        gains = np.exp(-self.crossing_costs())[:, None]
        if not self.uses_bands:
            return gains
        bands = np.ones((1, BAND_COUNT))
        if self.contact_band_gains is not None:
            bands = self.contact_band_gains[self.contact, self.side]
        return np.concatenate([gains, gains * bands], axis=1)

    def intra_connection_count(self) -> int:
        """Number of implied intra-connections: n (n - 1) / 2 of each object's n nodes."""
        sizes = self.start[1:] - self.start[:-1]
        return int((sizes * (sizes - 1) // 2).sum())

    def nodes_of(self, index: int) -> slice:
        """The nodes of object ``index``."""
        return slice(int(self.start[index]), int(self.start[index + 1]))

    def node_distances(self, a: IntArray, b: IntArray) -> FloatArray:
        """Distances in metres between nodes ``a[i]`` and ``b[i]``, from the nearest point of a
        listener's volume."""
        places = self.node_position.T
        apart = lengths(*(places.take(a, axis=1) - places.take(b, axis=1)))
        return (
            apart
            if self.reach is None
            else np.maximum(apart - (self.reach[a] + self.reach[b]), 0.0)
        )

    def ends(self, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray] | None:
        """The fronts of nodes ``a[i]`` and ``b[i]``, as `Spreading.cost` takes them."""
        return (
            None
            if self.fronts is None
            else (self.fronts.take(a, axis=1), self.fronts.take(b, axis=1))
        )


def distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Euclidean distances over the last axis, of length 3. Accurate also for 1e200 m and 1e-200 m,
    whose squares overflow or underflow. The distance of two points depends neither on the other
    elements nor on their order."""
    return lengths(a[..., 0] - b[..., 0], a[..., 1] - b[..., 1], a[..., 2] - b[..., 2])


def lengths(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Euclidean lengths of vectors with these components, as accurate as `distances`."""
    with np.errstate(over="ignore", under="ignore"):
        squared = np.asarray(x * x)
        squared += y * y
        squared += z * z
        result = np.asarray(np.sqrt(squared))
        if squared.size and (squared.min() < 1e-280 or squared.max() > 1e300):
            extreme = (squared > 1e300) | (squared < 1e-280)
            result[extreme] = np.hypot(np.hypot(x[extreme], y[extreme]), z[extreme])
    return result


@frozen(eq=False)
class _Order:
    """The order of contacts and nodes.

    Attributes:
        contacts: each pair's smaller object first, sorted.
        place: as in `Conducted`.
        rank: (n,) as in `_inter_connections`.
        start, node_object, partner, contact, side: as in `HapticGraph`.
        node_position: (3, n) of the nodes of contacts that have not changed.
        changed: rows of ``contacts`` that have.
        found: these alone; None where all have.
    """

    contacts: ContactSet
    place: IntArray | None
    rank: IntArray
    start: IntArray
    node_object: IntArray
    partner: IntArray
    contact: IntArray
    side: IntArray
    node_position: FloatArray
    changed: IntArray | slice = field(default_factory=lambda: slice(None))
    found: ContactSet | None = None

    @classmethod
    def fresh(cls, table: ObjectTable, contacts: ContactSet, on: IntArray) -> _Order:
        """Of nodes of contacts, and of sources and listeners ``on`` objects (k,)."""
        _check(table, contacts)
        ordered, place = _canonical(contacts, len(table.names))
        of_nodes = np.concatenate([ordered.pairs.T.reshape(-1), on])
        order = of_nodes.argsort(kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        sizes = np.bincount(of_nodes, minlength=len(table.names))
        start = np.concatenate([[0], sizes.cumsum()])
        links = _inter_connections(rank, len(contacts))
        return cls(ordered, place, rank, start, of_nodes[order], *links, np.empty((3, len(rank))))

    @classmethod
    def after(cls, known: HapticGraph, contacts: ContactSet) -> _Order:
        """That of a ``known`` graph, which contacts are like."""
        last = known.conducted
        rows = np.flatnonzero(differing(last.given, contacts, ARRAYS[1:]))
        changed = rows if last.place is None else last.place[rows]
        found = _low_first(rows_of(contacts, rows))
        _check(known.table, found)
        return cls(
            with_rows(last.ordered, ARRAYS, changed, found),
            last.place,
            last.rank,
            known.start,
            known.node_object,
            known.partner,
            known.contact,
            known.side,
            known.node_position.T.copy(),
            changed,
            found,
        )


def build_graph(
    table: ObjectTable,
    contacts: ContactSet,
    sources: Sequence[Source],
    listeners: Sequence[Listener],
    frames: ObjectFrames | None = None,
    gravity: Vector = (0.0, 0.0, -9.81),
    before: HapticGraph | None = None,
) -> HapticGraph:
    """The haptic graph of one frame.

    Nodes are put into a canonical order (object, kind, contact by objects and position), so that
    the result does not depend on the order in which contacts were found.

    Args:
        table: the objects.
        contacts: between them, which number objects as the table does.
        sources: each on an object of the table.
        listeners: each on an object of the table.
        frames: of the objects of the table; None where they are unknown.
        gravity: [m/s^2], from which the forces of resting contacts follow if a function uses them.
        before: of the frame before; where the same objects touch, only what has changed is made.

    Raises:
        ValueError: names the argument for an object that is not in the table, a contact of an
            object with itself or a number that is not finite.
        NoGain: a transmission expression gives no valid gain.
    """
    count = len(contacts)
    source_entries = [
        (number, name, position)
        for number, source in enumerate(sources)
        for name, position in (
            (source.object, source.position),
            (source.second_object, source.second_position),
        )
        if name is not None
    ]
    ends = [(name, position) for _, name, position in source_entries] + [
        (item.object, item.position) for item in listeners
    ]
    index = table.index()
    try:
        on = np.array([index[name] for name, _ in ends], dtype=np.int64)
    except KeyError:
        raise _not_there(index, sources, listeners) from None
    frames = frames or ObjectFrames.unknown(len(table.names))
    known = before if before is not None and before.table is table else None
    known = known if known is not None and known.conducted.is_like(contacts, on) else None
    order = _Order.fresh(table, contacts, on) if known is None else _Order.after(known, contacts)
    ordered, rank, node_position = order.contacts, order.rank, order.node_position
    for number, nodes in enumerate((rank[:count], rank[count : 2 * count])):
        node_position[:, nodes[order.changed]] = ordered.positions[order.changed, number].T
    node_position[:, rank[2 * count :]] = (
        np.array([position for _, position in ends], dtype=np.float64).reshape(-1, 3).T
    )
    forces = _forces(table, ordered, frames, gravity)
    if order.found is None or known is None or forces is not None:
        own = _transmissions(table, ordered, forces)
    else:
        own = with_rows(
            known.conducted.own,
            ("losses", "band_gains", "delay"),
            order.changed,
            _transmissions(table, order.found, None),
        )
    loss, band_gains = _between_bodies(table, ordered, frames, own)
    listener_nodes = rank[2 * count + len(source_entries) :]
    in_bands = (
        table.band_gains is not None or table.band_decays is not None or band_gains is not None
    )
    return HapticGraph(
        table=table,
        start=order.start,
        node_object=order.node_object,
        node_position=node_position.T,  # each coordinate contiguous
        partner=order.partner,
        contact=order.contact,
        side=order.side,
        transmission_loss=loss,
        contact_band_gains=band_gains,
        contact_delay=own.delay,
        sources=_source_nodes(
            sources,
            [number for number, _, _ in source_entries],
            rank[2 * count :].tolist(),
            in_bands,
        ),
        listeners=tuple(listener.name for listener in listeners),
        listener_nodes=listener_nodes,
        frames=frames,
        conducted=Conducted(contacts, ordered, order.place, on, rank, own),
        forces=forces,
        reach=_reach(listeners, listener_nodes, len(rank)),
        fronts=_fronts(table, ordered, frames, rank, known, order.changed),
    )


def large_patches(
    table: ObjectTable, contacts: ContactSet, sizes: FloatArray | None = None
) -> IntArray:
    """Numbers (k,) of the contacts whose patches may be more than points between objects whose
    boxes have ``sizes`` (n, 3) [m], whatever these are by default."""
    if table.spreading is None or not table.spreading.has_fronts:
        return np.zeros(0, dtype=np.int64)
    pairs = contacts.pairs.T
    point = np.minimum(*table.spreading.point[pairs])
    thin: FloatArray | float = 0.0
    if sizes is not None:
        x, y, z = sizes.T  # much faster than the least along rows of three
        thin = np.fmin(*np.minimum(np.minimum(x, y), z)[pairs])
    with np.errstate(invalid="ignore"):  # no patch is larger than an infinite point
        return np.flatnonzero(contacts.area > point * np.fmin(point, thin))


def _fronts(
    table: ObjectTable,
    contacts: ContactSet,
    frames: ObjectFrames,
    rank: IntArray,
    known: HapticGraph | None,
    changed: IntArray | slice,
) -> FloatArray | None:
    """`HapticGraph.fronts`. ``rank`` (n,): as in `_inter_connections`; ``known``: a graph of which
    only the contacts that have ``changed``, and objects, differ; None without one."""
    if table.spreading is None or not table.spreading.has_fronts:
        return None
    fronts, rows = np.zeros((2, len(rank))), np.arange(len(contacts))
    if known is not None and known.fronts is not None:
        fronts = known.fronts.copy()
        moved = differing(known.frames, frames, ("axes", "size"))
        unlike = moved[contacts.pairs[:, 0]] | moved[contacts.pairs[:, 1]]
        unlike[changed] = True
        rows = np.flatnonzero(unlike)
    found = rows_of(contacts, rows)
    large = large_patches(table, found, frames.size)
    pairs = found.pairs[large]
    size = frames.patch_sizes(pairs, found.area[large], found.normal[large])
    for index, nodes in zip(pairs.T, (rank[rows], rank[len(contacts) + rows]), strict=True):
        fronts[:, nodes] = 0.0
        fronts[:, nodes[large]] = table.spreading.fronts(index, size)
    return fronts if fronts.any() else None


def _reach(listeners: Sequence[Listener], nodes: IntArray, count: int) -> FloatArray | None:
    """`HapticGraph.reach` of ``count`` nodes; ``nodes``: those of the listeners."""
    radii = np.array([listener.radius for listener in listeners])
    if not radii.any():
        return None
    reach = np.zeros(count)
    reach[nodes] = radii
    return reach


def _source_nodes(
    sources: Sequence[Source], numbers: Sequence[int], nodes: Sequence[int], in_bands: bool
) -> tuple[SourceNodes, ...]:
    """The sources with their ``nodes``, the first of which belong to the sources ``numbers``, and
    with their bands."""
    of_source: list[list[int]] = [[] for _ in sources]
    for number, node in zip(numbers, nodes, strict=False):
        of_source[number].append(node)
    bands = [leading_band(source) if in_bands else 0 for source in sources]
    return tuple(
        SourceNodes(s.name, tuple(n), s.amplitude, s.kind, b)
        for s, n, b in zip(sources, of_source, bands, strict=True)
    )


def _inter_connections(rank: IntArray, count: int) -> tuple[IntArray, IntArray, IntArray]:
    """Partner and contact (n,) of each node, -1 if it has none, and the side of the contact that it
    lies on. ``rank`` (n,): the nodes' numbers, first those of the ``count`` contacts' first nodes,
    then of their second nodes, then the rest."""
    partner, contact = np.full((2, len(rank)), -1, dtype=np.int64)
    side = np.zeros(len(rank), dtype=np.int64)
    first = rank[:count]
    second = rank[count : 2 * count]
    partner[first], partner[second] = second, first
    contact[first] = contact[second] = np.arange(count)
    side[second] = 1
    return partner, contact, side


def graph_of_scene(scene: HapticScene) -> HapticGraph:
    """The haptic graph of a scene with authored contacts."""
    table = ObjectTable.of(scene.objects, scene.settings.epsilon)
    contacts = ContactSet.from_contacts(scene.contacts, table.index())
    return build_graph(
        table,
        contacts,
        scene.sources,
        scene.listeners,
        ObjectFrames.of_objects(table.objects),
        scene.rules.gravity,
    )


def _not_there(
    index: Mapping[str, int], sources: Sequence[Source], listeners: Sequence[Listener]
) -> ValueError:
    """The error that names the source or listener on an object without a number in ``index``."""
    on = [("listeners", item.name, item.object) for item in listeners] + [
        ("sources", item.name, name)
        for item in sources
        for name in (item.object, item.second_object)
        if name is not None
    ]
    key, item, name = next(entry for entry in on if entry[2] not in index)
    return ValueError(f"{key}: {item!r} is on {name!r}, but there is no such object")


def _check(table: ObjectTable, contacts: ContactSet) -> None:
    """Raise ValueError that says what is wrong with the contacts between objects of the table."""
    pairs = contacts.pairs
    if len(pairs) == 0:
        return
    if pairs.min() < 0 or pairs.max() >= len(table.names):
        raise ValueError(
            f"contacts: pairs must be numbers of objects from 0 to {len(table.names) - 1}"
        )
    selves = pairs[:, 0] == pairs[:, 1]
    if selves.any():
        raise ValueError(f"contacts: {table.names[pairs[selves][0, 0]]!r} can't touch itself")
    for key in ("positions", "area", "depth", "normal"):
        if not np.isfinite(getattr(contacts, key)).all():
            raise ValueError(f"contacts: {key} must be finite")
    if not ((contacts.weight >= 0) & (contacts.weight <= 1)).all():
        raise ValueError("contacts: weight must lie in [0, 1]")


def _low_first(contacts: ContactSet) -> ContactSet:
    """Each pair's smaller object first."""
    first, second = contacts.pairs.T
    swapped = first > second
    if not swapped.any():
        return contacts
    return replace(
        contacts,
        pairs=np.where(swapped[:, None], contacts.pairs[:, ::-1], contacts.pairs),
        positions=np.where(swapped[:, None, None], contacts.positions[:, ::-1], contacts.positions),
        normal=np.where(swapped[:, None], -contacts.normal, contacts.normal),
    )


def _canonical(contacts: ContactSet, count: int) -> tuple[ContactSet, IntArray | None]:
    """Each pair's smaller object first, contacts sorted by objects, of which there are ``count``,
    then by position and all other fields; and `Conducted.place`."""
    contacts = _low_first(contacts)
    key = contacts.pairs[:, 0] * count + contacts.pairs[:, 1]
    every = np.arange(len(key))
    if (key[1:] > key[:-1]).all():
        return contacts, every
    order = key.argsort(kind="stable")
    if (key[order[1:]] == key[order[:-1]]).any():
        by_name = sorted(
            range(len(contacts.transmissions)), key=lambda k: repr(contacts.transmissions[k])
        )
        function = np.argsort(by_name)[contacts.transmission]
        flat = contacts.positions.reshape(len(key), 6)
        values = contacts.depth, contacts.weight, contacts.area
        order = np.lexsort((function, *contacts.normal.T, *values, *flat.T[::-1], key))
        return rows_of(contacts, order), None
    place = np.empty_like(order)
    place[order] = every
    return rows_of(contacts, order), place


def _forces(
    table: ObjectTable, contacts: ContactSet, frames: ObjectFrames, gravity: Vector
) -> FloatArray | None:
    """Forces of the contacts, None if no function uses them. A medium carries no weight."""
    uses_force = [function.uses_force for function in contacts.transmissions]
    if not any(uses_force):
        return None
    asks = np.array(uses_force)[contacts.transmission]
    if not asks.any():
        return None
    masses = [
        (math.nan if o.mass is None else o.mass) if o.motion is Motion.DYNAMIC else 0.0
        for o in table.objects
    ]
    solid = np.logical_not(np.array([o.medium for o in table.objects])[contacts.pairs].any(axis=1))
    forces = np.full(len(contacts), math.nan)
    forces[solid] = contact_forces(
        rows_of(contacts, solid), np.array(masses), frames.centre, gravity
    )
    return np.where(asks, forces, 0.0)


def _transmissions(
    table: ObjectTable, contacts: ContactSet, forces: FloatArray | None
) -> Transmitted:
    """What contacts pass on by their functions and weights. A function of kappa and rho uses the
    mean of the two objects; ``angle`` is the contact normal's angle to the vertical."""
    losses = np.zeros(len(contacts), dtype=np.float64)
    band_gains = delay = None
    if not all(
        function.name == "identity" and function.spectrum.is_plain
        for function in contacts.transmissions
    ):
        distance = distances(contacts.positions[:, 0], contacts.positions[:, 1])
        for number, function in enumerate(contacts.transmissions):
            if function.name in ("identity", "impedance"):
                continue
            chosen = np.flatnonzero(contacts.transmission == number)
            gains = _transmission_gains(table, contacts, function, chosen, distance[chosen], forces)
            with np.errstate(divide="ignore"):
                losses[chosen] = -np.log(np.minimum(gains, 1.0))
            if function.name in (
                "constant",
                "exponential",
                "resilient",
            ):  # their logarithm is more accurate than that of a rounded gain
                _, decay = function.log_linear(0.0, 0.0, table.epsilon) or (0.0, 0.0)
                losses[chosen] = function.loss(0.0, 0.0, table.epsilon) + decay * distance[chosen]
        bands, decays, slowness = _spectrum_arrays(
            contacts.transmissions, [f.spectrum.band_decays for f in contacts.transmissions]
        )
        kind = contacts.transmission
        band_gains = None if bands is None else bands[kind]
        if decays is not None:
            band_gains = np.exp(-decays[kind] * distance[:, None]) * (
                1.0 if band_gains is None else band_gains
            )
        delay = None if slowness is None else slowness[kind] * distance
    if (contacts.weight < 1).any():
        with np.errstate(divide="ignore"):
            losses = losses - np.log(contacts.weight)
    return Transmitted(losses, band_gains, delay)


def _between_bodies(
    table: ObjectTable, contacts: ContactSet, frames: ObjectFrames, own: Transmitted
) -> tuple[FloatArray, FloatArray | None]:
    """Loss (c, 2) and band gains (c, 2, bands) of contacts: their ``own``, and what they pass on by
    the impedances of their bodies."""
    both = own.losses[:, None].repeat(2, axis=1)
    bands = None if own.band_gains is None else own.band_gains[:, None].repeat(2, axis=1)
    unlike, passed = passed_by_bodies(table.bodies, contacts, frames)
    if len(unlike):
        most = np.maximum(passed.max(axis=2), np.finfo(np.float64).tiny)
        both[unlike] -= np.log(most)
        bands = np.ones((len(contacts), 2, BAND_COUNT)) if bands is None else bands
        bands[unlike] *= passed / most[:, :, None]
    return both, bands


def _transmission_gains(
    table: ObjectTable,
    contacts: ContactSet,
    function: ModulationFunction,
    chosen: IntArray,
    distance: FloatArray,
    forces: FloatArray | None,
) -> FloatArray:
    """Gains (k,) of some contacts without their weights. Raises NoGain, which names the contact.

    Args:
        table: the objects.
        contacts: all of them.
        function: that of the chosen ones.
        chosen: numbers of those contacts (k,).
        distance: between their two nodes (k,) [m].
        forces: of all contacts [N], None where no function uses them.
    """
    pairs = contacts.pairs[chosen]
    kappas, rhos = table.properties[:, pairs]
    parameters = {
        "area": contacts.area[chosen],
        "depth": contacts.depth[chosen],
        "angle": np.arccos(np.minimum(1.0, np.abs(contacts.normal[chosen, 2]))),
        "force": np.full(len(chosen), math.nan) if forces is None else forces[chosen],
    }
    kappa = kappas.mean(axis=1)
    rho = rhos.mean(axis=1)
    try:
        return function.gain(distance, kappa, rho, table.epsilon, parameters)
    except ValueError:
        for i, (a, b) in enumerate(pairs.tolist()):  # which one it was
            here = {key: values[i : i + 1] for key, values in parameters.items()}
            try:
                function.gain(
                    distance[i : i + 1], kappa[i : i + 1], rho[i : i + 1], table.epsilon, here
                )
            except ValueError as error:
                names = table.names[a], table.names[b]
                raise NoGain(f"contact of {names[0]!r} and {names[1]!r}: {error}", names) from None
        raise
