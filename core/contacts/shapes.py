"""Collision shapes as values: a core with its origin at the body's origin, grown by a margin.

Round shapes stand along local z and are centred at half their height, the cone too (base at
``-height / 2``, tip at ``+height / 2``). A shape with margin m is its core and every point within m
metres of it: the margin lies outside and rounds edges.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..scene.values import Pose, Vector

MAX_TRIANGLES = 500_000
"""Largest collision mesh; a larger one collides as its hull."""


def _length(key: str, value: float, positive: bool = False) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
        raise ValueError(f"{key}: expected a number, got {value!r}")
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{key}: must be finite and >= 0 m, got {float(value)!r}")
    if positive and value == 0:
        raise ValueError(f"{key}: must be greater than 0 m")
    return float(value)


def points_array(key: str, value: ArrayLike) -> FloatArray:
    """``value`` as a read-only array (n, 3) of finite numbers, n > 0. Raises ValueError that begins
    with ``key``."""
    try:
        points = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{key}: expected a list of points of three numbers") from None
    if points.size == 0:
        raise ValueError(f"{key}: there are none")
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(
            f"{key}: expected a list of points of three numbers, got an array of shape "
            f"{points.shape}"
        )
    if not np.isfinite(points).all():
        raise ValueError(
            f"{key}: point {int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])} is not finite"
        )
    points.setflags(write=False)
    return points


def rotation_matrix(rotation: ArrayLike) -> FloatArray:
    """The matrices (n, 3, 3) of unit quaternions (n, 4), or that of one: w, x, y, z."""
    w, x, y, z = np.asarray(rotation, dtype=np.float64).T
    x2, y2, z2 = 2 * x, 2 * y, 2 * z
    xx, yy, zz = x * x2, y * y2, z * z2
    xy, xz, yz = x * y2, x * z2, y * z2
    wx, wy, wz = w * x2, w * y2, w * z2
    columns = [
        [1 - (yy + zz), xy + wz, xz - wy],
        [xy - wz, 1 - (xx + zz), yz + wx],
        [xz + wy, yz - wx, 1 - (xx + yy)],
    ]
    return np.array(columns).T


def quaternions(turns: FloatArray) -> FloatArray:
    """The unit quaternions (n, 4) of rotation matrices (n, 3, 3), w >= 0: of the products of the
    components of each, the row with the largest square."""
    transposed = turns.transpose(0, 2, 1)
    trace = turns.trace(axis1=1, axis2=2)
    products = np.empty((len(turns), 4, 4))
    products[:, 0, 0] = 1 + trace
    products[:, 0, 1:] = products[:, 1:, 0] = (transposed - turns)[:, (1, 2, 0), (2, 0, 1)]
    products[:, 1:, 1:] = turns + transposed + (1 - trace)[:, None, None] * np.eye(3)
    largest = products.diagonal(axis1=1, axis2=2).argmax(axis=1)
    rows: FloatArray = products[np.arange(len(turns)), largest]
    rows /= np.copysign(np.linalg.norm(rows, axis=1), rows[:, 0])[:, None]
    return rows


def pose_matrix(pose: Pose) -> FloatArray:
    """The rigid (4, 4) matrix of a pose: local to world, columns are the axes."""
    matrix: FloatArray = pose_matrices(np.array([(*pose.position, *pose.rotation)]))[0]
    return matrix


def pose_matrices(poses: FloatArray) -> FloatArray:
    """`pose_matrix` of several poses (n, 7), each a position and a unit quaternion: (n, 4, 4)."""
    matrices = np.zeros((len(poses), 4, 4))
    matrices[:, :3, :3] = rotation_matrix(poses[:, 3:])
    matrices[:, :3, 3] = poses[:, :3]
    matrices[:, 3, 3] = 1.0
    return matrices


@dataclass(frozen=True)  # without slots: what is computed of a shape is kept with it
class Shape:
    """Base of all shapes: values, hashable and compared by content. Every field of type float is a
    length; those named in ``positive`` are greater than 0."""

    type: ClassVar[str] = ""
    positive: ClassVar[frozenset[str]] = frozenset({"radius", "height"})

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.type == "float":
                object.__setattr__(
                    self,
                    item.name,
                    _length(item.name, getattr(self, item.name), item.name in self.positive),
                )

    @property
    def margin(self) -> float:
        """Metres by which the core is grown."""
        raise NotImplementedError

    def core_bounds(self) -> FloatArray:
        """(2, 3) lowest and highest corner of the core's bounding box in local space."""
        half = np.array(self.half())
        return np.array([-half, half])

    def half(self) -> ArrayLike:
        """(3,) half extents of a core that is centred."""
        raise NotImplementedError

    @cached_property
    def local_bounds(self) -> FloatArray:
        """(2, 3) lowest and highest corner of the bounding box in local space, margin included.
        Read-only."""
        bounds: FloatArray = self.core_bounds() + np.array([[-self.margin], [self.margin]])
        bounds.setflags(write=False)
        return bounds

    def to_dict(self) -> dict[str, Any]:
        """The JSON form in scene files, without what has its default."""
        form: dict[str, Any] = {"type": self.type}
        for item in fields(self):
            value = getattr(self, item.name)
            if item.default is MISSING or value != item.default:
                form[item.name] = (
                    value.tolist()
                    if isinstance(value, np.ndarray)
                    else list(value)
                    if isinstance(value, tuple)
                    else value
                )
        return form


@frozen
class Box(Shape):
    """``size`` (x, y, z) in metres. ``rounding`` is the radius of its edges within that size
    (Bullet's embedded margin), used against all shapes but boxes: two boxes meet with sharp edges.
    A box thinner than twice its rounding is thin and sharp, but has that thickness against a
    mesh."""

    type: ClassVar[str] = "box"
    size: Vector
    margin: float = 0.0
    rounding: float = 0.0

    def __post_init__(self) -> None:
        try:
            x, y, z = self.size
        except (TypeError, ValueError):
            raise ValueError(f"size: expected three lengths, got {self.size!r}") from None
        object.__setattr__(
            self, "size", tuple(_length("size", length, True) for length in (x, y, z))
        )
        Shape.__post_init__(self)

    def half(self) -> ArrayLike:
        return np.maximum(np.array(self.size) / 2, self.rounding)


@frozen
class Sphere(Shape):
    """``radius`` in metres."""

    type: ClassVar[str] = "sphere"
    radius: float
    margin: float = 0.0

    def half(self) -> ArrayLike:
        return [self.radius] * 3


@frozen
class _Upright(Shape):
    """Base of shapes around local z. ``radius`` and ``height`` in metres."""

    radius: float
    height: float
    margin: float = 0.0

    def half(self) -> ArrayLike:
        return [self.radius, self.radius, self.height / 2]


@frozen
class Capsule(_Upright):
    """``radius`` and ``height`` of the cylindrical part, in metres (height 0 is a sphere)."""

    type: ClassVar[str] = "capsule"
    positive: ClassVar[frozenset[str]] = frozenset({"radius"})

    def half(self) -> ArrayLike:
        return [self.radius, self.radius, self.height / 2 + self.radius]


@frozen
class Cylinder(_Upright):
    """``radius`` and ``height`` in metres. ``rounding`` is the radius of its edges within that size
    (Bullet's embedded margin)."""

    type: ClassVar[str] = "cylinder"
    rounding: float = 0.0

    def __post_init__(self) -> None:
        Shape.__post_init__(self)
        object.__setattr__(self, "rounding", min(self.rounding, self.radius, self.height / 2))


@frozen
class Cone(_Upright):
    """``radius`` of the base and ``height`` in metres. The base lies at ``z = -height / 2``, the
    tip at ``z = +height / 2``."""

    type: ClassVar[str] = "cone"


class _PointShape(Shape):
    """Base of shapes with arrays, compared by their values."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or all(
            np.array_equal(mine, theirs) if isinstance(mine, np.ndarray) else mine == theirs
            for mine, theirs in (
                (getattr(self, item.name), getattr(other, item.name)) for item in fields(self)
            )
        )

    def __hash__(self) -> int:
        values = [getattr(self, item.name) for item in fields(self)]
        return hash(
            (
                self.type,
                *(value.tobytes() if isinstance(value, np.ndarray) else value for value in values),
            )
        )


@frozen(eq=False)
class ConvexHull(_PointShape):
    """The convex hull of ``points`` (n, 3) in metres, which may lie in one plane or on one line,
    but not all in one place. ``rounding`` is the radius of its edges within that hull (Bullet's
    embedded margin); where it is thinner than that, it stays sharp. With ``sunk_in`` it stands for
    a closed surface, inside which bodies touch it down to that depth [m], as for a `Mesh`."""

    type: ClassVar[str] = "convex_hull"
    points: FloatArray
    margin: float = 0.0
    rounding: float = 0.0
    sunk_in: float | None = None

    def __post_init__(self) -> None:
        points = points_array("points", self.points)
        if not np.ptp(points, axis=0).any():
            raise ValueError("points: they all lie in one place")
        object.__setattr__(self, "points", points)
        Shape.__post_init__(self)
        if self.sunk_in is not None:
            object.__setattr__(self, "sunk_in", _length("sunk_in", self.sunk_in))

    def core_bounds(self) -> FloatArray:
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])


@frozen(eq=False)
class Mesh(_PointShape):
    """A surface of ``triangles`` (t, 3), indices into ``points`` (n, 3) in metres.
    ``sphere_margin`` is its margin where the other shape is a sphere (0 in Bullet), None the same
    as for all.

    With ``sunk_in`` 0 it is a shell: what touches it touches a triangle. Otherwise it is a solid,
    closed and counter-clockwise seen from outside: what crosses its surface, or lies inside at most
    ``sunk_in`` metres beneath it (or half the smallest extent of the smaller body, if that is
    less), touches it."""

    type: ClassVar[str] = "mesh"
    points: FloatArray
    triangles: IntArray
    margin: float = 0.0
    sphere_margin: float | None = None
    sunk_in: float = 0.0

    def __post_init__(self) -> None:
        points = points_array("points", self.points)
        triangles = np.array(self.triangles)
        if triangles.size == 0:
            raise ValueError("triangles: there are none")
        if (
            triangles.dtype.kind == "f" and (triangles == np.rint(triangles)).all()
        ):  # 3.0 is an integer in JSON Schema
            triangles = triangles.astype(np.int64)
        if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
            raise ValueError("triangles: expected a list of three indices each")
        if len(triangles) > MAX_TRIANGLES:
            raise ValueError(
                f"triangles: {len(triangles):,} are more than the {MAX_TRIANGLES:,} that a "
                "collision mesh can have"
            )
        if np.min(triangles) < 0 or np.max(triangles) >= len(points):
            worst = int(
                np.flatnonzero(
                    (triangles < 0).any(axis=1) | (triangles >= len(points)).any(axis=1)
                )[0]
            )
            raise ValueError(f"triangles: triangle {worst} refers to a point that is not there")
        triangles = triangles.astype(np.int64)
        triangles.setflags(write=False)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "triangles", triangles)
        Shape.__post_init__(self)
        if self.sphere_margin is not None:
            object.__setattr__(self, "sphere_margin", _length("sphere_margin", self.sphere_margin))

    def core_bounds(self) -> FloatArray:
        used = np.zeros(len(self.points), dtype=np.bool_)
        used[self.triangles] = True
        corners = self.points[used]
        return np.array([corners.min(axis=0), corners.max(axis=0)])


@frozen(eq=False)
class Compound(_PointShape):
    """``parts`` at ``poses`` (n, 7) in the local space of the body, each a position [m] and a unit
    quaternion w, x, y, z. ``margin`` adds to that of every part."""

    type: ClassVar[str] = "compound"
    parts: tuple[Shape, ...]
    poses: FloatArray
    margin: float = 0.0

    def __post_init__(self) -> None:
        self.poses.setflags(write=False)
        Shape.__post_init__(self)

    @classmethod
    def of(cls, children: Iterable[tuple[Shape, Pose]], margin: float = 0.0) -> Compound:
        """Shapes at poses."""
        children = tuple(children)
        if not children:
            raise ValueError("children: there are none")
        parts, poses = zip(*children, strict=True)
        return cls(parts, np.array([(*pose.position, *pose.rotation) for pose in poses]), margin)

    def posed(self, poses: FloatArray) -> Compound:
        """The same parts at other poses (n, 7)."""
        moved = Compound(self.parts, poses, self.margin)
        vars(moved)["part_bounds"] = self.part_bounds
        return moved

    @cached_property
    def part_bounds(self) -> FloatArray:
        """The local bounds (n, 2, 3) of the parts."""
        return np.array([part.local_bounds for part in self.parts])

    @cached_property
    def places(self) -> FloatArray:
        """The rigid transforms (n, 4, 4) of the parts into the body's space; read-only."""
        matrices = pose_matrices(self.poses)
        matrices.setflags(write=False)
        return matrices

    def core_bounds(self) -> FloatArray:
        bounds = transformed_bounds(self.part_bounds, self.places)
        return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])

    def to_dict(self) -> dict[str, Any]:
        children = [
            {**part.to_dict(), "pose": {"position": pose[:3], "rotation": pose[3:]}}
            for part, pose in zip(self.parts, self.poses.tolist(), strict=True)
        ]
        margin = {"margin": self.margin} if self.margin else {}
        return {"type": self.type, "children": children, **margin}


def transformed_bounds(bounds: FloatArray, matrices: FloatArray) -> FloatArray:
    """World bounding boxes (..., 2, 3) of local ones (..., 2, 3) under rigid ``matrices`` (..., 4,
    4)."""
    centre = (bounds[..., 0, :] + bounds[..., 1, :]) / 2
    half = (bounds[..., 1, :] - bounds[..., 0, :]) / 2
    rotation = matrices[..., :3, :3]
    world_centre = np.einsum("...ij,...j->...i", rotation, centre) + matrices[..., :3, 3]
    world_half = np.einsum("...ij,...j->...i", np.abs(rotation), half)
    return np.stack([world_centre - world_half, world_centre + world_half], axis=-2)


SHAPES: dict[str, type[Shape]] = {
    cls.type: cls for cls in (Box, Sphere, Capsule, Cylinder, Cone, ConvexHull, Mesh, Compound)
}


def shape_from_dict(form: Mapping[str, Any]) -> Shape:
    """The shape of a scene file's ``{"type": name, ...}``, whose keys the schema of scenes allows.
    The children of a compound are such forms with a ``pose`` beside.

    Raises ValueError that begins with the key (``children/0/radius: ...`` inside a compound) for a
    value out of range.
    """
    values = {key: value for key, value in form.items() if key not in ("type", "pose")}
    if "children" in values:
        values["children"] = [_child(*item) for item in enumerate(values["children"])]
        return Compound.of(**values)
    return SHAPES[form["type"]](**values)


def _child(index: int, form: Mapping[str, Any]) -> tuple[Shape, Pose]:
    try:
        return shape_from_dict(form), Pose(**form.get("pose", {}))
    except ValueError as error:
        raise ValueError(f"children/{index}/{error}") from None


@frozen
class Primitive:
    """A primitive of a shape in the body's local space: ``shape`` (never a compound) under the
    rigid ``matrix`` (4, 4), its core grown by ``radius`` metres in all (its own margin and those of
    the compounds it is in)."""

    shape: Shape
    matrix: FloatArray
    radius: float


def places_of(shape: Compound) -> FloatArray:
    """The matrices (n, 4, 4) of the `parts_of` a compound."""
    if Compound in map(type, shape.parts):
        return np.array([part.matrix for part in parts_of(shape)])
    return shape.places


def parts_of(shape: Shape) -> tuple[Primitive, ...]:
    """The primitives that a shape is made of, compounds resolved."""
    if not isinstance(shape, Compound):
        return (Primitive(shape, np.eye(4), shape.margin),)
    return tuple(
        Primitive(part.shape, place @ part.matrix, part.radius + shape.margin)
        for child, place in zip(shape.parts, shape.places, strict=True)
        for part in parts_of(child)
    )
