"""The drawn graph as triangles in the colours of the overlay: lines as tubes, symbols as layers of
flat shapes that face the viewer, as on screen. Independent of Blender."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...addon.view.hud import Hud
from ...addon.view.render_data import Drawn, Lines, RenderData
from ...addon.view.symbols import HALO_COLOUR, LOOKS, Symbol
from ...core.arrays import FloatArray, IntArray
from ...core.frozen import frozen

RIM = 2.2
"""Width of the dark rim around lines [points]."""
UPRIGHT = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])
"""Axes to the right, up and to a viewer in front of the scene."""
_SIDES = 10
_LIFT = 0.5, 0.02  # of a symbol's size over its lines, and from one layer to the next


@frozen
class Solid:
    """``vertices`` (n, 3) [m], ``colours`` (n, 4) display values with opacity, ``triangles`` (m,
    3)."""

    vertices: FloatArray
    colours: FloatArray
    triangles: IntArray


def solid_graph(data: RenderData, unit: float, facing: FloatArray) -> Solid:
    """All drawn elements of a frame except its labels, lines with a dark rim. ``unit``: metres per
    point of the overlay; ``facing`` (3, 3): axes to the right, up and to the viewer."""
    tree = replace(data.tree, width=data.tree.width * data.tree.colour[:, :, 3].mean(axis=1))
    shells = [(tree, RIM / 2), (data.paths, RIM)]
    return joined(
        [
            *(
                _rim(tubes(replace(lines, width=lines.width + 2 * by), unit))
                for lines, by in shells
            ),
            tubes(tree, unit),
            tubes(data.paths, unit),
            *(_symbols(data.points, shape, unit, facing) for shape in LOOKS),
        ]
    )


def _rim(shell: Solid) -> Solid:
    """An inverted dark shell: because back faces are not drawn, only a rim is visible around its
    content."""
    colours = np.broadcast_to([*HALO_COLOUR, 1.0], shell.colours.shape)
    return Solid(shell.vertices, colours, shell.triangles[:, ::-1])


def seen_unit(data: RenderData, projection: FloatArray, view: FloatArray, height: float) -> float:
    """Units of the view per point at which the graph looks as thick as the overlay in a picture
    of ``height`` points, at the middle of its depth."""
    position = np.column_stack([data.points.position[:, 0], np.ones(len(data.points.width))])
    depth = (position @ (projection @ view).T)[:, 3]
    seen = depth[depth > 0]
    return 2 * float(np.median(seen) if len(seen) else 1.0) / (projection[1, 1] * height)


def extent_unit(data: RenderData) -> float:
    """Metres per point at which the graph looks as in a viewport that it fills."""
    position = data.points.position[:, 0]
    diagonal = float(np.linalg.norm(np.ptp(position, axis=0))) if len(position) else 0.0
    return max(diagonal, 0.1) / 900


def joined(solids: Sequence[Solid]) -> Solid:
    """Several solids as one."""
    offsets = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate([solid.colours for solid in solids]),
        np.concatenate(
            [solid.triangles + offset for solid, offset in zip(solids, offsets[:-1], strict=True)]
        ),
    )


def tubes(lines: Lines, unit: float) -> Solid:
    """Lines as open tubes, without those of length 0."""
    long = (lines.position[:, 0] != lines.position[:, 1]).any(axis=1)
    position = lines.position[long].astype(np.float64)
    radius = lines.width[long] * unit / 2
    across, upward = _perpendicular(position[:, 1] - position[:, 0])
    angle = np.linspace(0, 2 * np.pi, _SIDES, endpoint=False)
    ring = np.cos(angle)[:, None] * across[:, None, :] + np.sin(angle)[:, None] * upward[:, None, :]
    vertices = position[:, :, None, :] + (radius[:, None, None] * ring)[:, None, :, :]
    near = np.arange(_SIDES)
    far = (near + 1) % _SIDES
    faces = np.concatenate(
        [
            np.stack([near, far, far + _SIDES], axis=1),
            np.stack([near, far + _SIDES, near + _SIDES], axis=1),
        ]
    )
    triangles = (2 * _SIDES * np.arange(len(position))[:, None, None] + faces).reshape(-1, 3)
    colours = np.repeat(lines.colour[long, :, :3], _SIDES, axis=1).reshape(-1, 3)
    return Solid(vertices.reshape(-1, 3), _opaque(colours), triangles)


def _opaque(colours: FloatArray | Drawn) -> FloatArray:
    return np.column_stack([colours, np.ones(len(colours))]).astype(np.float64)


def _perpendicular(along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (n, 3) perpendicular to ``along`` (n, 3), which is not 0, and to each
    other."""
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    other = np.where(np.abs(along[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    across = np.cross(along, other)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(along, across)


def _symbols(points: Lines, shape: Symbol, unit: float, facing: FloatArray) -> Solid:
    """The symbols of a ``shape``, each layer a little nearer to the viewer."""
    chosen = points.shape == shape
    position = points.position[chosen, 0].astype(np.float64)
    size = points.width[chosen] * unit
    corners = LOOKS[shape].ring() @ facing[:2]
    parts = []
    for number, (inset, colour, _) in enumerate(
        LOOKS[shape].coloured(points.colour[chosen, 0, :3].astype(np.float64))
    ):
        lift = (_LIFT[0] + _LIFT[1] * number) * size[:, None]
        centre = position + lift * facing[2]
        radius = np.maximum(size / 2 - inset * unit, 0.0)
        ring = centre[:, None] + radius[:, None, None] * corners
        colours = np.broadcast_to(colour, (len(size), 3)).repeat(len(corners) + 1, axis=0)
        parts.append(_fans(centre, ring, _opaque(colours)))
    return joined(parts)


def _fans(centres: FloatArray, rings: FloatArray, colours: FloatArray) -> Solid:
    """Star-shaped areas (n) by their centres (n, 3) and corners (n, k, 3), counterclockwise;
    ``colours`` (n * (k + 1), 4): of each centre and then its corners."""
    count, corners = rings.shape[:2]
    around = np.arange(corners)
    fan = np.column_stack([np.zeros_like(around), around + 1, (around + 1) % corners + 1])
    triangles = ((corners + 1) * np.arange(count)[:, None, None] + fan).reshape(-1, 3)
    vertices = np.concatenate([centres[:, None], rings], axis=1)
    return Solid(vertices.reshape(-1, 3), colours, triangles)


def flat(items: Hud, scale: float) -> Solid:
    """Plates, leaders and symbols of labels and legend as flat shapes, in pixels; every later one
    lies a little higher. ``scale``: pixels per point."""
    shapes: list[tuple[FloatArray, FloatArray]] = []
    lines = items.lines
    for (start, end), colour, width, shape in zip(
        lines.position[:, :, :2], lines.colour, lines.width * scale, lines.shape, strict=True
    ):
        if shape in LOOKS:
            look = LOOKS[Symbol(int(shape))]
            for inset, layer, opacity in look.coloured(colour[0, :3]):
                outline = start + (width / 2 - inset * scale) * look.ring()
                shapes.append((outline, np.broadcast_to([*layer, opacity], (len(outline), 4))))
            continue
        outline = (
            _rounded(start, end, width / 2) if shape == Symbol.PLATE else _bar(start, end, width)
        )
        part = np.clip((outline[:, :1] - start[0]) / max(end[0] - start[0], 1e-9), 0, 1)
        shapes.append((outline, colour[0] + part * (colour[1] - colour[0])))
    parts = []
    for number, (outline, colour) in enumerate(shapes):
        ring = np.column_stack([outline, np.full(len(outline), 0.01 * scale * number)])
        colours = np.concatenate([colour.mean(axis=0, keepdims=True), colour])
        parts.append(_fans(ring.mean(axis=0)[None], ring[None], colours))
    return joined(parts)


def _rounded(low: FloatArray, high: FloatArray, radius: float) -> FloatArray:
    """The corners of a rectangle, each as a quarter of a circle."""
    turn = np.arange(28) // 7
    right = turn % 3 == 0
    up = turn < 2
    inner = np.column_stack(
        [
            np.where(right, high[0] - radius, low[0] + radius),
            np.where(up, high[1] - radius, low[1] + radius),
        ]
    )
    angle = np.pi / 2 * (turn + np.arange(28) % 7 / 6)
    return inner + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _bar(start: FloatArray, end: FloatArray, width: float) -> FloatArray:
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    across = np.array([-along[1], along[0]]) * width / 2
    return np.array([start - across, end - across, end + across, start + across], dtype=np.float64)
