"""Drawn signals, read from node groups."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ...core.arrays import FloatArray
from ...core.signals import Automation, Drawing, Emphasis
from ...core.signals.drawn import EMPHASIS_SECONDS
from ..blender.arrays import read_array
from ..blender.single_precision import shortest
from ..properties.drawing import AMPLITUDE, FREQUENCY

MOST_EMPHASES = 200
_TABLE = 256
"""Number of points at which Blender evaluates a rounded curve."""


def read_drawing(tree: Any) -> Drawing:
    """The signal that is drawn in a node group.

    Raises ValueError, with a message for the user, if it is not a drawn signal.
    """
    if tree is None:
        raise ValueError(iface_("no signal is drawn yet: press New in the panel Haptic Source"))
    drawing = tree.haptics
    seconds, low, high = (
        shortest(value) for value in (drawing.duration, drawing.lowest, drawing.highest)
    )
    try:
        return Drawing(
            _automation(mapping_of(tree, AMPLITUDE), seconds, 0.0, 1.0),
            _automation(mapping_of(tree, FREQUENCY), seconds, low, high),
            seconds,
            tuple(_emphases(drawing, seconds)),
            drawing.loops,
        )
    except ValueError as error:
        raise ValueError(
            iface_("the drawn signal '{}' is damaged: {}").format(tree.name, error)
        ) from None


def mapping_of(tree: Any, name: str) -> Any:
    """The curve mapping of a drawn signal. Raises ValueError if there is none."""
    node = tree.nodes.get(name)
    if node is None or node.bl_idname != "ShaderNodeFloatCurve":
        raise ValueError(iface_("it has no curve '{}'").format(iface_(name)))
    return node.mapping


def points_of(mapping: Any) -> tuple[FloatArray, list[str]]:
    """Coordinates of a curve's points, shape (n, 2), and the handle type of each: VECTOR (a
    corner), AUTO or AUTO_CLAMPED."""
    points = mapping.curves[0].points
    return read_array(points, "location", 2).astype(np.float64), [
        point.handle_type for point in points
    ]


def _automation(mapping: Any, seconds: float, low: float, high: float) -> Automation:
    """A curve over time: straight between corners, otherwise sampled from Blender's curve."""
    points, kinds = points_of(mapping)
    is_round = np.array([kind != "VECTOR" for kind in kinds])
    grid = np.arange(_TABLE + 1) / _TABLE
    after = np.searchsorted(points[:, 0], grid)  # the point at or after each place of the table
    inside = grid[(after > 0) & (after < len(points)) & ~np.isin(grid, points[:, 0])]
    of = np.searchsorted(points[:, 0], inside)
    inside = inside[is_round[of] | is_round[of - 1]]
    if len(inside):
        mapping.initialize()
        drawn = [(place, mapping.evaluate(mapping.curves[0], place)) for place in inside.tolist()]
        points = np.concatenate([points, drawn])
        points = points[np.argsort(points[:, 0], kind="stable")]
    return Automation(points[:, 0] * seconds, low + (high - low) * np.clip(points[:, 1], 0.0, 1.0))


def _emphases(drawing: Any, seconds: float) -> Iterator[Emphasis]:
    for item in islice(drawing.emphases, MOST_EMPHASES):
        time = max(min(shortest(item.place) * seconds, seconds - EMPHASIS_SECONDS), 0.0)
        yield Emphasis(time, shortest(item.strength), shortest(item.sharpness))
