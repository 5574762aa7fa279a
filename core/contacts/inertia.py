"""Volumes, centres of mass and moments of inertia of shapes of constant density."""

from __future__ import annotations

import math
from dataclasses import field

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .hull import convex_hull
from .shapes import Capsule, Compound, Cone, ConvexHull, Cylinder, Mesh, Shape, Sphere
from .surface_shape import is_closed

_THIN = 1e-3
"""Part of the volume of its bounding box below which a body counts as flat."""


@frozen(eq=False)
class Inertia:
    """``volume`` [m^3], ``centre`` (3,) of mass [m], ``moment`` (3, 3) of inertia about it per
    kilogram [m^2], and its ``inverse``, in a body's own space."""

    volume: float
    centre: FloatArray
    moment: FloatArray
    inverse: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "inverse", np.linalg.pinv(self.moment, hermitian=True))


def inertia_of(shape: Shape) -> Inertia:
    """The inertia of a shape; of an open or a flat surface that of its bounding box. It is kept
    with the shape."""
    known: dict[str, Inertia] = vars(shape)
    if "inertia" not in known:
        known["inertia"] = _inertia(shape)
    return known["inertia"]


def _inertia(shape: Shape) -> Inertia:
    match shape:
        case Sphere():
            r = shape.radius + shape.margin
            return _of_squares(4 / 3 * math.pi * r**3, (r * r / 5,) * 3)
        case Capsule():
            return _of_capsule(shape.radius + shape.margin, shape.height)
        case Cylinder():
            r, h = shape.radius + shape.margin, shape.height + 2 * shape.margin
            return _of_squares(math.pi * r * r * h, (r * r / 4, r * r / 4, h * h / 12))
        case Cone():
            r, h = shape.radius, shape.height
            squares = 3 / 20 * r * r, 3 / 20 * r * r, 3 / 80 * h * h
            return _of_squares(math.pi * r * r * h / 3, squares, (0.0, 0.0, -h / 4))
        case Compound():
            return _of_parts(shape)
        case ConvexHull():
            hull = convex_hull(shape.points)
            return _of_surface(hull.points[hull.triangles], shape)
        case Mesh() if shape.sunk_in or is_closed(shape.points, shape.triangles):
            return _of_surface(shape.points[shape.triangles], shape)
    return _of_box(shape)


def _of_squares(
    volume: float,
    squares: tuple[float, float, float],
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Inertia:
    """By the mean squares (3,) of the coordinates about the centre, along the shape's own axes."""
    return Inertia(volume, np.array(centre), np.diag(sum(squares) - np.array(squares)))


def _of_box(shape: Shape) -> Inertia:
    """Of the bounding box."""
    low, high = shape.local_bounds
    x, y, z = (high - low).tolist()
    a, b, c = ((low + high) / 2).tolist()
    return _of_squares(x * y * z, (x * x / 12, y * y / 12, z * z / 12), (a, b, c))


def _of_capsule(r: float, h: float) -> Inertia:
    """A cylinder of radius ``r`` and height ``h`` between two half balls, whose centres of mass lie
    3/8 r beyond its ends."""
    middle, ends = math.pi * r * r * h, 4 / 3 * math.pi * r**3
    across = (middle * r * r / 4 + ends * r * r / 5) / (middle + ends)
    along = middle * h * h / 12 + ends * (r * r / 5 + h * h / 4 + 3 / 8 * r * h)
    return _of_squares(middle + ends, (across, across, along / (middle + ends)))


def _of_surface(corners: FloatArray, shape: Shape) -> Inertia:
    """What a closed surface of triangles with these ``corners`` (t, 3, 3) encloses, as the sum of
    tetrahedra from one point to the triangles (Blow & Binstock 2004)."""
    origin = shape.local_bounds.mean(axis=0)
    corners = corners - origin
    six = np.linalg.det(corners)  # times the volume of each
    volume = six.sum() / 6
    low, high = shape.local_bounds
    if abs(volume) <= _THIN * np.prod(high - low):
        return _of_box(shape)
    sums = corners.sum(axis=1)
    centre = six @ sums / (24 * volume)
    products = np.einsum("t,tci,tcj->ij", six, corners, corners)
    products += np.einsum("t,ti,tj->ij", six, sums, sums)
    products = products / (120 * volume) - np.outer(centre, centre)
    moment = np.eye(3) * products.trace() - products
    return Inertia(abs(float(volume)), centre + origin, moment)


def _of_parts(shape: Compound) -> Inertia:
    """Of parts of one density, as if none overlapped."""
    parts = [inertia_of(part) for part in shape.parts]
    turns = shape.places[:, :3, :3]
    centres = np.array([part.centre for part in parts])
    centres = np.einsum("nij,nj->ni", turns, centres) + shape.places[:, :3, 3]
    moments = turns @ np.array([part.moment for part in parts]) @ turns.swapaxes(1, 2)
    return joined(np.array([part.volume for part in parts]), centres, moments)


def joined(weights: FloatArray, centres: FloatArray, moments: FloatArray) -> Inertia:
    """Of bodies of these ``weights`` (n,), ``centres`` (n, 3) and ``moments`` (n, 3, 3) together;
    ``volume`` is the sum of the weights."""
    total = float(weights.sum())
    share = weights / total if total > 0 else np.full(len(weights), 1 / len(weights))
    centre = share @ centres
    arms = centres - centre
    squares = (arms * arms).sum(axis=1)[:, None, None]
    offsets = squares * np.eye(3) - arms[:, :, None] * arms[:, None]
    return Inertia(total, centre, np.einsum("n,nij->ij", share, moments + offsets))
