"""Cues at the edge of a viewport to objects of the shown path that are out of sight, and names of
those that are hidden."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from bpy.types import Context

from ...core.arrays import FloatArray
from ..blender.full_names import object_named
from ..blender.words import ui_text
from . import paths
from .hud import Rectangle
from .render_data import Place

_ARROWS = (
    *("\N{RIGHTWARDS ARROW}", "\N{NORTH EAST ARROW}", "\N{UPWARDS ARROW}", "\N{NORTH WEST ARROW}"),
    *("\N{LEFTWARDS ARROW}", "\N{SOUTH WEST ARROW}"),
    *("\N{DOWNWARDS ARROW}", "\N{SOUTH EAST ARROW}"),
)


class Cue(NamedTuple):
    """Words about an object, and where its origin is [pixels], at the edge if it is out of
    sight."""

    words: str
    place: Place


def cues_of(context: Context, perspective: FloatArray, free: Rectangle) -> tuple[Cue, ...]:
    """The cues of the path shown, in its order; ``free``: the part of the viewport that the user
    interface does not cover."""
    latest = paths.path_of(context.scene)
    if latest is None or latest.value is None:
        return ()
    fall = latest.value.fall
    names = (fall.source.name, *(hop.object for hop in fall.hops), fall.listener)
    found = []
    for name in dict.fromkeys(names):
        obj = object_named(name)
        if obj is not None:
            place, arrow = _place(
                np.array([*obj.matrix_world.translation, 1.0]),
                perspective,
                (context.region.width, context.region.height),
                free,
            )
            hidden = not obj.visible_get(viewport=context.space_data)
            words = ui_text("{} (hidden)", name) if hidden else name
            if arrow or hidden:
                found.append(Cue(f"{arrow} {words}".strip(), place))
    return tuple(found)


def _place(
    position: FloatArray, perspective: FloatArray, size: tuple[int, int], free: Rectangle
) -> tuple[Place, str]:
    """The pixels of a homogeneous ``position`` (4,), and an arrow to it if it is outside ``free``,
    at whose edge the pixels then are."""
    clip = perspective @ position
    pixels = (clip[:2] / (clip[3] or 1e-9) * 0.5 + 0.5) * size
    low = np.array(free[:2])
    high = np.array(free[2:])
    if clip[3] > 0 and (low <= pixels).all() and (pixels <= high).all():
        return (float(pixels[0]), float(pixels[1])), ""
    centre = (low + high) / 2
    # Behind the viewer, the projection is mirrored.
    way = (pixels - centre) * (1.0 if clip[3] > 0 else -1.0)
    way = way if way.any() else np.array([0.0, -1.0])
    share = ((high - low) / 2 / np.maximum(np.abs(way), 1e-9)).min()
    arrow = _ARROWS[round(np.arctan2(way[1], way[0]) / (np.pi / 4)) % 8]
    end = centre + share * way
    return (float(end[0]), float(end[1])), arrow
