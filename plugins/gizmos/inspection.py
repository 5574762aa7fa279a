"""What is under the mouse in the overlay: a connection of a best path, or the source or listener at
its end, with its objects, distance, loss, and the gain up to its end."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from bpy.types import Context

from ...addon.blender.units import metres_per_unit
from ...addon.blender.words import ui_text
from ...addon.changes.events import file_changed
from ...addon.session.derived import Derived
from ...addon.session.sessions import Traced
from ...addon.view import meters
from ...addon.view.hud import FAINT_INK, INK, PLATE, HudBuilder, overlaps
from ...addon.view.label_placement import project
from ...addon.view.layout import pixels_per_point
from ...addon.view.levels import change_words
from ...addon.view.screen import Recent, draw_flat, in_theme, uploaded
from ...addon.view.watched import levels_of
from ...core.arrays import FloatArray
from ...core.diagnosis.connections import connections
from ...core.message import Metres, written
from ...core.scene.values import Listener, Source

_REACH = 9.0  # points around a connection
_PADDING, _ROW = 8.0, 16.0  # points
hovered = Recent()
"""The link under the mouse and the mouse's place, by the region's address; None for none."""


class Link(NamedTuple):
    """A connection of a best path. A source or listener counts as one without length.

    Attributes:
        first, second: objects of its two nodes.
        source, listener: ends of the path; without one, "" and the name itself.
        distance: its length, or of a source or listener that of the path up to it [m].
        loss: in it, or of a source or listener on the path up to it [dB].
        gain: from the source to its end [dB].
    """

    first: str
    second: str
    source: str
    listener: str
    distance: float
    loss: float
    gain: float


class Links(NamedTuple):
    """The links, and the places of their ends (m, 2, 3) [m]."""

    items: tuple[Link, ...]
    position: FloatArray


def links_of(traced: Traced, *_: object) -> Links:
    """Computed on the worker: all connections of best paths, the strongest use of each, and all
    sources and listeners."""
    result, names = traced.result, traced.result.graph.table.names
    found = connections(result, traced.settings.mode)
    items = []
    ends = []
    for nodes, amplitude, along, (row, column) in zip(
        found.nodes.tolist(),
        found.amplitude.tolist(),
        found.along.tolist(),
        found.pair.tolist(),
        strict=True,
    ):
        source = result.sources[row]
        listener = result.listeners[column].name
        first, second = (names[result.graph.node_object[node]] for node in nodes)
        before, after = map(_decibels, amplitude)
        loss = before - after if math.isfinite(before) else 0.0
        gain = after - _decibels(source.amplitude)
        distance = along[1] - along[0]
        items.append(Link(first, second, source.name, listener, distance, loss, gain))
        ends.append(nodes)
        path = result.propagation.best_path[row, column]
        if nodes[0] == path[0] and source.second_object is None:
            items.append(Link(source.name, source.name, source.name, listener, 0.0, 0.0, 0.0))
            ends.append([nodes[0]] * 2)
        if nodes[1] == path[-1]:
            items.append(Link(listener, listener, source.name, listener, along[1], -gain, gain))
            ends.append([nodes[1]] * 2)
    places = np.array(ends, dtype=np.int64).reshape(-1, 2)
    position = result.graph.node_position[places]
    known = {item.first for item in items if item.first == item.second}
    every: list[Source | Listener] = [*result.sources, *result.listeners]
    alone = [item for item in every if item.name not in known]
    items += [Link(item.name, item.name, "", item.name, 0.0, 0.0, -math.inf) for item in alone]
    own = np.array([item.position for item in alone]).reshape(-1, 1, 3)
    return Links(tuple(items), np.concatenate([position, own.repeat(2, axis=1)]))


_LINKS: Derived[None, Links] = Derived(links_of)


def _decibels(factor: float) -> float:
    return 20 * math.log10(factor) if factor > 0 else -math.inf


def under(context: Context, mouse: tuple[float, float]) -> Link | None:
    """The source, listener or contact within reach of the mouse [pixels of the viewport], else the
    nearest connection."""
    latest = _LINKS.latest(context.scene, None)
    if latest is None or not latest.value.items:
        return None
    target = meters.target_under(context, mouse)
    if target is not None:
        whole = (link for link in latest.value.items if link.first == link.second)
        return next((link for link in whole if link.first == target.listener), None)
    if any(map(partial(overlaps, (*mouse, *mouse)), meters.occupied(context))):
        return None
    region, view = context.region, context.region_data
    perspective = np.array(view.perspective_matrix, dtype=np.float64)
    ends = project(
        latest.value.position.reshape(-1, 3) / metres_per_unit(context.scene),
        perspective,
        (region.width, region.height),
    ).reshape(-1, 2, 2)
    away = distances_to(np.array(mouse, dtype=np.float64), ends)
    reach = _REACH * pixels_per_point(context)
    is_point = (latest.value.position[:, 0] == latest.value.position[:, 1]).all(axis=1)
    order = np.where(away <= reach, away - reach * is_point, np.inf)
    nearest = int(order.argmin())
    return latest.value.items[nearest] if order[nearest] < np.inf else None


def distances_to(place: FloatArray, ends: FloatArray) -> FloatArray:
    """Distances of a place (2,) to segments with ``ends`` (m, 2, 2); NaN where an end is NaN."""
    start = ends[:, 0]
    way = ends[:, 1] - ends[:, 0]
    square = np.maximum((way**2).sum(axis=1), 1e-12)
    share = np.clip(((place - start) * way).sum(axis=1) / square, 0.0, 1.0)
    return np.sqrt(((start + share[:, None] * way - place) ** 2).sum(axis=1))


def words_of(link: Link, verdict: str = "") -> tuple[str, ...]:
    """The lines of the tooltip; ``verdict``: what the listener feels that the link is."""
    if not link.source or (link.first == link.second and not link.distance):
        return (link.first, verdict) if verdict else (link.first,)
    loss = change_words(-link.loss)
    if link.first == link.second:
        title = f"{link.first}: {verdict}" if verdict else link.first
        way = f"{written(Metres(link.distance))}, {loss}"
    else:
        title = f"{link.first} \N{MULTIPLICATION SIGN} {link.second}"
        way = ui_text("Contact, {}", loss)
    gain = ui_text("Gain up to here {}", change_words(link.gain))
    return title, way, gain, f"{link.source} \N{RIGHTWARDS ARROW} {link.listener}"


def draw(context: Context) -> None:
    """Draw the words of the connection under the mouse on a plate beside it, within the
    viewport."""
    found = hovered.get(context.region.as_pointer())
    if found is None:
        return
    link, mouse = found
    scale = pixels_per_point(context)
    builder = HudBuilder(scale)
    shown = {level.listener: level.verdict() for level in levels_of(context.scene)}
    words = words_of(link, shown.get(link.first, "") if link.first == link.second else "")
    width = max(map(builder.width, words)) + 2 * _PADDING
    height = len(words) * _ROW + _PADDING
    left = min(mouse[0] / scale + 14, context.region.width / scale - width)
    top = max(mouse[1] / scale - 10, height)
    builder.plate((left, top - height), (left + width, top), (*PLATE[:3], 1.0), 4.0)
    for number, line in enumerate(words):
        place = left + _PADDING, top - _ROW * (number + 1) + 2
        builder.text(line, place, FAINT_INK if number else INK)
    shown_words = uploaded(in_theme(builder.build()))
    draw_flat(shown_words, (context.region.width, context.region.height), scale)


file_changed.subscribe(hovered.clear)
