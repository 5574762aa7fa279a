"""The haptic tracer: the paper's algorithm, once per frame.

    detect collisions -> update graph -> for each source: propagate -> for each listener: mix, render

One tracer serves the live preview, the bake, the export, the command line and the tests, so that none of them differs from the others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from time import perf_counter

import numpy as np

from .arrays import FloatArray, IntArray
from .contacts.authored import AuthoredContacts
from .contacts.contact_set import ContactSet
from .contacts.gain_bound import Reach
from .contacts.tracker import STILL, Body, ContactSettings, ContactTracker, FrameContacts, Impact
from .graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from .message import Message
from .propagation import Propagation, propagate
from .propagation.gain_bounds import object_bounds, signal_reach
from .render.frame_result import FrameResult
from .render.mixdown import Mixdown
from .render.renderer import SAMPLE_RATE, sample_index
from .scene.functions import ModulationFunction
from .scene.values import HapticObject, Listener, Settings, Source, SourceKind, Vector
from .signals import DEFAULT_IMPACT, Signal, impact_template


@dataclass(frozen=True, slots=True)
class Frame:
    """What the tracer is told of one frame.

    ``time`` [s]; the step renders the samples from the previous frame's time up to this one's, so that an impact between the two sounds
    when it happened. ``continuous``: this is the step after the previous call's frame; otherwise contact history, velocities and sounding
    signals are dropped. Either bodies move, then ``transforms`` (n, 4, 4) are the rigid world transforms of ``bodies``, which are
    ``objects`` in the same order; or ``contacts`` are given, which number the objects by their sorted names. ``authored`` contacts come
    before those that are found between bodies.
    """

    number: int
    time: float
    objects: tuple[HapticObject, ...]
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings = field(default_factory=Settings)
    bodies: tuple[Body, ...] = ()
    transforms: FloatArray | None = None
    contacts: ContactSet | None = None
    continuous: bool = True
    authored: AuthoredContacts | None = None


@dataclass(frozen=True, slots=True)
class _Ringing:
    """An impact whose template still plays. It stays with both objects: ``local`` is its place in the frame of either."""

    source: Source
    local: tuple[FloatArray, FloatArray]
    end: float


@dataclass(frozen=True, slots=True)
class _Found:
    """Collisions of one frame."""

    contacts: ContactSet
    impacts: tuple[Impact, ...] = ()
    statistics: dict[str, int | float] = field(default_factory=dict)
    milliseconds: dict[str, float] = field(default_factory=dict)
    warnings: tuple[Message, ...] = ()


@dataclass(frozen=True, slots=True)
class _Propagated:
    """What the propagation of one frame was computed from, and what it gave."""

    table: ObjectTable
    contacts: ContactSet
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings
    graph: HapticGraph
    propagation: Propagation

    def holds(
        self, table: ObjectTable, contacts: ContactSet, sources: Sequence[Source], listeners: Sequence[Listener], settings: Settings
    ) -> bool:
        """Whether all of it is the same again, but for places that tremble."""
        if self.table is not table or self.contacts is not contacts or self.settings != settings:
            return False
        return _alike(self.sources, sources) and _alike(self.listeners, listeners)


class Tracer:
    """Steps through the frames of a scene.

    Impacts make temporary sources that play ``impact_signal``, unless ``impact_sources`` is False; where ``impact_materials`` says what
    both objects are made of (object to a material of `IMPACT_MATERIALS`), they play what these feel like. ``lazy``: contacts are looked
    for only where signals can get to with what the threshold wants; gains and impacts are the same.
    """

    def __init__(
        self,
        contact_settings: ContactSettings | None = None,
        impact_sources: bool = True,
        impact_signal: Signal = DEFAULT_IMPACT,
        transmission: ModulationFunction | None = None,
        sample_rate: float = SAMPLE_RATE,
        lazy: bool = False,
    ) -> None:
        self.contact_settings = contact_settings or ContactSettings()
        self.lazy = lazy
        self.impact_sources = impact_sources
        self.impact_signal = impact_signal
        self.impact_materials: Mapping[str, str] = {}
        self.transmission = transmission
        self.sample_rate = sample_rate
        self._objects: tuple[HapticObject, ...] = ()
        self._table = ObjectTable.of((), 0.0)
        self._tracker: ContactTracker | None = None
        self._found: FrameContacts | None = None
        self._authored: AuthoredContacts | None = None
        self._bodies: tuple[Body, ...] = ()
        self._numbered: ObjectTable | None = None
        self._row: dict[str, int] = {}
        self._numbers = np.zeros(0, dtype=np.int64)
        self._bounds: tuple[ObjectTable, Settings, tuple[FloatArray, FloatArray]] | None = None
        self._contacts = ContactSet.empty()
        self._propagated: _Propagated | None = None
        self._mixdown = Mixdown(impact_signal, sample_rate)
        self._ringing: list[_Ringing] = []
        self._time: float | None = None

    def reset(self) -> None:
        """Forget contacts, velocities and sounding signals."""
        self._ringing.clear()
        self._time = None
        if self._tracker is not None:
            self._tracker.reset()
        self._mixdown.reset()

    def step(self, frame: Frame) -> FrameResult:
        """Trace one frame. Raises ValueError that names the object where a designer's expression gives no gain."""
        if not frame.continuous or (self._time is not None and frame.time <= self._time):
            self.reset()
        table = self._object_table(frame)
        found = self._detect_collisions(frame, table)
        watch = _Stopwatch(found.milliseconds)
        sources = frame.sources + self._temporary_sources(frame, found.impacts)
        known = self._propagated
        if known is not None and known.holds(table, found.contacts, sources, frame.listeners, frame.settings):
            graph, propagation = known.graph, known.propagation
            watch.lap("graph")
        else:
            graph = build_graph(table, found.contacts, sources, frame.listeners)
            watch.lap("graph")
            propagation = propagate(graph, frame.settings, sounding_only=True)
            self._propagated = _Propagated(table, found.contacts, sources, frame.listeners, frame.settings, graph, propagation)
        watch.lap("propagate")
        block = self._mixdown.render(self._time, frame.time, sources, frame.listeners, propagation)
        watch.lap("mix")
        first = sample_index(frame.time if self._time is None else self._time, self.sample_rate)
        self._time = frame.time
        return FrameResult(
            number=frame.number,
            time=frame.time,
            objects=table.names,
            contacts=found.contacts,
            graph=graph,
            propagation=propagation,
            sources=sources,
            listeners=frame.listeners,
            gains=propagation.gain * np.array([source.amplitude for source in sources]).reshape(-1, 1),
            impacts=found.impacts,
            block=block,
            first_sample=first,
            sample_rate=self.sample_rate,
            milliseconds=watch.milliseconds,
            statistics={
                "objects": len(table.names),
                "contacts": len(found.contacts),
                "nodes": graph.node_count,
                "intra_connections": graph.intra_connection_count(),
                **found.statistics,
                **propagation.statistics,
            },
            warnings=(*found.warnings, *propagation.warnings),
        )

    def _object_table(self, frame: Frame) -> ObjectTable:
        if frame.objects is not self._objects or frame.settings.epsilon != self._table.epsilon:
            self._objects = frame.objects
            self._table = ObjectTable.of(frame.objects, frame.settings.epsilon)
        return self._table

    def _detect_collisions(self, frame: Frame, table: ObjectTable) -> _Found:
        if frame.contacts is not None:
            return _Found(frame.contacts)
        if not frame.bodies or frame.transforms is None:
            return _Found(ContactSet.empty())
        watch = _Stopwatch({})
        numbers = self._follow(frame, table)
        assert self._tracker is not None
        wanted = self._reach(frame, table) if self.lazy and frame.authored is None else None
        found = self._tracker.update(frame.time, frame.transforms, wanted, continuous=frame.continuous)
        if self._found is None or found.contacts is not self._found.contacts or frame.authored is not self._authored:
            self._contacts = replace(found.contacts, pairs=numbers[found.contacts.pairs])
            if self.transmission is not None:
                self._contacts = replace(self._contacts, transmissions=(self.transmission,))
            if frame.authored is not None:
                self._contacts = frame.authored.over(self._contacts)
        self._found, self._authored = found, frame.authored
        statistics = found.statistics
        watch.lap("narrow")
        milliseconds = {"broad": 1000 * statistics.broad_seconds, "narrow": watch.milliseconds["narrow"] - 1000 * statistics.broad_seconds}
        counts: dict[str, int | float] = {
            "candidate_pairs": statistics.candidates,
            "contact_queries": statistics.queries,
            "queries_avoided": statistics.avoided,
        }
        return _Found(self._contacts, found.impacts if self.impact_sources else (), counts, milliseconds, found.warnings)

    def _follow(self, frame: Frame, table: ObjectTable) -> IntArray:
        """Let the tracker follow the bodies of ``frame``; their numbers (n,) in ``table``."""
        tracker = self._tracker
        if tracker is None or tracker.settings != self.contact_settings:
            self._tracker = None
        elif self._bodies is not frame.bodies and tracker.bodies != frame.bodies:
            if [b.name for b in tracker.bodies] == [b.name for b in frame.bodies]:
                tracker.replace_bodies(frame.bodies)
            else:
                self._tracker = None
        if self._tracker is None:
            self._tracker = ContactTracker(frame.bodies, self.contact_settings)
            self._ringing.clear()
        if self._bodies is not frame.bodies or self._numbered is not table:
            self._bodies, self._numbered, self._found = frame.bodies, table, None
            self._row = {body.name: number for number, body in enumerate(frame.bodies)}
            index = table.index()
            self._numbers = np.array([index[body.name] for body in frame.bodies], dtype=np.int64)
        return self._numbers

    def _reach(self, frame: Frame, table: ObjectTable) -> Reach:
        """Where signals of the sources can get to."""
        if self._bounds is None or self._bounds[0] is not table or self._bounds[1] != frame.settings:
            factor, decay = object_bounds(table, frame.settings)
            self._bounds = table, frame.settings, (factor[self._numbers], decay[self._numbers])
        starts: list[tuple[int, Vector]] = []
        for source in frame.sources:
            for name, position in ((source.object, source.position), (source.second_object, source.second_position)):
                if source.amplitude > 0 and name in self._row and position is not None:
                    starts.append((self._row[name], position))
        bodies, positions = self._ringing_places(frame.transforms)
        bodies = np.concatenate([np.array([body for body, _ in starts], dtype=np.int64), bodies])
        positions = np.concatenate([np.array([position for _, position in starts], dtype=np.float64).reshape(-1, 3), positions])
        return signal_reach(self._bounds[2], bodies, positions, frame.settings, self.transmission, self.impact_sources)

    def _temporary_sources(self, frame: Frame, impacts: Sequence[Impact]) -> tuple[Source, ...]:
        """The sources of impacts whose template plays, the new ones among them, each where its objects have carried it."""
        for impact in impacts:
            self._ringing.append(self._struck(frame, impact))
        return self._sounding(frame)

    def _sounding(self, frame: Frame) -> tuple[Source, ...]:
        """The sources of impacts so far whose template plays."""
        _, positions = self._ringing_places(frame.transforms)
        places = positions.reshape(-1, 2, 3).tolist()
        return tuple(ringing.source.moved(first, second) for ringing, (first, second) in zip(self._ringing, places, strict=True))

    def _ringing_places(self, transforms: FloatArray | None) -> tuple[IntArray, FloatArray]:
        """The bodies (2k,) of the k impacts whose template plays, the others forgotten, and where their sources are on them (2k, 3)."""
        self._ringing = [r for r in self._ringing if transforms is not None and (self._time is None or r.end > self._time)]
        if transforms is None or not self._ringing:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        names = [name for ringing in self._ringing for name in (ringing.source.object, ringing.source.second_object)]
        bodies = np.array([self._row[name] for name in names if name is not None], dtype=np.int64)
        local = np.array([ringing.local for ringing in self._ringing]).reshape(-1, 3)
        placed = transforms[bodies]
        return bodies, (placed[:, :3, :3] * local[:, None]).sum(axis=2) + placed[:, :3, 3]

    def _struck(self, frame: Frame, impact: Impact) -> _Ringing:
        assert frame.transforms is not None
        first, second = impact.objects
        names = frame.bodies[first].name, frame.bodies[second].name
        materials = [self.impact_materials[name] for name in names if name in self.impact_materials]
        signal = impact_template(materials[0], materials[1]) if len(materials) == 2 else self.impact_signal
        source = Source(
            name=f"impact of {names[0]} and {names[1]} at {impact.time:.4f} s",
            object=names[0],
            position=impact.positions[0],
            second_object=names[1],
            second_position=impact.positions[1],
            amplitude=impact.amplitude,
            kind=SourceKind.TEMPORARY,
            signal=signal,
            onset=impact.time,
        )
        local = (_local(frame.transforms[first], impact.positions[0]), _local(frame.transforms[second], impact.positions[1]))
        return _Ringing(source, local, impact.time + signal.duration)


class _Stopwatch:
    """Milliseconds between laps, added to those that are known."""

    def __init__(self, milliseconds: dict[str, float]) -> None:
        self.milliseconds = milliseconds
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        now = perf_counter()
        self.milliseconds[stage] = 1000 * (now - self._last)
        self._last = now


def _alike(before: Sequence[Source | Listener], now: Sequence[Source | Listener]) -> bool:
    """Whether all are the same and have not moved."""
    return len(before) == len(now) and all(a is b or _same_place(a, b) for a, b in zip(before, now, strict=True))


def _same_place(a: Source | Listener, b: Source | Listener) -> bool:
    if type(a) is not type(b):
        return False
    for key in _FIELDS[type(a)]:
        one, other = getattr(a, key), getattr(b, key)
        if one is other:
            continue
        if not key.endswith("position") or one is None or other is None:
            if one != other:
                return False
        elif any(abs(x - y) > STILL for x, y in zip(one, other, strict=True)):
            return False
    return True


_FIELDS = {cls: tuple(f.name for f in fields(cls)) for cls in (Source, Listener)}


def _local(transform: FloatArray, position: Sequence[float]) -> FloatArray:
    """A world position in the frame of a rigid transform."""
    return np.asarray(transform[:3, :3].T @ (np.asarray(position) - transform[:3, 3]))
