"""The drawn graph as triangles: tubes, spheres, rings, diamonds and spiked balls in the colours of
the overlay. Independent of Blender."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.arrays import BoolArray, FloatArray, IntArray
from .hud import Hud
from .render_data import HALO_COLOUR, Drawn, Lines, Points, RenderData, Shape, lines_of, points_of

Triangles = IntArray
WHITE = np.array([0.97, 0.97, 0.97])
RIM = 2.2
"""Width of the dark rim around lines and symbols [points]."""
_SIDES = 10
_FINE_SPHERES = 300  # number of contacts above which they are coarser


@dataclass(frozen=True, slots=True)
class Solid:
    """``vertices`` (n, 3) [m], ``colours`` (n, 4) display values with opacity, ``triangles`` (m,
    3), ``smooth`` (m,)."""

    vertices: FloatArray
    colours: FloatArray
    triangles: Triangles
    smooth: BoolArray


def solid_graph(data: RenderData, unit: float) -> Solid:
    """All drawn elements of a frame except its labels, with a dark rim. ``unit``: metres per point
    of the overlay."""
    contacts, listeners, sources, impacts = (
        _chosen(data.points, shape)
        for shape in (Shape.CONTACT, Shape.LISTENER, Shape.SOURCE, Shape.IMPACT)
    )
    ball = sphere(2 if len(contacts.size) <= _FINE_SPHERES else 1)
    body = [
        tubes(_thinned(data.tree), unit),
        tubes(data.paths, unit),
        _copies(ball, contacts, unit, smooth=True),
        _listeners(listeners, unit),
        _copies(sphere(3), sources, 0.62 * unit, smooth=True),
        _copies(three_rings(0.92, 0.08), sources, unit, smooth=True),
        _copies(spiked_ball(), impacts, unit, smooth=False),
    ]
    shells = [
        tubes(_thickened(_thinned(data.tree), RIM / 2), unit),
        tubes(_thickened(data.paths, RIM), unit),
        _copies(ball, _grown(contacts, RIM), unit, smooth=True),
        _copies(octahedron(), _grown(listeners, 1.7 * RIM), unit, smooth=False),
        _copies(sphere(3), _grown(sources, RIM), unit, smooth=True),
        _copies(spiked_ball(), _grown(impacts, 1.5 * RIM), unit, smooth=False),
    ]
    return joined([*(_rim(shell) for shell in shells), *body])


def _rim(shell: Solid) -> Solid:
    """An inverted dark shell: because back faces are not drawn, only a rim is visible around its
    content."""
    colours = np.broadcast_to([*HALO_COLOUR, 1.0], shell.colours.shape)
    return Solid(shell.vertices, colours, shell.triangles[:, ::-1], shell.smooth)


def _thinned(lines: Lines) -> Lines:
    """Lines whose width is multiplied by their opacity."""
    return replace(lines, width=lines.width * lines.colour[:, :, 3].mean(axis=1))


def _thickened(lines: Lines, by: float) -> Lines:
    return replace(lines, width=lines.width + 2 * by)


def _grown(points: Points, by: float) -> Points:
    return replace(points, size=points.size + 2 * by)


def seen_unit(data: RenderData, projection: FloatArray, view: FloatArray, height: float) -> float:
    """Metres per point at which the graph looks as thick as the overlay in a picture of ``height``
    points, at the middle of its depth."""
    position = np.column_stack([data.points.position, np.ones(len(data.points.size))])
    depth = (position @ (projection @ view).T)[:, 3]
    seen = depth[depth > 0]
    return 2 * float(np.median(seen) if len(seen) else 1.0) / (projection[1, 1] * height)


def extent_unit(data: RenderData) -> float:
    """Metres per point at which the graph looks as in a viewport that it fills."""
    position = data.points.position
    diagonal = float(np.linalg.norm(np.ptp(position, axis=0))) if len(position) else 0.0
    return max(diagonal, 0.1) / 900


def joined(solids: list[Solid]) -> Solid:
    """Several solids as one."""
    offsets = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate([solid.colours for solid in solids]),
        np.concatenate(
            [solid.triangles + offset for solid, offset in zip(solids, offsets[:-1], strict=True)]
        ),
        np.concatenate([solid.smooth for solid in solids]),
    )


def tubes(lines: Lines, unit: float) -> Solid:
    """Lines as open tubes, without those of length 0."""
    long = (lines.position[:, 0] != lines.position[:, 1]).any(axis=1)
    position = lines.position[long].astype(np.float64)
    radius = lines.width[long] * unit / 2
    along = position[:, 1] - position[:, 0]
    across, upward = _perpendicular(along)
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
    return Solid(
        vertices.reshape(-1, 3),
        _opaque(colours),
        triangles,
        np.ones(len(triangles), dtype=np.bool_),
    )


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


def _chosen(points: Points, shape: Shape) -> Points:
    chosen = points.shape == shape
    return Points(
        points.position[chosen], points.colour[chosen], points.size[chosen], points.shape[chosen]
    )


def _copies(
    form: tuple[FloatArray, Triangles], points: Points, unit: float, *, smooth: bool
) -> Solid:
    """``form`` of radius 1 at every point."""
    vertices, triangles = form
    count = len(points.size)
    placed = points.position[:, None, :] + (points.size * unit / 2)[:, None, None] * vertices
    numbered = (len(vertices) * np.arange(count)[:, None, None] + triangles).reshape(-1, 3)
    colours = np.repeat(points.colour[:, :3], len(vertices), axis=0)
    return Solid(placed.reshape(-1, 3), _opaque(colours), numbered, np.full(len(numbered), smooth))


def _listeners(points: Points, unit: float) -> Solid:
    """Diamonds with white edges."""
    vertices, triangles = octahedron()
    edges = np.array(
        sorted({tuple(sorted((int(t[i]), int(t[i - 1])))) for t in triangles for i in range(3)})
    )
    corners = points.position[:, None, :] + (points.size * unit / 2)[:, None, None] * vertices
    ends, joints = corners[:, edges].reshape(-1, 2, 3), corners.reshape(-1, 3)
    thickness = np.float32(0.11) * points.size
    bars = lines_of(ends, WHITE, 1.0, np.repeat(thickness, len(edges)))
    balls = points_of(joints, WHITE, 1.0, np.repeat(thickness, len(vertices)), Shape.LISTENER)
    diamonds = _copies((vertices, triangles), points, unit, smooth=False)
    return joined([diamonds, tubes(bars, unit), _copies(sphere(1), balls, unit, smooth=True)])


def flat(items: Hud, scale: float) -> Solid:
    """Plates, leaders and symbols of labels and legend as flat shapes, in pixels; every later one
    lies a little higher. ``scale``: pixels per point."""
    shapes: list[tuple[FloatArray, FloatArray]] = []
    lines = items.lines
    for (start, end), colour, width, shape in zip(
        lines.position[:, :, :2], lines.colour, lines.width * scale, lines.shape, strict=True
    ):
        outline = (
            _rounded(start, end, width / 2) if shape == Shape.PLATE else _bar(start, end, width)
        )
        part = np.clip((outline[:, :1] - start[0]) / max(end[0] - start[0], 1e-9), 0, 1)
        shapes.append((outline, colour[0] + part * (colour[1] - colour[0])))
    points = items.points
    for centre, colour, size, shape in zip(
        points.position[:, :2], points.colour, points.size, points.shape, strict=True
    ):
        for inset, layer, opacity in layers(Shape(int(shape)), colour[:3]):
            outline = centre + (size / 2 - inset) * scale * _OUTLINES[Shape(int(shape))]
            shapes.append((outline, np.broadcast_to([*layer, opacity], (len(outline), 4))))
    height = 0.01 * scale
    return joined(
        [
            Solid(
                np.column_stack([outline, np.full(len(outline), k * height)]),
                np.asarray(colour, dtype=np.float64),
                np.array([(0, j, j + 1) for j in range(1, len(outline) - 1)], dtype=np.int64),
                np.zeros(len(outline) - 2, dtype=np.bool_),
            )
            for k, (outline, colour) in enumerate(shapes)
        ]
    )


def layers(shape: Shape, colour: FloatArray) -> tuple[tuple[float, FloatArray, float], ...]:
    """Layers of a symbol from the outside in: inset [points], colour, opacity, as in
    ``quads.frag.glsl``."""
    return {
        Shape.CONTACT: ((0.0, HALO_COLOUR, 0.9), (1.3, colour, 1.0)),
        Shape.SOURCE: (
            (0.0, HALO_COLOUR, 0.92),
            (1.5, colour, 1.0),
            (3.7, HALO_COLOUR, 1.0),
            (5.4, WHITE, 1.0),
            (7.0, colour, 1.0),
        ),
        Shape.IMPACT: ((0.0, HALO_COLOUR, 0.92), (1.8, WHITE, 1.0), (4.0, colour, 1.0)),
        Shape.LISTENER: ((0.0, HALO_COLOUR, 0.92), (1.9, WHITE, 1.0), (4.7, colour, 1.0)),
    }[shape]


def _ring(count: int, *radii: float) -> FloatArray:
    """Points (count, 2) on a circle, their distances alternating between ``radii``."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.resize(np.array(radii), count)[:, None] * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )


_OUTLINES = {
    Shape.CONTACT: _ring(24, 1.0),
    Shape.SOURCE: _ring(48, 1.0),
    Shape.IMPACT: _ring(16, 0.55, 1.0),
    Shape.LISTENER: _ring(4, 1.0),
}


def _rounded(low: FloatArray, high: FloatArray, radius: float) -> FloatArray:
    if radius <= 0:
        return np.array(
            [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])],
            dtype=np.float64,
        )
    quarter = np.linspace(0, np.pi / 2, 7)
    centres = (
        (high[0] - radius, high[1] - radius),
        (low[0] + radius, high[1] - radius),
        low + radius,
        (high[0] - radius, low[1] + radius),
    )
    return np.concatenate(
        [
            np.asarray(centre)
            + radius * np.column_stack([np.cos(quarter + turn), np.sin(quarter + turn)])
            for centre, turn in zip(centres, np.arange(4) * np.pi / 2, strict=True)
        ]
    )


def _bar(start: FloatArray, end: FloatArray, width: float) -> FloatArray:
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    across = np.array([-along[1], along[0]]) * width / 2
    return np.array([start - across, end - across, end + across, start + across], dtype=np.float64)


def octahedron() -> tuple[FloatArray, Triangles]:
    """Six corners at distance 1."""
    vertices = np.array(
        [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=np.float64
    )
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    return vertices, np.array(faces, dtype=np.int64)


def sphere(subdivisions: int) -> tuple[FloatArray, Triangles]:
    """An octahedron whose faces are split in four ``subdivisions`` times, its corners at distance
    1."""
    vertices, triangles = octahedron()
    for _ in range(subdivisions):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        unique, number = np.unique(edges, axis=0, return_inverse=True)
        middle = vertices[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        a, b, c = triangles.T
        ab, bc, ca = (number.reshape(-1, 3) + len(vertices)).T
        triangles = np.concatenate(
            [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        vertices = np.concatenate([vertices, middle])
    return vertices, triangles


def torus(radius: float, thickness: float) -> tuple[FloatArray, Triangles]:
    """A ring around z: its circle has ``radius``, its tube the radius ``thickness``."""
    around, over = 40, 12
    u, v = np.meshgrid(
        np.linspace(0, 2 * np.pi, around, endpoint=False),
        np.linspace(0, 2 * np.pi, over, endpoint=False),
        indexing="ij",
    )
    away = radius + thickness * np.cos(v)
    vertices = np.stack(
        [away * np.cos(u), away * np.sin(u), thickness * np.sin(v)], axis=2
    ).reshape(-1, 3)
    i, j = (
        index.reshape(-1)
        for index in np.meshgrid(np.arange(around), np.arange(over), indexing="ij")
    )
    next_i, next_j = (i + 1) % around, (j + 1) % over
    a, b, c, d = i * over + j, next_i * over + j, next_i * over + next_j, i * over + next_j
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def three_rings(radius: float, thickness: float) -> tuple[FloatArray, Triangles]:
    """Rings around x, y and z, which look like a circle from every direction."""
    vertices, triangles = torus(radius, thickness)
    return (
        np.concatenate([np.roll(vertices, turn, axis=1) for turn in range(3)]),
        np.concatenate([triangles + turn * len(vertices) for turn in range(3)]),
    )


def spiked_ball() -> tuple[FloatArray, Triangles]:
    """A ball with a spike on each of its 32 faces."""
    vertices, triangles = sphere(1)
    tips = vertices[triangles].sum(axis=1)
    tips /= np.linalg.norm(tips, axis=1, keepdims=True)
    numbers = len(vertices) + np.arange(len(tips))
    a, b, c = triangles.T
    faces = np.concatenate(
        [
            np.stack([a, b, numbers], axis=1),
            np.stack([b, c, numbers], axis=1),
            np.stack([c, a, numbers], axis=1),
        ]
    )
    return np.concatenate([0.5 * vertices, tips]), faces
