"""Drawn signals as node groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from bpy.types import NodeTree, Object, Scene

from ...core.arrays import FloatArray
from ...core.signals import DEFAULT_PERSISTENT, Automation, Drawing, Signal
from ...core.signals.drawn import EMPHASIS_SECONDS
from ..properties.drawing import AMPLITUDE, FREQUENCY, LONGEST
from ..properties.signal_kinds import HERTZ
from ..scene_reader import animated_curves as animated
from ..scene_reader.drawings import MOST_EMPHASES
from ..scene_reader.objects import read_source

_MOST_POINTS = 1000


def drawn(name: str, signal: Signal) -> NodeTree | None:
    """A new node group with this signal as a drawing, None if the limits of the properties do not
    allow it."""
    drawing = Drawing.of(signal)
    if (
        drawing is None
        or not EMPHASIS_SECONDS <= drawing.duration <= LONGEST
        or len(drawing.emphases) > MOST_EMPHASES
    ):
        return None
    hertz = drawing.frequency.values
    fits = (
        HERTZ[0] <= hertz.min()
        and hertz.max() <= HERTZ[1]
        and len(hertz) + len(drawing.amplitude.values) <= _MOST_POINTS
    )
    return _new(name, drawing) if fits else None


def drawn_like(obj: Object, scene: Scene) -> NodeTree:
    """A new node group with the signal of a source, as far as it can be drawn, otherwise a swell of
    its frequency."""
    try:
        tree = drawn(obj.name, signal_of(obj, scene))
    except (OSError, ValueError):
        tree = None
    hertz = Automation((0.0,), (obj.haptics.source.frequency,))
    return tree or _new(
        obj.name, Drawing(Automation((0.0, 0.05, 0.3, 1.0), (0.0, 1.0, 0.6, 0.0)), hertz)
    )


def _new(name: str, drawing: Drawing) -> NodeTree:
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    properties, hertz = tree.haptics, drawing.frequency.values
    properties.is_signal = True
    properties.duration = drawing.duration
    properties.loops = drawing.loops
    properties.lowest, properties.highest = (
        min(properties.lowest, hertz.min()),
        max(properties.highest, hertz.max()),
    )
    low, high = properties.lowest, properties.highest
    curves = (
        (AMPLITUDE, drawing.amplitude, drawing.amplitude.values),
        (FREQUENCY, drawing.frequency, (hertz - low) / (high - low)),
    )
    for kind, curve, shares in curves:
        node = tree.nodes.new("ShaderNodeFloatCurve")
        node.name = kind
        node.mapping.extend = "HORIZONTAL"
        write_points(node.mapping, np.column_stack([curve.times / drawing.duration, shares]))
    for emphasis in drawing.emphases:
        item = properties.emphases.add()
        item.place = emphasis.time / drawing.duration
        item.strength = emphasis.strength
        item.sharpness = emphasis.sharpness
    return tree


def write_points(mapping: Any, places: FloatArray, kinds: Sequence[str] = ()) -> None:
    """Replace the points of a curve by ``places`` (n, 2), n >= 1, with the handle types ``kinds``,
    corners by default."""
    if len(places) == 1:
        places = np.array([[0.0, places[0, 1]], [1.0, places[0, 1]]])
    places = places.astype(np.float32)
    for k in range(1, len(places)):  # Blender sorts points, coincident ones in any order
        places[k, 0] = max(places[k, 0], np.nextafter(places[k - 1, 0], np.float32(2.0)))
    points = mapping.curves[0].points
    while len(points) > len(places):
        points.remove(points[len(points) - 1])
    while len(points) < len(places):
        points.new(1.0, 0.0)
    for k, (point, place) in enumerate(zip(points, places.tolist(), strict=True)):
        point.location = place
        point.handle_type = kinds[k] if kinds else "VECTOR"
        point.select = False
    mapping.update()


def signal_of(obj: Object, scene: Scene) -> Signal:
    """The signal of a source. Raises ValueError or OSError if it cannot be read."""
    return (
        read_source(obj, obj.name_full, animated.AnimatedCurves().of_source(obj, scene)).signal
        or DEFAULT_PERSISTENT
    )
