"""Walls, stacks and piles that Blender simulates at rest: no level moves from frame to frame but by
what bodies move, nor if each body is moved by a millimetre."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.io.frame_scene import scene_of_result
from haptic_tracing.addon.session import session
from level_properties import QUIET, changes_of_moved_bodies, of_measured_materials

AT_REST = 0.002
"""Most that a body at rest moves from one frame to the next [m]."""


def wall(random):
    """Five courses of bricks in bond."""
    return [
        ((c + r % 2 * 0.3, 0, 0.25 + 0.5 * r), (1, 0.5, 0.5), (0, 0, 0))
        for r in range(5)
        for c in range(4)
    ], 50


def stacks(random):
    """Six stacks of cubes, each turned a bit."""
    turns = random.uniform(-0.3, 0.3, 24).tolist()
    return [
        ((k // 4 * 0.8, 0, 0.25 + 0.5 * (k % 4)), (0.5, 0.5, 0.5), (0, 0, turn))
        for k, turn in enumerate(turns)
    ], 50


def pile(random):
    """Cubes that fall onto each other, and come to rest."""
    places = [
        (
            np.array([k % 3, k // 3 % 3, k // 9]) * 0.7
            + random.uniform(-0.1, 0.1, 3)
            + [0, 0, 0.75]
        ).tolist()
        for k in range(27)
    ]
    return [(tuple(place), (0.5, 0.5, 0.5), (0.4, 0, 0.4)) for place in places], 400


@pytest.mark.slow
@pytest.mark.parametrize("arrangement", [wall, stacks, pile])
@pytest.mark.parametrize("frames", [100, pytest.param(250, marks=pytest.mark.more)])
def test_levels_of_what_rests(arrangement, frames, scene, add_box):
    """Of all frames and pairs 99 % change by less than 0.3 dB, and all by less than 1 dB; and 99 %
    by less than 0.5 dB as bodies move by 1 mm, by the paper's function and by that of measured
    materials."""
    boxes, settled = arrangement(np.random.default_rng(5))
    with suspended():
        bpy.ops.rigidbody.world_add()
        scene.rigidbody_world.point_cache.frame_end = scene.frame_end = settled + frames
        add_box("ground", (0, 0, -0.5), (30, 30, 1), "PASSIVE")
        bodies = [
            add_box(f"box {number:02d}", place, size, "ACTIVE")
            for number, (place, size, _) in enumerate(boxes)
        ]
        for number, (body, (_, _, turn)) in enumerate(zip(bodies, boxes, strict=True)):
            body.rotation_euler = turn
            body.rigid_body.use_deactivation = False
            body.rigid_body.linear_damping = body.rigid_body.angular_damping = 0.5
            body.haptics.kappa, body.haptics.rho = 0.1, 0.9
            body.haptics.source.enabled, body.haptics.listener.enabled = (
                number % 9 == 0,
                number % 3 == 1,
            )
        scene.haptics.tracing = False
    for frame in range(1, settled + 1):
        scene.frame_set(frame)
    scene.haptics.tracing = True
    places, gains = [], []
    for frame in range(settled + 1, settled + frames + 1):
        scene.frame_set(frame)
        result = session.result_of(scene)
        gains.append(result.propagation.gain)
        places.append([tuple(body.matrix_world.translation) for body in bodies])
    moved = np.linalg.norm(np.diff(places, axis=0), axis=2).max(axis=1)
    still = moved < AT_REST
    assert still.mean() > 0.9 and moved[still].max() > 0
    found = np.array(gains)
    heard = np.minimum(found[1:], found[:-1]) > QUIET
    assert heard.mean() > 0.5
    level = 20 * np.log10(np.maximum(found, QUIET))
    change = np.abs(np.diff(level, axis=0))[still][heard[still]]
    assert np.percentile(change, 99) < 0.3
    assert change.max() < 1.0
    still = scene_of_result(result, session.of(scene).reading, scene)
    for made in (still, of_measured_materials(still)):
        change = changes_of_moved_bodies(made, frozenset({"ground"}), seed=1)
        assert len(change) > 300
        assert np.percentile(change, 99) < 0.5
