"""Distances of meshes by brute force over all pairs of triangles, and insides by solid angles;
concave meshes made by formulas."""

from __future__ import annotations

import numpy as np


def _to_segment(points, start, end):
    way = end - start
    along = np.clip(((points - start) * way).sum(-1) / (way * way).sum(-1), 0, 1)
    return np.linalg.norm(points - start - along[..., None] * way, axis=-1)


def _to_triangle(points, a, b, c):
    normal = np.cross(b - a, c - a)
    unit = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    height = ((points - a) * unit).sum(-1)
    foot = points - height[..., None] * unit
    inside = np.ones(height.shape, dtype=bool)
    edge = np.full(height.shape, np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(q - p, foot - p) * unit).sum(-1) >= 0
        edge = np.minimum(edge, _to_segment(points, p, q))
    return np.where(inside, np.abs(height), edge)


def _between_segments(p0, p1, q0, q1):
    """Least distance of the ends from the other segment, or that of the lines where it lies within
    both."""
    least = np.minimum.reduce(
        [
            _to_segment(p0, q0, q1),
            _to_segment(p1, q0, q1),
            _to_segment(q0, p0, p1),
            _to_segment(q1, p0, p1),
        ]
    )
    u, v, w = p1 - p0, q1 - q0, p0 - q0
    cross = np.cross(u, v)
    area = (cross * cross).sum(-1)
    safe = np.where(area > 1e-18, area, 1)
    s, t = (np.cross(v, w) * cross).sum(-1) / safe, (np.cross(u, w) * cross).sum(-1) / safe
    within = (area > 1e-18) & (s > 0) & (s < 1) & (t > 0) & (t < 1)
    return np.where(within, np.minimum(least, np.abs((w * cross).sum(-1)) / np.sqrt(safe)), least)


def _pierces(start, end, a, b, c):
    normal = np.cross(b - a, c - a)
    h0, h1 = ((start - a) * normal).sum(-1), ((end - a) * normal).sum(-1)
    share = h0 / np.where(h0 == h1, 1, h0 - h1)
    at = start + share[..., None] * (end - start)
    inside = h0 * h1 < 0
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(q - p, at - p) * normal).sum(-1) > 0
    return inside


def distance(first: np.ndarray, second: np.ndarray) -> float:
    """Least distance between two sets of triangles (n, 3, 3), 0 where any two cross."""
    low_a, high_a, low_b, high_b = first.min(1), first.max(1), second.min(1), second.max(1)
    gap = np.maximum(np.maximum(low_a[:, None] - high_b, low_b - high_a[:, None]), 0)
    bound = np.linalg.norm(gap, axis=-1)  # of the boxes around the triangles
    corners = first.reshape(-1, 3)[:, None] - second.reshape(-1, 3)
    rows, columns = np.nonzero(bound <= np.linalg.norm(corners, axis=-1).min())
    one, other = first[rows], second[columns]
    least = np.inf
    for a, b in ((one, other), (other, one)):
        for k in range(3):
            if _pierces(a[:, k], a[:, (k + 1) % 3], *b.transpose(1, 0, 2)).any():
                return 0.0
            least = min(least, _to_triangle(a[:, k], *b.transpose(1, 0, 2)).min())
    for i in range(3):
        for j in range(3):
            least = min(
                least,
                _between_segments(
                    one[:, i], one[:, (i + 1) % 3], other[:, j], other[:, (j + 1) % 3]
                ).min(),
            )
    return float(least)


def is_inside(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Which points (n, 3) a closed surface winds around: the sum of the triangles' solid angles
    (van Oosterom and Strackee 1983)."""
    a, b, c = (triangles[:, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = (a * np.cross(b, c)).sum(-1)
    divisor = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return 2 * np.arctan2(volume, divisor).sum(axis=1) > 2 * np.pi


def _grid(points: np.ndarray, wraps: bool) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, m, 3) closed along the second axis, and along the first if it ``wraps``; otherwise
    its ends are closed by fans."""
    n, m = points.shape[:2]
    index = np.arange(n * m).reshape(n, m)
    rows = np.arange(n if wraps else n - 1)
    a, b = index[rows], index[(rows + 1) % n]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    triangles = [
        np.stack([a, b, c], axis=-1).reshape(-1, 3),
        np.stack([a, c, d], axis=-1).reshape(-1, 3),
    ]
    points = points.reshape(-1, 3)
    if not wraps:
        for ring, flip in ((index[0], False), (index[-1], True)):
            fan = np.stack([np.full(m, len(points)), ring, np.roll(ring, -1)], axis=1)
            points = np.concatenate([points, points[ring].mean(0)[None]])
            triangles.append(fan[:, ::-1] if flip else fan)
    return points, np.concatenate(triangles)


def torus(
    large: float = 0.3, small: float = 0.1, n: int = 16, m: int = 8
) -> tuple[np.ndarray, np.ndarray]:
    """A ring around z."""
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    r = large + small * np.cos(v)
    return _outwards(
        *_grid(np.stack([r * np.cos(u), r * np.sin(u), small * np.sin(v)], axis=-1), True)
    )


def knot(n: int = 36, m: int = 6, radius: float = 0.06) -> tuple[np.ndarray, np.ndarray]:
    """A tube along a trefoil knot."""
    t = 2 * np.pi * np.arange(n) / n
    centre = 0.13 * np.stack(
        [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1
    )
    along = np.roll(centre, -1, axis=0) - np.roll(centre, 1, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, along)
    v = 2 * np.pi * np.arange(m) / m
    tube = centre[:, None] + radius * (
        np.cos(v)[:, None] * side[:, None] + np.sin(v)[:, None] * up[:, None]
    )
    return _outwards(*_grid(tube, True))


def turned(profile: list[tuple[float, float]], m: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A body of revolution around z, its outline given as radius and height."""
    v = 2 * np.pi * np.arange(m) / m
    r, z = np.array(profile).T
    points = np.stack(
        [r[:, None] * np.cos(v), r[:, None] * np.sin(v), np.broadcast_to(z[:, None], (len(r), m))],
        axis=-1,
    )
    return _outwards(*_grid(points, False))


def prism(outline: list[tuple[float, float]], height: float) -> tuple[np.ndarray, np.ndarray]:
    """A prism along z over an outline around a point from which all of it is seen, the origin."""
    flat = np.array(outline)
    rings = np.stack(
        [np.column_stack([flat, np.full(len(flat), z)]) for z in (-height / 2, height / 2)]
    )
    points, triangles = _grid(rings, False)
    points[-2:, :2] = 0
    return _outwards(points, triangles)


def star(n: int = 7) -> tuple[np.ndarray, np.ndarray]:
    """A gear with pointed teeth."""
    angle = np.pi * np.arange(2 * n) / n
    radius = np.where(np.arange(2 * n) % 2, 0.18, 0.35)
    return prism(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist(), 0.2)


def box(size: tuple[float, float, float], parts: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A box, its faces divided into squares."""
    side = np.linspace(-0.5, 0.5, parts + 1)
    u, v = (part.reshape(-1) for part in np.meshgrid(side, side, indexing="ij"))
    index = np.arange((parts + 1) ** 2).reshape(parts + 1, parts + 1)
    a, b, c, d = (
        part.reshape(-1)
        for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    )
    face = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    points, triangles = [], []
    for axis in range(3):
        for sign in (-0.5, 0.5):
            corners = np.empty((len(u), 3))
            corners[:, axis], corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = sign, u, v
            triangles.append((face if sign > 0 else face[:, ::-1]) + len(u) * len(points))
            points.append(corners)
    return np.concatenate(points) * size, np.concatenate(triangles)


def _outwards(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles counter-clockwise seen from outside."""
    volume = np.einsum(
        "ij,ij->",
        points[triangles[:, 0]],
        np.cross(points[triangles[:, 1]], points[triangles[:, 2]]),
    )
    return points, triangles if volume > 0 else triangles[:, ::-1]


CUP = [(0.2, -0.2), (0.25, 0.2), (0.2, 0.2), (0.16, -0.15), (0.05, -0.15)]
DUMBBELL = [
    (0.15, -0.35),
    (0.25, -0.25),
    (0.15, -0.15),
    (0.06, -0.1),
    (0.06, 0.1),
    (0.15, 0.15),
    (0.25, 0.25),
    (0.15, 0.35),
]

SOLIDS = {
    "torus": torus(),
    "knot": knot(),
    "cup": turned(CUP),
    "dumbbell": turned(DUMBBELL),
    "star": star(),
    "box": box((0.5, 0.3, 0.2), 2),
}
"""Closed meshes (points and triangles), most of them concave."""
