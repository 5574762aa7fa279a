"""Dominoes a metre high that fell each other, simulated by Bullet at 960 steps a second, with the
times and energies of their first blows.

Run inside Blender's Python (bpy). Nothing of the product's geometry or motion is used: a domino
falls in a plane, so that it meets the next one where its upper front edge reaches that one's back.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

RATE = 960
SIZE = (0.12, 0.4, 1.0)
MASS = 12.0
_SPACING = 0.42
_TILT = 0.16


@dataclass(frozen=True)
class Row:
    """Dominoes in a row: their ``poses`` (frames, n, 4, 4), and the ``time`` (n - 1,) [s] and the
    kinetic ``energy`` (n - 1,) [J] with which each first meets the next."""

    poses: np.ndarray
    time: np.ndarray
    energy: np.ndarray


def row(count: int, seconds: float) -> Row:
    """Let ``count`` dominoes fall, of which the first leans over."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = RATE
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.substeps_per_frame, world.solver_iterations = 1, 20
    scene.frame_end = world.point_cache.frame_end = round(seconds * RATE) + 1
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0, 0, -0.5), scale=(200, 200, 1))
    _body(bpy.context.object, "PASSIVE")
    bodies = []
    for number in range(count):
        bpy.ops.mesh.primitive_cube_add(size=1.0)
        domino = bpy.context.object
        domino.scale = SIZE
        bpy.ops.object.transform_apply(location=False, rotation=False)
        lean = _TILT if number == 0 else 0.0
        # Stands on its lower front edge.
        front = np.array([-SIZE[0] / 2, SIZE[2] / 2])
        domino.location = (
            number * _SPACING + SIZE[0] / 2 + front[0] * np.cos(lean) + front[1] * np.sin(lean),
            0,
            -front[0] * np.sin(lean) + front[1] * np.cos(lean),
        )
        domino.rotation_euler = (0, lean, 0)
        _body(domino, "ACTIVE")
        bodies.append(domino)
    poses = []
    for frame in range(1, scene.frame_end + 1):
        scene.frame_set(frame)
        poses.append([np.array(body.matrix_world) for body in bodies])
    found = np.array(poses)
    return Row(found, *_first_blows(found))


def _body(obj: bpy.types.Object, kind: str) -> None:
    bpy.context.view_layer.objects.active = obj
    bpy.ops.rigidbody.object_add(type=kind)
    obj.rigid_body.collision_shape = "BOX"
    obj.rigid_body.mass, obj.rigid_body.friction = MASS, 0.5
    obj.rigid_body.restitution = 0.0
    obj.rigid_body.use_deactivation = False


def _first_blows(poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    edge = np.array([SIZE[0] / 2, 0, SIZE[2] / 2, 1])
    times, energies = [], []
    for one, other in zip(poses[:, :-1].swapaxes(0, 1), poses[:, 1:].swapaxes(0, 1), strict=True):
        upper = one @ edge
        gap = -np.einsum("ni,ni->n", (upper - other[:, :, 3])[:, :3], other[:, :3, 0]) - SIZE[0] / 2
        k = int((gap <= 1e-3).argmax())
        times.append(k / RATE)
        before = np.stack([one, other])[:, k - 2 : k, :3, 3] * RATE
        speed = before[:, 1] - before[:, 0]
        axes = np.stack([one, other])[:, k - 2 : k, [0, 2], 0]  # they turn about y
        lean = np.arctan2(-axes[..., 1], axes[..., 0])
        spin = (lean[:, 1] - lean[:, 0]) * RATE
        square = (SIZE[0] ** 2 + SIZE[2] ** 2) / 12
        energies.append(MASS / 2 * ((speed**2).sum() + square * (spin**2).sum()))
    return np.array(times), np.array(energies)
