"""Random pairs of shapes and what Bullet says of them, through PyBullet.

``python bullet_pairs.py`` records ``bullet_pairs.npz``, which the tests read, so that they need no
PyBullet (it has no wheels and takes minutes to compile). With PyBullet installed (extra ``bullet``)
the tests also ask it about pairs that are not in the record.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    ConvexHull,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
    rotation_matrix,
)
from haptic_tracing.core.scene.values import Pose

RECORDED = Path(__file__).with_name("bullet_pairs.npz")

REACH = 0.05
"""Metres up to which Bullet is asked for distances."""

MARGIN = 0.001
"""PyBullet's margin in metres: within boxes and cylinders, around hulls and meshes, there but not
towards spheres."""


def _ball_points(count: int, seed: int) -> np.ndarray:
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1)[:, None] * [0.5, 0.4, 0.3]


def _ring(radius: float, z: float, count: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, z)], axis=1)


def _terrain() -> Mesh:
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    z = 0.15 * np.sin(2.5 * x) * np.cos(2 * y)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    index = np.arange(81).reshape(9, 9)
    a, b, c, d = (
        part.reshape(-1)
        for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    )
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(points, triangles, margin=MARGIN, sphere_margin=0.0)


SHAPES: dict[str, Shape] = {
    "box": Box((1.0, 0.6, 0.4), rounding=MARGIN),
    "plank": Box((1.6, 0.3, 0.05), rounding=MARGIN),
    "sphere": Sphere(0.4),
    "capsule": Capsule(0.2, 0.7),
    "cylinder": Cylinder(0.35, 0.6, rounding=MARGIN),
    "pyramid": ConvexHull(
        np.concatenate([_ring(0.4, -0.35, 12), [[0.0, 0.0, 0.35]]]), margin=MARGIN
    ),
    "hull": ConvexHull(_ball_points(24, 3), margin=MARGIN),
    "compound": Compound.of(
        (
            (Box((0.8, 0.2, 0.2), rounding=MARGIN), Pose((0.0, 0.0, 0.3))),
            (Sphere(0.25), Pose((0.0, 0.3, -0.2))),
            (Box((0.2, 0.2, 0.6), rounding=MARGIN), Pose()),
        )
    ),
    "mesh": _terrain(),
}
"""The shapes compared. PyBullet has no cone: a hull with twelve sides stands in."""

PAIRS = [
    pair for pair in itertools.combinations_with_replacement(SHAPES, 2) if pair != ("mesh", "mesh")
]
"""All pairs but mesh on mesh, which Bullet does not collide."""


def matrices(poses: np.ndarray) -> np.ndarray:
    """Matrices (..., 4, 4) of poses (..., 7): position, quaternion (w, x, y, z)."""
    flat = poses.reshape(-1, 7).astype(np.float64)
    result = np.zeros((len(flat), 4, 4))
    for k, pose in enumerate(flat):
        result[k, :3, :3] = rotation_matrix(tuple(pose[3:] / np.linalg.norm(pose[3:])))
    result[:, :3, 3] = flat[:, :3]
    result[:, 3, 3] = 1.0
    return result.reshape(*poses.shape[:-1], 4, 4)


class Bullet:
    """A world of PyBullet with bodies that are only placed and asked."""

    def __init__(self) -> None:
        import pybullet

        self._bullet = pybullet
        self._client = pybullet.connect(pybullet.DIRECT)

    def close(self) -> None:
        self._bullet.disconnect(self._client)

    def body(self, shape: Shape) -> int:
        """A body of a shape at the origin."""
        return int(
            self._bullet.createMultiBody(0, self._shape(shape), physicsClientId=self._client)
        )

    def _shape(self, shape: Shape) -> int:
        p = self._bullet
        if not isinstance(shape, Compound):
            return int(p.createCollisionShape(physicsClientId=self._client, **self._form(shape)))
        forms = [self._form(part) for part in shape.parts]
        return int(
            p.createCollisionShapeArray(
                shapeTypes=[form.pop("shapeType") for form in forms],
                halfExtents=[form.get("halfExtents", [1, 1, 1]) for form in forms],
                radii=[form.get("radius", 1) for form in forms],
                collisionFramePositions=shape.poses[:, :3].tolist(),
                physicsClientId=self._client,
            )
        )

    def _form(self, shape: Shape) -> dict:
        p = self._bullet
        match shape:
            case Box(size=size):
                return {"shapeType": p.GEOM_BOX, "halfExtents": [s / 2 for s in size]}
            case Sphere(radius=radius):
                return {"shapeType": p.GEOM_SPHERE, "radius": radius}
            case Capsule(radius=radius, height=height):
                return {"shapeType": p.GEOM_CAPSULE, "radius": radius, "height": height}
            case Cylinder(radius=radius, height=height):
                return {"shapeType": p.GEOM_CYLINDER, "radius": radius, "height": height}
            case ConvexHull(points=points):
                return {"shapeType": p.GEOM_MESH, "vertices": points.tolist()}
            case Mesh(points=points, triangles=triangles):
                flags = p.GEOM_FORCE_CONCAVE_TRIMESH
                indices = triangles.reshape(-1).tolist()
                return {
                    "shapeType": p.GEOM_MESH,
                    "vertices": points.tolist(),
                    "indices": indices,
                    "flags": flags,
                }
        raise TypeError(shape)

    def place(self, body: int, pose: np.ndarray) -> None:
        x, y, z, qw, qx, qy, qz = (float(v) for v in pose)
        length = float(np.linalg.norm(pose[3:].astype(np.float64)))
        turn = [q / length for q in (qx, qy, qz, qw)]
        self._bullet.resetBasePositionAndOrientation(
            body, [x, y, z], turn, physicsClientId=self._client
        )

    def closest(self, a: int, b: int, reach: float = REACH) -> tuple[float, np.ndarray] | None:
        """Least signed distance of two bodies and the points (k, 3), midway between the surfaces,
        at which it is reached within 0.1 mm."""
        found = self._bullet.getClosestPoints(a, b, reach, physicsClientId=self._client)
        if not found:
            return None
        distances = np.array([f[8] for f in found])
        middles = np.array([(np.array(f[5]) + np.array(f[6])) / 2 for f in found])
        return float(distances.min()), middles[distances <= distances.min() + 1e-4]


def near_pairs(
    bullet: Bullet, a: int, b: int, generator: np.random.Generator, count: int
) -> np.ndarray:
    """Poses (count, 2, 7) of pairs whose distance lies between -35 and +35 mm, half of them within
    a few of 10 mm. float32, so that the record is exactly what Bullet was asked."""
    chosen: list[np.ndarray] = []
    while len(chosen) < count:
        poses = np.concatenate([np.zeros((2, 3)), generator.normal(size=(2, 4))], axis=1).astype(
            np.float32
        )
        poses[0, :3] = generator.normal(size=3)
        direction = generator.normal(size=3)
        direction /= np.linalg.norm(direction)
        goal = (
            generator.uniform(-0.03, 0.03)
            if generator.random() < 0.5
            else generator.normal(0.01, 0.003)
        )
        # Slide the second along a line until it is as far from the first as wanted.
        away, distance = 2.5, np.inf
        bullet.place(a, poses[0])
        for _ in range(40):
            poses[1, :3] = poses[0, :3] + direction * away
            bullet.place(b, poses[1])
            found = bullet.closest(a, b, 3.0)
            if found is None or away < 0:
                break
            distance = found[0]
            if abs(distance - goal) < 1e-3:
                break
            away -= 0.7 * (distance - goal)
        if abs(distance - goal) < 5e-3 and abs(distance) < 0.035:
            chosen.append(poses)
    return np.array(chosen)


def asked(seed: int, count: int) -> dict[str, np.ndarray]:
    """For every pair of shapes: poses, Bullet's distances and its points (padded with NaN to
    four)."""
    generator = np.random.default_rng(seed)
    bullet = Bullet()
    answers = {}
    for name_a, name_b in PAIRS:
        a, b = bullet.body(SHAPES[name_a]), bullet.body(SHAPES[name_b])
        poses = near_pairs(bullet, a, b, generator, count)
        distance = np.empty(count)
        points = np.full((count, 4, 3), np.nan, dtype=np.float32)
        for k, (first, second) in enumerate(poses):
            bullet.place(a, first)
            bullet.place(b, second)
            found = bullet.closest(a, b)
            assert found is not None
            distance[k] = found[0]
            points[k, : len(found[1])] = found[1][:4]
        answers[f"{name_a} {name_b} poses"] = poses
        answers[f"{name_a} {name_b} distance"] = distance
        answers[f"{name_a} {name_b} points"] = points
    bullet.close()
    return answers


PILE = [name for name in SHAPES if name not in ("plank", "mesh")] * 6
"""Bodies of a pile, by shape; under them lies a ground."""

GROUND = Box((20.0, 20.0, 2.0), rounding=MARGIN)


def pile(seed: int, snapshots: int = 8) -> dict[str, np.ndarray]:
    """A simulated pile, every half second: poses (snapshots, bodies, 7), the ground first, and all
    pairs of bodies nearer than ``REACH`` as rows (snapshot, first, second, distance)."""
    import pybullet as p

    generator = np.random.default_rng(seed)
    bullet = Bullet()
    client = bullet._client
    p.setGravity(0, 0, -9.81, physicsClientId=client)
    bodies = [
        int(
            p.createMultiBody(
                0, bullet._shape(GROUND), basePosition=[0, 0, -1], physicsClientId=client
            )
        )
    ]
    for k, name in enumerate(PILE):
        place = [*(generator.uniform(-0.9, 0.9, 2)), 0.8 + 0.5 * k]
        turn = generator.normal(size=4)
        turn = (turn / np.linalg.norm(turn)).tolist()
        shape = bullet._shape(SHAPES[name])
        bodies.append(
            int(
                p.createMultiBody(
                    10, shape, basePosition=place, baseOrientation=turn, physicsClientId=client
                )
            )
        )
    poses = np.zeros((snapshots, len(bodies), 7), dtype=np.float32)
    rows = []
    for snapshot in range(snapshots):
        for _ in range(120):
            p.stepSimulation(physicsClientId=client)
        for k, body in enumerate(bodies):
            place, (x, y, z, w) = p.getBasePositionAndOrientation(body, physicsClientId=client)
            poses[snapshot, k] = (*place, w, x, y, z)
        kept = [
            (
                p.getBasePositionAndOrientation(b, physicsClientId=client),
                p.getBaseVelocity(b, physicsClientId=client),
            )
            for b in bodies
        ]
        for k, body in enumerate(bodies):
            bullet.place(body, poses[snapshot, k])
        for i, a in enumerate(bodies):
            for j in range(i + 1, len(bodies)):
                found = bullet.closest(a, bodies[j])
                if found is not None:
                    rows.append((snapshot, i, j, found[0]))
        for body, ((place, turn), (linear, angular)) in zip(bodies, kept, strict=True):
            p.resetBasePositionAndOrientation(body, place, turn, physicsClientId=client)
            p.resetBaseVelocity(body, linear, angular, physicsClientId=client)
    bullet.close()
    return {"pile poses": poses, "pile pairs": np.array(rows)}


if __name__ == "__main__":
    np.savez_compressed(RECORDED, **asked(seed=1, count=200), **pile(seed=1))
