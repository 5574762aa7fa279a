"""Why a listener feels nothing, in words that say what to do about it."""

from __future__ import annotations

import enum
import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.narrow.narrow_phase import NarrowPhase, relative_pose
from ..contacts.shapes import transformed_bounds
from ..contacts.tracker import Body, ContactSettings, ContactTracker
from ..graph.haptic_graph import HapticGraph, build_graph
from ..perception import dominant_frequency, sensation_level
from ..propagation import objects_on
from ..propagation.best_path import best_paths
from ..propagation.connections import amplifying, intra_costs
from ..propagation.modes import DISTANCE_ONLY, distance_only, nearest_listener, straight_distances
from ..propagation.strategies import BUDGET
from ..render.frame_result import FrameResult
from ..scene.values import Mode, Settings, Source, SourceKind
from ..signals import DEFAULT_IMPACT, DEFAULT_PERSISTENT

_MOST_SOURCES = 8
_WALL = 40.0
"""Cost of an object that passes on nothing, where ways through such objects are looked for."""


class Cause(enum.StrEnum):
    """Kinds of reasons."""

    NO_SOURCE = "no_source"
    MUTED = "muted"
    FINISHED = "finished"
    MODE = "mode"
    NO_CONTACT = "no_contact"
    BLOCKED = "blocked"
    BELOW_THRESHOLD = "below_threshold"
    TOO_LONG = "too_long"
    LISTENER_GAIN = "listener_gain"
    NOT_RENDERED = "not_rendered"
    PAUSE = "pause"
    NOT_FELT = "not_felt"


@dataclass(frozen=True, slots=True)
class Reason:
    """Why: a sentence without a full stop, the object that it is about ("" for none), and by how many decibels, where that can be said."""

    cause: Cause
    words: str
    object: str = ""
    decibels: float | None = None


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The bodies of the frame under their ``transforms`` (n, 4, 4), and what counts as a contact: to say how far apart things are."""

    bodies: tuple[Body, ...]
    transforms: FloatArray
    contact_settings: ContactSettings


def reasons(
    result: FrameResult,
    settings: Settings,
    listener: int,
    surroundings: Surroundings | None = None,
    muted: Collection[str] = (),
    recent: FloatArray | None = None,
) -> tuple[Reason, ...]:
    """Why listener number ``listener`` of ``result`` feels nothing; () where it feels something.

    ``muted``: names of sources that are switched off rather than at amplitude 0. ``recent`` (n,): the last samples of the listener at the
    result's rate, those of the frame where it is None.
    """
    if not result.sources:
        return (Reason(Cause.NO_SOURCE, "there is no source, and no collision was strong enough to make one"),)
    heard = [row for row in range(len(result.sources)) if result.gains[row, listener] > 0 and not _is_over(result, row)]
    if heard:
        return _of_what_arrives(result, listener, heard, recent)
    order = sorted(range(len(result.sources)), key=lambda row: -result.sources[row].amplitude)[:_MOST_SOURCES]
    search = _Search(result, settings, listener, surroundings)
    found = [_of_source(search, row, frozenset(muted)) for row in order]
    return tuple(dict.fromkeys(found))


def _of_what_arrives(result: FrameResult, listener: int, heard: Sequence[int], recent: FloatArray | None) -> tuple[Reason, ...]:
    """Something reaches the listener: why is it not felt?"""
    item = result.listeners[listener]
    if item.gain == 0:
        return (Reason(Cause.LISTENER_GAIN, f"the gain of '{item.name}' is 0", item.name),)
    if recent is None:
        recent = None if result.block is None else result.block[listener]
    if recent is None or len(recent) < 2:
        return (Reason(Cause.NOT_RENDERED, "only this one frame was traced: play to feel what arrives"),)
    strongest = max(heard, key=lambda row: float(result.gains[row, listener]))
    name, arriving = result.sources[strongest].name, _decibels(float(result.gains[strongest, listener] * item.gain))
    if not np.any(recent):
        return (Reason(Cause.PAUSE, f"'{name}' reaches it with {arriving}, but is silent at this moment", name),)
    level = float(sensation_level(recent, result.sample_rate))
    if level > 0:
        return ()
    frequency = dominant_frequency(recent, result.sample_rate)
    return (
        Reason(
            Cause.NOT_FELT,
            f"'{name}' reaches it with {arriving}, which at {frequency:.0f} Hz is {-level:.0f} dB under the threshold of feeling",
            name,
            -level,
        ),
    )


def _is_over(result: FrameResult, row: int) -> bool:
    return _signal_end(result.sources[row]) <= result.time


def _signal_end(source: Source) -> float:
    """Seconds at which nothing of a source is left."""
    default = DEFAULT_PERSISTENT if source.kind is SourceKind.PERSISTENT else DEFAULT_IMPACT
    return source.onset + (source.signal or default).duration


def _of_source(search: _Search, row: int, muted: frozenset[str]) -> Reason:
    """Why nothing of one source arrives."""
    result, settings, listener = search.result, search.settings, search.listener
    source = result.sources[row]
    if source.amplitude == 0:
        why = "is muted" if source.name in muted else "has amplitude 0"
        return Reason(Cause.MUTED, f"'{source.name}' {why}", source.name)
    if _is_over(result, row):
        return Reason(Cause.FINISHED, f"the signal of '{source.name}' was over at {_signal_end(source):.2f} s", source.name)
    if settings.mode is Mode.SD or (settings.mode is Mode.HT and settings.localise == 1):
        nearest = int(np.flatnonzero(nearest_listener(result.graph)[row])[0])
        if nearest != listener:
            name = result.listeners[nearest].name
            rule = "in mode SD" if settings.mode is Mode.SD else "with Localise at 1"
            return Reason(Cause.MODE, f"{rule} only '{name}', the listener nearest to '{source.name}', feels it", name)
    if settings.mode in (Mode.MD, Mode.MN):
        return _of_straight_line(search, row)
    return search.reason(row)


def _of_straight_line(search: _Search, row: int) -> Reason:
    source, settings = search.result.sources[row], search.settings
    if settings.max_connections is not None and settings.max_connections < 1:
        return Reason(Cause.TOO_LONG, "no connection at all is allowed: Max Connections is too low")
    distance = float(straight_distances(search.result.graph)[row, search.listener])
    loss = DISTANCE_ONLY.alpha * distance * _NEPER if settings.mode is Mode.MD else 0.0
    return Reason(
        Cause.BELOW_THRESHOLD,
        f"'{source.name}' is {_metres(distance)} away: {_minus(loss)} is under the threshold of {_decibels(settings.threshold)}",
        source.name,
        loss,
    )


_NEPER = 20 / math.log(10)
"""Decibels of a factor e."""


class _Search:
    """Looks for what keeps a listener from its sources. What takes long is done once, for the first source that needs it."""

    def __init__(self, result: FrameResult, settings: Settings, listener: int, surroundings: Surroundings | None) -> None:
        self.result, self.settings, self.listener = result, settings, listener
        self._surroundings = surroundings
        self._known_graph: HapticGraph | None = None

    def reason(self, row: int) -> Reason:
        """Why no path leads from source ``row`` to the listener."""
        graph = self._graph()
        path = _path(graph, row, self.listener)
        if path:
            return self._of_path(graph, row, path)
        walls = np.where(graph.table.loss >= _WALL, _WALL, 1e-3)
        walls[sorted(graph.table.special)] = _WALL / 4
        count = len(walls)
        table = replace(graph.table, factor=np.exp(-walls), decay=np.full(count, 1e-3), loss=walls, special=frozenset())
        loss = np.minimum(graph.transmission_loss, _WALL)
        open_graph = replace(graph, table=table, transmission=np.exp(-loss), transmission_loss=loss)
        path = _path(open_graph, row, self.listener)
        return self._of_wall(graph, path) if path else self._of_gap(graph, row)

    def _graph(self) -> HapticGraph:
        """The frame's graph with all its contacts: those that no signal could reach may have been left out."""
        if self._known_graph is None:
            graph, around = self.result.graph, self._surroundings
            if around is not None and len(around.bodies):
                tracker = ContactTracker(around.bodies, around.contact_settings)
                contacts = tracker.update(0.0, around.transforms).contacts
                index = graph.table.index()
                numbers = np.array([index[body.name] for body in around.bodies], dtype=np.int64)
                transmissions = self.result.contacts.transmissions
                contacts = replace(contacts, pairs=numbers[contacts.pairs], transmissions=transmissions)
                graph = build_graph(graph.table, contacts, self.result.sources, self.result.listeners)
            self._known_graph = distance_only(graph) if self.settings.mode is Mode.SD else graph
        return self._known_graph

    def _of_path(self, graph: HapticGraph, row: int, path: tuple[int, ...]) -> Reason:
        """There is a path, but it is too weak or too long."""
        losses = _losses(graph, path)
        total = sum(loss for _, loss, _ in losses)
        names = _shortened(objects_on(graph, path))
        limit = -_NEPER * math.log(self.settings.threshold) if self.settings.threshold > 0 else math.inf
        count = len(path) - 1
        if total <= limit and self.settings.max_connections is not None and count > self.settings.max_connections:
            words = f"the way {names} has {count} connections, {self.settings.max_connections} are allowed"
            return Reason(Cause.TOO_LONG, words, self.result.sources[row].name)
        worst, loss, way = max(losses, key=lambda item: item[1])
        words = (
            f"the best way, {names}, passes on {_minus(total)}, under the threshold of {_minus(limit)}: "
            f"'{worst}' takes the most, {loss:.0f} dB over {_metres(way)}"
        )
        return Reason(Cause.BELOW_THRESHOLD, words, worst, total)

    def _of_wall(self, graph: HapticGraph, path: tuple[int, ...]) -> Reason:
        """There is a way of contacts, but something on it passes on nothing."""
        for a, b in itertools.pairwise(path):
            first, second = (graph.table.names[graph.node_object[node]] for node in (a, b))
            if graph.partner[a] == b and graph.contact[a] >= 0:
                if not math.isfinite(graph.transmission_loss[graph.contact[a]]):
                    return Reason(Cause.BLOCKED, f"the contact of '{first}' and '{second}' passes on nothing", first)
            elif not math.isfinite(float(intra_costs(graph, np.array([a]), np.array([b]))[0])):
                item = graph.table.objects[graph.node_object[a]]
                if (1 - item.kappa) * item.rho == 0 and item.propagation.name == "haptic_tracing":
                    why = "kappa is 1" if item.kappa == 1 else "rho is 0"
                    return Reason(Cause.BLOCKED, f"'{first}' passes on nothing, because its {why}", first)
                distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
                function = item.propagation.name.replace("_", " ")
                return Reason(Cause.BLOCKED, f"'{first}' passes on nothing over {_metres(distance)}: see its function, {function}", first)
        names = _shortened(objects_on(graph, path))
        return Reason(Cause.BLOCKED, f"the way {names} crosses an object twice in a row", graph.table.names[graph.node_object[path[0]]])

    def _of_gap(self, graph: HapticGraph, row: int) -> Reason:
        """No chain of contacts leads there: between which objects is the way open?"""
        source, listener = self.result.sources[row], self.result.listeners[self.listener]
        names = graph.table.names
        start = {names[graph.node_object[node]] for node in graph.sources[row].nodes}
        end = names[graph.node_object[graph.listener_nodes[self.listener]]]
        gaps = _gaps(self._surroundings, graph, start, end) if self._surroundings is not None else ()
        if not gaps:
            words = f"no contact leads from '{source.name}' on '{source.object}' to '{end}', on which '{listener.name}' is"
            return Reason(Cause.NO_CONTACT, words, end)
        first, second, distance = gaps[0]
        tolerance = self._surroundings.contact_settings.tolerance if self._surroundings is not None else 0.0
        words = f"no contact leads from '{source.name}' to it: '{first}' and '{second}' are {_metres(distance)} apart"
        if len(gaps) > 1:
            words += f", and so are {len(gaps) - 1} more pair{'s' if len(gaps) > 2 else ''} on the way"
        elif distance < 10 * tolerance:
            words += f", they touch from {_metres(tolerance)} on"
        return Reason(Cause.NO_CONTACT, words, second)


def _path(graph: HapticGraph, row: int, column: int) -> tuple[int, ...]:
    """The best path without any limit, () where there is none."""
    return best_paths(graph, [(row, column)], None, 0.0, BUDGET, amplifying(graph), {}).nodes.get((row, column), ())


def _losses(graph: HapticGraph, path: tuple[int, ...]) -> list[tuple[str, float, float]]:
    """Per object on a path, its contact with the next one included: name, decibels, metres."""
    result: dict[str, tuple[float, float]] = {}
    for a, b in itertools.pairwise(path):
        name = graph.table.names[graph.node_object[a]]
        if graph.partner[a] == b and graph.contact[a] >= 0:
            cost, way = float(graph.transmission_loss[graph.contact[a]]), 0.0
        else:
            ends = np.array([a]), np.array([b])
            cost, way = float(intra_costs(graph, *ends)[0]), float(graph.node_distances(*ends)[0])
        loss, before = result.get(name, (0.0, 0.0))
        result[name] = loss + _NEPER * cost, before + way
    return [(name, loss, way) for name, (loss, way) in result.items()]


def _gaps(around: Surroundings, graph: HapticGraph, start: set[str], end: str) -> tuple[tuple[str, str, float], ...]:
    """The pairs of objects (first, second, metres) on the way from ``start`` to ``end`` that has the least air in it, widest first.

    Ways lead through contacts for free and through air by the distance of bounding boxes; what is found is then measured exactly.
    """
    row = {body.name: number for number, body in enumerate(around.bodies)}
    if end not in row or not start & row.keys():
        return ()
    bounds = transformed_bounds(np.array([body.shape.local_bounds() for body in around.bodies]), around.transforms)
    joined: list[set[int]] = [set() for _ in around.bodies]
    contact = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    for a, b in zip(graph.node_object[contact].tolist(), graph.node_object[graph.partner[contact]].tolist(), strict=True):
        first, second = row.get(graph.table.names[a]), row.get(graph.table.names[b])
        if first is not None and second is not None:
            joined[first].add(second)
            joined[second].add(first)
    before = _least_air(bounds, joined, [row[name] for name in sorted(start & row.keys())], row[end])
    way = [row[end]]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    pairs = [(a, b) for a, b in itertools.pairwise(reversed(way)) if b not in joined[a]]
    found = [(around.bodies[a].name, around.bodies[b].name, _distance(around, bounds, a, b)) for a, b in pairs]
    return tuple(sorted(found, key=lambda gap: -gap[2]))


def _least_air(bounds: FloatArray, joined: Sequence[set[int]], start: Sequence[int], end: int) -> IntArray:
    """Predecessors (n,) of Dijkstra's search over all bodies, -1 at the start."""
    count = len(bounds)
    air, before = np.full(count, np.inf), np.full(count, -1, dtype=np.int64)
    air[list(start)] = 0.0
    left = np.ones(count, dtype=np.bool_)
    while left[end]:
        here = int(np.argmin(np.where(left, air, np.inf)))
        left[here] = False
        apart = np.maximum(np.maximum(bounds[:, 0] - bounds[here, 1], bounds[here, 0] - bounds[:, 1]), 0.0)
        step = np.sqrt((apart**2).sum(axis=1)) + 1e-3  # of equal ways that with fewer steps
        step[list(joined[here])] = 1e-9
        better = left & (air[here] + step < air)
        air[better], before[better] = air[here] + step[better], here
    return before


def _distance(around: Surroundings, bounds: FloatArray, a: int, b: int) -> float:
    """Metres between two bodies, at least 0."""
    poses = np.array([[*around.transforms[k, :3, :3].ravel(), *around.transforms[k, :3, 3]] for k in (a, b)]).T
    rotation, offset = relative_pose(poses[:, :1], poses[:, 1:])
    reach = np.linalg.norm(bounds[[a, b], 1].max(axis=0) - bounds[[a, b], 0].min(axis=0))
    bodies = [around.bodies[k] for k in (a, b)]
    narrow = NarrowPhase([body.shape for body in bodies], [body.medium for body in bodies])
    return max(float(narrow.query(np.array([[0, 1]]), rotation, offset, np.array([reach])).distance[0]), 0.0)


def _shortened(names: Sequence[str]) -> str:
    """A way in words, its middle left out where it is long."""
    shown = list(names) if len(names) <= 6 else [*names[:3], "...", *names[-2:]]
    return " > ".join(shown)


def _decibels(gain: float) -> str:
    return _minus(-20 * math.log10(gain))


def _minus(loss: float) -> str:
    """A loss in decibels as a level."""
    return f"\N{MINUS SIGN}{loss:.0f} dB" if round(loss) > 0 else f"{abs(loss):.0f} dB"


def _metres(distance: float) -> str:
    if distance < 0.01:
        return f"{1000 * distance:.1f} mm"
    return f"{100 * distance:.1f} cm" if distance < 1 else f"{distance:.1f} m"
