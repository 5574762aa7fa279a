"""Boxes, rods and hulls thrown onto a plane, simulated at 960 steps a second, with the exact times
of their blows.

In flight a body moves as a free rigid body does: its centre on a parabola, its turning with
constant angular momentum (midpoint rule). It meets the plane when its lowest corner does, found by
bisection; impulses on the corners (restitution, Coulomb friction) follow. Nothing of the product's
geometry or motion is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from haptic_tracing.core.contacts.shapes import Box, ConvexHull, Shape
from scipy.spatial import ConvexHull as Hull
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

RATE = 960
_STEP = 1 / RATE
_G = np.array([0.0, 0.0, -9.81])
_FRICTION = 0.4
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@dataclass(frozen=True)
class Thrown:
    """A body of ``mass`` [kg], its ``poses`` (k, 4, 4) at each step up to 0.1 s after its first
    blow, at ``time`` [s] with ``energy`` [J]: of the speed of the corner that lands, with the mass
    that is felt there; NaN where others are within 2 cm of the plane."""

    shape: Shape
    mass: float
    poses: np.ndarray
    time: float
    energy: float


def thrown(number: int) -> Thrown:
    """One of the bodies: by turns a box, a rod and a hull, of random size, mass, height, velocity
    and spin."""
    draw = np.random.default_rng(number)
    shape, corners = _shape(number % 3, draw)
    mass, height = draw.uniform(3, 40), draw.uniform(0.4, 4)
    turn = Rotation.random(random_state=number).as_matrix()
    centre = np.array([0.0, 0.0, height - (corners @ turn.T)[:, 2].min()])
    velocity = draw.uniform([-2, -2, -1], [2, 2, 1])
    way = draw.normal(size=3)
    spin = way * (draw.uniform(0.5, 10) / np.linalg.norm(way))
    restitution = draw.choice([0.0, 0.3, 0.6])
    inertia = mass * ((corners**2).mean() * 3 * np.eye(3) - corners.T @ corners / len(corners))
    if isinstance(shape, Box):
        inertia = inertia / 3  # of a solid box: a third of that of its eight corners
    momentum, within = turn @ inertia @ turn.T @ spin, np.linalg.inv(inertia)
    poses, first = [], None
    while first is None or len(poses) < (first[0] + 0.1) * RATE:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, centre
        poses.append(pose)
        half = _turned(turn @ within @ turn.T @ momentum * (_STEP / 2)) @ turn
        spin = half @ within @ half.T @ momentum
        time = _meeting(corners, centre, velocity, turn, spin)
        centre, turn = _flight(centre, velocity, turn, spin, time)
        velocity = velocity + _G * time
        if time < _STEP:
            if first is None:
                arms = corners @ turn.T
                lowest, second = arms[:, 2].argsort()[:2]
                blow = (
                    _energy(arms[lowest], velocity, spin, mass, turn, corners)
                    if arms[second, 2] - arms[lowest, 2] > 0.02
                    else np.nan
                )
                first = (len(poses) - 1) * _STEP + time, blow
            world = turn @ within @ turn.T
            velocity, spin = _struck(
                corners @ turn.T, centre, velocity, world @ momentum, mass, world, restitution
            )
            momentum = np.linalg.solve(world, spin)
            rest = _STEP - time
            centre, turn = _flight(centre, velocity, turn, spin, rest)
            velocity = velocity + _G * rest
    return Thrown(shape, mass, np.array(poses), *first)


def _shape(kind: int, draw: np.random.Generator) -> tuple[Shape, np.ndarray]:
    """A box, a rod or a hull, and its corners about the centre."""
    if kind == 2:
        points = draw.normal(size=(12, 3))
        points *= draw.uniform(0.2, 0.6, 3) / np.linalg.norm(points, axis=1)[:, None]
        points = points[Hull(points).vertices]
        points = points - points.mean(axis=0)
        return ConvexHull(points), points
    size = (
        draw.uniform(0.2, 1.0, 3)
        if kind == 0
        else np.array([draw.uniform(1, 2), *draw.uniform(0.03, 0.1, 2)])
    )
    return Box(tuple(size)), _CORNERS * size


def _energy(
    arm: np.ndarray,
    velocity: np.ndarray,
    spin: np.ndarray,
    mass: float,
    turn: np.ndarray,
    corners: np.ndarray,
) -> float:
    """The energy of the blow of a corner at the end of ``arm``: 1/2 m v² with 1/m the sum of 1/mass
    and (r x n) I^-1 (r x n). Inertia and centre of mass of the solid are sums over the tetrahedra
    of its Delaunay triangulation."""
    cells = corners[Delaunay(corners).simplices]  # (t, 4, 3)
    weights = np.abs(np.linalg.det(cells[:, 1:] - cells[:, :1]))
    weights = mass * weights / weights.sum()
    middles = cells.mean(axis=1)
    squares = np.einsum("t,tci,tcj->ij", weights, cells, cells) / 20
    squares += 16 / 20 * np.einsum("t,ti,tj->ij", weights, middles, middles)
    centre = weights @ middles / mass
    squares -= mass * np.outer(centre, centre)
    inertia = turn @ (squares.trace() * np.eye(3) - squares) @ turn.T
    speed = (velocity + np.cross(spin, arm))[2]
    lever = np.cross(arm - turn @ centre, [0.0, 0.0, 1.0])
    return float(speed**2 / 2 / (1 / mass + lever @ np.linalg.solve(inertia, lever)))


def _turned(vector: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(vector).as_matrix()


def _flight(
    centre: np.ndarray, velocity: np.ndarray, turn: np.ndarray, spin: np.ndarray, time: float
) -> tuple[np.ndarray, np.ndarray]:
    return centre + velocity * time + _G * (time * time / 2), _turned(spin * time) @ turn


def _meeting(
    corners: np.ndarray,
    centre: np.ndarray,
    velocity: np.ndarray,
    turn: np.ndarray,
    spin: np.ndarray,
) -> float:
    """Seconds to the first touch within the step, its whole length where there is none."""

    def lowest(time: float) -> float:
        place, way = _flight(centre, velocity, turn, spin, time)
        return float((corners @ way.T + place)[:, 2].min())

    if lowest(_STEP) > 0:
        return _STEP
    low, high = 0.0, _STEP
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if lowest(middle) > 0 else (low, middle)
    return low


def _struck(
    arms: np.ndarray,
    centre: np.ndarray,
    velocity: np.ndarray,
    spin: np.ndarray,
    mass: float,
    within: np.ndarray,
    restitution: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and spin after the impulses on the corners ``arms`` that touch; ``within``: the
    inverse of the inertia."""
    touching = arms[(arms + centre)[:, 2] < 1e-4]
    goals = -restitution * np.minimum((velocity + np.cross(spin, touching))[:, 2], 0.0)
    levers = np.cross(touching[:, None], np.eye(3))  # (corners, axes, 3)
    turning = levers @ within
    along = 1 / (1 / mass + (levers * turning).sum(axis=2))
    impulses = np.zeros((len(touching), 3))
    velocity = velocity.copy()
    for _ in range(20):
        for k, (goal, impulse) in enumerate(zip(goals, impulses, strict=True)):
            for axis in (2, 0, 1):
                now = velocity[axis] + levers[k, axis] @ spin
                wish = impulse[axis] + ((goal if axis == 2 else 0.0) - now) * along[k, axis]
                most = _FRICTION * impulse[2]
                bounded = max(wish, 0.0) if axis == 2 else min(max(wish, -most), most)
                added = bounded - impulse[axis]
                impulse[axis] += added
                velocity[axis] += added / mass
                spin = spin + turning[k, axis] * added
    return velocity, spin
