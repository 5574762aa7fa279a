"""Drawn signals as node groups, and their curves as F-curves and back."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from bpy.types import NodeTree, Object, Scene

from ...core.arrays import FloatArray
from ...core.signals import DEFAULT_PERSISTENT, Automation, Drawing, Signal
from ...core.signals.drawn import EMPHASIS_SECONDS, cut
from ..blender.compatibility import ensure_fcurve, remove_fcurves
from ..blender.time import frame_seconds, stretching
from ..properties.drawing import AMPLITUDE, FREQUENCY, LONGEST, HapticDrawing
from ..properties.signal_kinds import HERTZ
from ..scene_reader import animated_curves as animated
from ..scene_reader.drawings import MOST_EMPHASES, mapping_of, points_of
from ..scene_reader.objects import read_source

PATHS = {AMPLITUDE: animated.ENVELOPE, FREQUENCY: animated.FREQUENCY}
"""Data paths of the F-curves that replace a curve."""
_APART = 0.0125
"""Least distance of keys in frames: Blender merges keys that are nearer than 0.01."""
_MOST_POINTS = 1000
_KINDS = ("AUTO", "AUTO_CLAMPED", "VECTOR")


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


def has_fcurves(obj: Object) -> bool:
    """Whether F-curves replace the curves of an object's drawn signal."""
    return any(animated.animating(obj, path) for path in PATHS.values())


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


def shape_envelope(
    tree: NodeTree, attack: float, decay: float, sustain: float, release: float
) -> None:
    """Draw an envelope of straight lines over a whole signal, which is extended if it is too short.

    Args:
        tree: the drawn signal.
        attack: time from 0 to 1 [s].
        decay: time from 1 to ``sustain`` [s].
        sustain: 0 to 1.
        release: time from ``sustain`` to 0 [s].
    """
    tree.haptics.duration = max(tree.haptics.duration, attack + decay + release)
    hold = max(tree.haptics.duration - attack - decay - release, 0.0)
    corners = np.column_stack(
        [
            np.cumsum([0.0, attack, decay, hold, release]) / tree.haptics.duration,
            [0.0, 1.0, sustain, sustain, 0.0],
        ]
    )
    write_points(mapping_of(tree, AMPLITUDE), corners[int(attack == 0.0) : 5 - int(release == 0.0)])


def signal_of(obj: Object, scene: Scene) -> Signal:
    """The signal of a source. Raises ValueError or OSError if it cannot be read."""
    return (
        read_source(obj, obj.name_full, animated.AnimatedCurves().of_source(obj, scene)).signal
        or DEFAULT_PERSISTENT
    )


def to_fcurves(obj: Object, drawing: HapticDrawing, scene: Scene) -> None:
    """Convert the curves of an object's ``drawing`` to F-curves from the scene's first frame on,
    with a key for each point."""
    frames = drawing.duration / frame_seconds(scene)
    for name, path in PATHS.items():
        points, kinds = points_of(mapping_of(drawing.id_data, name))
        low, high = (0.0, 1.0) if name == AMPLITUDE else (drawing.lowest, drawing.highest)
        places = points * (frames, high - low) + (scene.frame_start, low)
        places[:, 0] /= stretching(scene)
        for k in range(1, len(places)):
            places[k, 0] = max(places[k, 0], places[k - 1, 0] + _APART)
        remove_fcurves(obj, [path])
        curve = ensure_fcurve(obj, path, "Drawn Signal")
        keys = curve.keyframe_points
        keys.add(len(points))
        keys.foreach_set("co", places.astype(np.float32).ravel())
        for key, kind, after in zip(keys, kinds, [*kinds[1:], kinds[-1]], strict=True):
            key.handle_left_type = key.handle_right_type = kind
            key.interpolation = "LINEAR" if kind == after == "VECTOR" else "BEZIER"
        curve.update()


def from_fcurves(obj: Object, drawing: HapticDrawing, scene: Scene) -> None:
    """Convert F-curves to the curves of an object's ``drawing`` over its duration; its frequency
    range is extended as needed."""
    for name, path in PATHS.items():
        curve = animated.animating(obj, path)
        if curve is None:
            continue
        points, kinds = _keys(curve)
        seconds = _seconds(points[:, 0], scene)
        if seconds[0] < 0.0 or seconds[-1] > drawing.duration * (1.0 + 1e-6):
            lines = animated.corners(curve)
            part = cut(
                Automation(_seconds(lines[:, 0], scene), lines[:, 1]),
                drawing.duration,
            )
            seconds = part.times
            points = np.column_stack([part.times, part.values])
            kinds = []
        low, high = 0.0, 1.0
        if name == FREQUENCY:
            drawing.lowest, drawing.highest = (
                min(drawing.lowest, points[:, 1].min()),
                max(drawing.highest, points[:, 1].max()),
            )
            low, high = drawing.lowest, drawing.highest
        write_points(
            mapping_of(drawing.id_data, name),
            np.column_stack([seconds / drawing.duration, (points[:, 1] - low) / (high - low)]),
            kinds,
        )
    remove_fcurves(obj, list(PATHS.values()))


def _seconds(keys: FloatArray, scene: Scene) -> FloatArray:
    """Times of the frames of keys (n,) in seconds from the scene's first frame."""
    return (keys * stretching(scene) - scene.frame_start) * frame_seconds(scene)


def _keys(curve: Any) -> tuple[FloatArray, list[str]]:
    """Frames and values of the points (n, 2) of a drawn curve, and their handle types; only corners
    if other handle types were used."""
    keys = list(curve.keyframe_points)
    kinds = [key.handle_right_type for key in keys]
    straight = [
        "LINEAR" if kind == after == "VECTOR" else "BEZIER" for kind, after in pairwise(kinds)
    ]
    fits = all(
        key.handle_left_type == kind and kind in _KINDS
        for key, kind in zip(keys, kinds, strict=True)
    )
    if fits and straight == [key.interpolation for key in keys[:-1]]:
        return np.array([tuple(key.co) for key in keys]), kinds
    return animated.corners(curve), []
