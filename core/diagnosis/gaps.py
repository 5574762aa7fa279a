"""Causes of silence between objects: gaps without a contact."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.narrow.frames import relative_pose
from ..contacts.narrow.narrow_phase import NarrowPhase
from ..contacts.settings import Body, ContactSettings
from ..contacts.shapes import transformed_bounds
from ..contacts.tracker import ContactTracker
from ..frozen import frozen
from ..graph.distance_only import distance_only
from ..graph.haptic_graph import HapticGraph, build_graph
from ..message import Argument, Cause, Message, Metres
from ..render.frame_result import FrameResult
from ..scene.values import Mode, Settings

_NARROW = 10
"""A gap is called narrow up to this multiple of the contact tolerance."""


@frozen
class Surroundings:
    """The bodies of a frame with their ``transforms`` (n, 4, 4), and the settings of contacts
    between them."""

    bodies: tuple[Body, ...]
    transforms: FloatArray
    contact_settings: ContactSettings


@frozen
class Gap:
    """Two objects that a signal cannot cross between, and their distance [m]."""

    first: str
    second: str
    distance: float


def complete_graph(
    result: FrameResult, settings: Settings, surroundings: Surroundings | None
) -> HapticGraph:
    """The frame's graph with all its contacts: tracing may have left out those that no signal could
    reach."""
    graph = result.graph
    if surroundings is not None and len(surroundings.bodies):
        tracker = ContactTracker(surroundings.bodies, surroundings.contact_settings)
        contacts = tracker.update(0.0, surroundings.transforms).contacts
        index = graph.table.index()
        numbers = np.array([index[body.name] for body in surroundings.bodies], dtype=np.int64)
        contacts = replace(
            contacts, pairs=numbers[contacts.pairs], transmissions=result.contacts.transmissions
        )
        graph = build_graph(graph.table, contacts, result.sources, result.listeners, graph.frames)
    return distance_only(graph) if settings.mode is Mode.SD else graph


def gap_message(
    result: FrameResult,
    graph: HapticGraph,
    row: int,
    listener: int,
    surroundings: Surroundings | None,
) -> Message:
    """Message that no chain of contacts leads from source ``row`` to ``listener``, with the objects
    at its gap.

    Args:
        result: the traced frame.
        graph: its complete graph.
        row: number of the source.
        listener: number of the listener.
        surroundings: poses and shapes of the bodies, None where they are unknown.
    """
    source = result.sources[row]
    felt_at = result.listeners[listener]
    names = graph.table.names
    start = {names[graph.node_object[node]] for node in graph.sources[row].nodes}
    end = names[graph.node_object[graph.listener_nodes[listener]]]
    found = gaps(surroundings, graph, start, end) if surroundings is not None else ()
    if surroundings is None or not found:
        return Message.of(
            Cause.NO_CONTACT,
            end,
            source=source.name,
            carrier=source.object,
            object=end,
            listener=felt_at.name,
        )
    widest = found[0]
    tolerance = surroundings.contact_settings.tolerance
    arguments: dict[str, Argument] = {
        "source": source.name,
        "first": widest.first,
        "second": widest.second,
    }
    arguments["distance"] = Metres(widest.distance)
    if len(found) > 1:
        return Message.of(Cause.SEVERAL_GAPS, widest.second, **arguments, count=len(found))
    if widest.distance < _NARROW * tolerance:
        return Message.of(Cause.NARROW_GAP, widest.second, **arguments, tolerance=Metres(tolerance))
    return Message.of(Cause.GAP, widest.second, **arguments)


def gaps(
    surroundings: Surroundings, graph: HapticGraph, start: set[str], end: str
) -> tuple[Gap, ...]:
    """The gaps, widest first, on the route from the objects ``start`` to ``end`` with the least
    total gap.

    Contacts have the cost 0 and gaps the distance of bounding boxes; the gaps found are then
    measured exactly.
    """
    bodies = surroundings.bodies
    row = {body.name: number for number, body in enumerate(bodies)}
    if end not in row or not start & row.keys():
        return ()
    bounds = transformed_bounds(
        np.array([body.shape.local_bounds for body in bodies]), surroundings.transforms
    )
    touching = _touching(graph, row)
    predecessor = _least_air(
        bounds, touching, [row[name] for name in sorted(start & row.keys())], row[end]
    )
    path = [row[end]]
    while predecessor[path[-1]] >= 0:
        path.append(int(predecessor[path[-1]]))
    apart = [(a, b) for a, b in itertools.pairwise(reversed(path)) if b not in touching[a]]
    found = [
        Gap(bodies[a].name, bodies[b].name, _distance(surroundings, bounds, a, b)) for a, b in apart
    ]
    return tuple(sorted(found, key=lambda gap: -gap.distance))


def _touching(graph: HapticGraph, row: dict[str, int]) -> list[set[int]]:
    """The bodies in contact with each body, by ``row``."""
    touching: list[set[int]] = [set() for _ in row]
    contact = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    for a, b in zip(
        graph.node_object[contact].tolist(),
        graph.node_object[graph.partner[contact]].tolist(),
        strict=True,
    ):
        first = row.get(graph.table.names[a])
        second = row.get(graph.table.names[b])
        if first is not None and second is not None:
            touching[first].add(second)
            touching[second].add(first)
    return touching


def _least_air(
    bounds: FloatArray, touching: Sequence[set[int]], start: Sequence[int], end: int
) -> IntArray:
    """Predecessors (n,) of Dijkstra's search over all bodies, -1 at the start."""
    count = len(bounds)
    air = np.full(count, np.inf)
    predecessor = np.full(count, -1, dtype=np.int64)
    air[list(start)] = 0.0
    open_bodies = np.ones(count, dtype=np.bool_)
    while open_bodies[end]:
        here = int(np.argmin(np.where(open_bodies, air, np.inf)))
        open_bodies[here] = False
        apart = np.maximum(
            np.maximum(bounds[:, 0] - bounds[here, 1], bounds[here, 0] - bounds[:, 1]), 0.0
        )
        step = np.sqrt((apart**2).sum(axis=1)) + 1e-3  # prefers fewer steps among equal distances
        step[list(touching[here])] = 1e-9
        better = open_bodies & (air[here] + step < air)
        air[better] = air[here] + step[better]
        predecessor[better] = here
    return predecessor


def _distance(surroundings: Surroundings, bounds: FloatArray, a: int, b: int) -> float:
    """Distance [m] between two bodies, at least 0."""
    poses = np.array(
        [
            [*surroundings.transforms[k, :3, :3].ravel(), *surroundings.transforms[k, :3, 3]]
            for k in (a, b)
        ]
    ).T
    rotation, offset = relative_pose(poses[:, :1], poses[:, 1:])
    reach = np.linalg.norm(bounds[[a, b], 1].max(axis=0) - bounds[[a, b], 0].min(axis=0))
    bodies = [surroundings.bodies[k] for k in (a, b)]
    narrow = NarrowPhase([body.shape for body in bodies], [body.medium for body in bodies])
    return max(
        float(narrow.query(np.array([[0, 1]]), rotation, offset, np.array([reach])).distance[0]),
        0.0,
    )
