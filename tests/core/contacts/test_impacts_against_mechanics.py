"""Impacts of bodies whose motion has a closed form, sampled at frames, the bounce included."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.contacts.bullet_shapes import (
    convex_hull_shape,
    mesh_shape,
    shape_from_bounding_box,
)
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.contacts.tracker import ContactTracker
from haptic_tracing.core.scene.values import Pose
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[2] / "references"))
import triangle_reference

G = 9.81
CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SHAPES = {  # and how far below its origin each ends
    "box": (Box((1, 0.6, 0.4)), 0.2),
    "rounded box": (Box((1, 0.6, 0.4), rounding=0.04), 0.2),
    "sphere": (Sphere(0.3), 0.3),
    "capsule": (Capsule(0.2, 0.5), 0.45),
    "cylinder": (Cylinder(0.3, 0.5, rounding=0.04), 0.25),
    "cone": (Cone(0.3, 0.5, margin=0.04), 0.29),
    "cube": (ConvexHull(CUBE, rounding=0.04), 0.5),
    "hull": (ConvexHull(np.concatenate([CUBE, [[0.7, 0, 0]]])), 0.5),
    "ring": (mesh_shape(*triangle_reference.torus(), margin=0.04), 0.14),
    "dumbbell": (Mesh(*triangle_reference.SOLIDS["dumbbell"], sunk_in=0.05), 0.35),
    "cup": (Mesh(*triangle_reference.SOLIDS["cup"], sunk_in=0.05), 0.2),
}
GROUNDS = {
    "box": (Box((50, 50, 1)), -0.5),
    "mesh": (
        Mesh([[-25, -25, 0], [25, -25, 0], [25, 25, 0], [-25, 25, 0]], [[0, 1, 2], [0, 2, 3]]),
        0.0,
    ),
    "solid": (Mesh(*triangle_reference.box((50, 50, 1), 6), sunk_in=0.05), -0.5),
}


def height(h: float, restitution: float, t: float) -> float:
    """Of a body dropped from h at time 0 over the ground, bouncing."""
    if t <= 0:
        return h
    fall = math.sqrt(2 * h / G)
    if t < fall:
        return h - G * t * t / 2
    t -= fall
    v = restitution * math.sqrt(2 * G * h)
    while v > 1e-3:
        if t < 2 * v / G:
            return v * t - G * t * t / 2
        t -= 2 * v / G
        v *= restitution
    return 0.0


def poses(*places, turns=None):
    """Matrices of unturned bodies at places, float32 like Blender's."""
    result = np.tile(np.eye(4), (len(places), 1, 1))
    result[:, :3, 3] = np.array(places, dtype=np.float32)
    return result


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    shape=st.sampled_from(sorted(SHAPES)),
    ground=st.sampled_from(sorted(GROUNDS)),
    h=st.floats(math.log(0.05), math.log(30)).map(math.exp),
    mass=st.floats(math.log(0.5), math.log(1e4)).map(math.exp),
    restitution=st.sampled_from([0.0, 0.2, 0.5, 0.8]),
    rate=st.sampled_from([24.0, 25.0, 30 / 1.001, 60.0, 120.0]),
    scale=st.sampled_from([0.5, 1.0, 2.0]),
    late=st.floats(0, 1),
)
def test_dropped_bodies(shape, ground, h, mass, restitution, rate, scale, late):
    """Energy m g h, time sqrt(2 h / g); the body is let go ``late`` frames after the first one. A
    bounce makes another impact if the bodies have parted in some frame before it, by more than the
    tolerance and the slack, and the refractory time is over."""
    energy, fall = mass * G * h, math.sqrt(2 * h / G) / scale
    if fall * rate < 2.2 + late:
        return  # over before there are three frames to see it by
    (body, below), (floor, origin) = SHAPES[shape], GROUNDS[ground]
    tracker = ContactTracker(
        [Body("ground", floor, motion="static"), Body("body", body, mass)],
        ContactSettings(time_scale=scale, energy="as_in_the_paper"),
    )
    impacts, heights = [], []
    for frame in range(math.ceil((fall + 0.25) * rate) + 2):
        heights.append(height(h, restitution, (frame - late) / rate * scale))
        impacts += tracker.update(
            frame / rate, poses((0, 0, origin), (0.3, 0.2, below + heights[-1]))
        ).impacts
    if energy < 5 * 0.97:
        assert not impacts
    elif energy > 5 * 1.03:
        first = impacts[0]
        assert first.objects == (0, 1)
        assert first.energy == pytest.approx(energy, rel=0.03)
        assert first.amplitude == pytest.approx(min(energy / 100, 1), rel=0.03)
        assert first.time - late / rate == pytest.approx(fall, abs=0.002)
        np.testing.assert_allclose(first.normal, [0, 0, 1], atol=1e-4)
        np.testing.assert_allclose(np.mean(first.positions, axis=0), [0.3, 0.2, 0], atol=0.01)
        # Bounces: each with e^2 of the energy of the last, after 2 v / g.
        flight, left, expected = (
            2 * math.sqrt(2 * h / G) * restitution / scale,
            energy * restitution**2,
            1,
        )
        time = late / rate + fall
        last, end = time, (frame - 0.01) / rate
        while left > 5 * 1.05 and time + flight < end and flight * rate > 3:
            in_flight = heights[math.ceil(time * rate) : math.ceil((time + flight) * rate)]
            time += flight
            if time - last >= 0.1 and max(in_flight) > 0.016:
                last = time
                expected += 1
            flight, left = flight * restitution, left * restitution**2
        assert len(impacts) >= expected


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    speeds=st.tuples(st.floats(-8, 8), st.floats(-8, 8)).filter(lambda s: s[0] - s[1] > 1),
    masses=st.tuples(st.floats(1, 50), st.floats(1, 50)),
    normal_energy=st.booleans(),
    rate=st.sampled_from([24.0, 60.0]),
    drift=st.floats(-5, 5),
)
def test_balls_that_meet_in_space(speeds, masses, normal_energy, rate, drift):
    """Elastic impact on a line, everything drifting sideways: the paper's energy has the drift in
    it, the normal one not."""
    m1, m2 = masses
    u1, u2 = speeds
    meet = 0.31
    v1 = ((m1 - m2) * u1 + 2 * m2 * u2) / (m1 + m2)
    v2 = ((m2 - m1) * u2 + 2 * m1 * u1) / (m1 + m2)
    rules = ContactSettings(
        energy="effective" if normal_energy else "as_in_the_paper",
        least_energy=0.0,
        gravity=(0, 0, 0),
    )
    tracker = ContactTracker([Body("a", Sphere(0.2), m1), Body("b", Sphere(0.3), m2)], rules)
    impacts = []
    for frame in range(round(rate)):
        t = frame / rate
        s = t - meet
        a = -0.2 + (u1 if s < 0 else v1) * s
        b = 0.3 + (u2 if s < 0 else v2) * s
        impacts += tracker.update(t, poses((a, drift * t, 0), (b, drift * t, 0))).impacts
    assert len(impacts) == 1
    impact = impacts[0]
    if normal_energy:
        energy = 0.5 * m1 * m2 / (m1 + m2) * (u1 - u2) ** 2
    else:
        energy = 0.5 * m1 * (u1**2 + drift**2) + 0.5 * m2 * (u2**2 + drift**2)
    assert impact.energy == pytest.approx(energy, rel=0.01)
    assert impact.time == pytest.approx(meet, abs=0.001)
    np.testing.assert_allclose(impact.positions[0], [0, drift * meet, 0], atol=0.01)


@pytest.mark.parametrize("rate", [24.0, 60.0])
@pytest.mark.parametrize("speed", [10.0, 40.0, 150.0])
@pytest.mark.parametrize("shape", [Sphere(0.05), Box((0.1, 0.1, 0.1)), ConvexHull(0.1 * CUBE)])
def test_passing_a_thin_wall_within_a_frame(rate, speed, shape):
    walls = {
        "box": Box((0.02, 2, 2)),
        "mesh": Mesh([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]], [[0, 1, 2], [0, 2, 3]]),
    }
    for wall in walls.values():
        tracker = ContactTracker(
            [Body("wall", wall, motion="static"), Body("shot", shape, 0.2)],
            ContactSettings(gravity=(0, 0, 0)),
        )
        front = 0.05 + (0.01 if isinstance(wall, Box) else 0.0)
        meet = 4.37 / rate
        impacts = []
        for frame in range(10):
            x = -front + speed * (frame / rate - meet)
            impacts += tracker.update(frame / rate, poses((0, 0, 0), (x, 0.1, 0))).impacts
        assert len(impacts) == 1
        assert impacts[0].energy == pytest.approx(0.1 * speed**2, rel=1e-3)
        assert impacts[0].time == pytest.approx(meet, abs=0.0005)


def test_turning_body():
    """A plank that turns about its middle and hits with its end: the effective mass there is 1 /
    (1/m + d²/I), a distance d from its middle."""
    tracker = ContactTracker(
        [Body("post", Sphere(0.1), motion="static"), Body("plank", Box((2, 0.1, 0.1)), 10.0)],
        ContactSettings(energy="effective", least_energy=0.1, gravity=(0, 0, 0)),
    )
    spin, rate = -2.0, 24.0
    meet = None
    impacts = []
    for frame in range(30):
        t = frame / rate
        angle = 1.0 + spin * t
        matrices = poses((0.8, 0, 0), (0, 0, 0))
        c, s = math.cos(angle), math.sin(angle)
        # The plank's lower side meets the ball where its middle line is 0.15 above it.
        if meet is None and 0.8 * s <= 0.15:
            meet = (1.0 - math.asin(0.15 / 0.8)) / -spin
        matrices[1, :2, :2] = [[c, -s], [s, c]] if meet is None else matrices[1, :2, :2]
        if meet is not None:
            stop = math.asin(0.15 / 0.8)
            matrices[1, :2, :2] = [
                [math.cos(stop), -math.sin(stop)],
                [math.sin(stop), math.cos(stop)],
            ]
        impacts += tracker.update(t, matrices).impacts
    assert len(impacts) == 1
    assert impacts[0].time == pytest.approx(meet, abs=0.002)
    arm = math.sqrt(0.8**2 - 0.15**2)
    inertia = 10 * (2**2 + 0.1**2) / 12
    mass = 1 / (1 / 10 + arm**2 / inertia)
    assert impacts[0].energy == pytest.approx(0.5 * mass * (spin * arm) ** 2, rel=0.01)


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0])
@pytest.mark.parametrize("length", [1.0, 2.0, 5.0])
def test_a_pendulum_strikes_a_wall(length, rate, phase):
    """Let go at 1 rad, it hits at its lowest point with m g L (1 - cos 1 rad). Its angle is
    2 asin(k cd(t √(g / L))), k = sin(1/2), of Jacobi's elliptic functions."""
    special = pytest.importorskip("scipy.special")
    modulus, slow = math.sin(0.5) ** 2, math.sqrt(length / G)
    lowest = special.ellipk(modulus) * slow
    tracker = ContactTracker(
        [Body("wall", Box((1, 2, 2)), motion="static"), Body("ball", Sphere(0.1), 3.0)],
        ContactSettings(energy="effective", least_energy=1e-3),
    )
    impacts = []
    for frame in range(math.ceil((lowest + 0.3) * rate)):
        time = min(max((frame - phase) / rate, 0.0), lowest)
        _, cn, dn, _ = special.ellipj(time / slow, modulus)
        angle = 2 * math.asin(math.sqrt(modulus) * cn / dn)
        place = length * math.sin(angle), 0, -length * math.cos(angle)
        matrices = poses((-0.6, 0, -length), place)
        matrices[1, :3, :3] = [
            [math.cos(angle), 0, -math.sin(angle)],
            [0, 1, 0],
            [math.sin(angle), 0, math.cos(angle)],
        ]
        impacts += tracker.update(frame / rate, matrices).impacts
    (impact,) = impacts
    assert impact.time == pytest.approx(lowest + phase / rate, abs=0.002)
    assert impact.energy == pytest.approx(3 * G * length * (1 - math.cos(1)), rel=0.11)


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("rate", [24.0, 60.0])
@pytest.mark.parametrize("acceleration", [2.0, 6.0, 20.0])
def test_what_something_unknown_pulls_strikes(acceleration, rate, phase):
    """A crate that a rope pulls along from rest, for 1.5 m, into a wall: m a s."""
    tracker = ContactTracker(
        [Body("wall", Box((1, 2, 2)), motion="static"), Body("crate", Box((1, 1, 1)), 5.0)],
        ContactSettings(energy="effective", least_energy=1e-3),
    )
    arrival, impacts = math.sqrt(2 * 1.5 / acceleration), []
    for frame in range(math.ceil((arrival + 0.3) * rate)):
        time = min(max((frame - phase) / rate, 0.0), arrival)
        place = -1 - 1.5 + acceleration * time**2 / 2
        impacts += tracker.update(frame / rate, poses((0, 0, 0), (place, 0, 0))).impacts
    (impact,) = impacts
    assert impact.time == pytest.approx(arrival + phase / rate, abs=0.002)
    assert impact.energy == pytest.approx(5 * acceleration * 1.5, rel=0.05)


def test_animated_hammer():
    """A keyframed body hits one that rests: its own mass and speed count."""
    tracker = ContactTracker(
        [
            Body("anvil", Box((1, 1, 1)), 500.0),
            Body("hammer", Box((0.2, 0.2, 0.2)), 8.0, motion="kinematic"),
        ]
    )
    impacts, rate = [], 24.0
    for frame in range(48):
        z = 0.6 + 0.8 * abs(math.cos(math.pi * (frame + 0.3) / rate))
        impacts += tracker.update(frame / rate, poses((0, 0, 0), (0, 0, z))).impacts
    assert [round(i.time, 2) for i in impacts] == [
        pytest.approx(0.49, abs=0.02),
        pytest.approx(1.49, abs=0.02),
    ]
    for impact in impacts:
        assert impact.energy == pytest.approx(4 * (0.8 * math.pi) ** 2, rel=0.1)


def animated(body, place, other, other_pose, energy="as_in_the_paper", rate=24.0):
    """The impacts of a keyframed ``body`` in the matrices ``place`` of the time [s] on another one
    that stays where it is."""
    settings = ContactSettings(least_energy=0.1, energy=energy)
    tracker = ContactTracker([other, body], settings)
    return [
        impact
        for frame in range(30)
        for impact in tracker.update(
            frame / rate, np.stack([other_pose, place(frame / rate)])
        ).impacts
    ]


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.3, 0.5, 0.6, 0.75, 0.88])
@pytest.mark.parametrize("acceleration", [0.0, 15.0])
def test_a_keyframed_body_that_stops_between_two_frames(phase, acceleration):
    """It strikes at its full speed, when it arrives, wherever that is between frames."""
    stop, speed = (12 + phase) / 24, 4.0  # when it arrives, and how fast

    def place(time):
        left = max(stop - time, 0.0)
        (matrix,) = poses((0, 0, 0.6 + left * (speed - acceleration * left / 2)))
        return matrix

    hammer = Body("hammer", Box((0.2, 0.2, 0.2)), 8.0, motion="kinematic")
    anvil = Body("anvil", Box((1, 1, 1)), 500.0, motion="static")
    (impact,) = animated(hammer, place, anvil, np.eye(4))
    assert impact.time == pytest.approx(stop, abs=0.001)
    assert impact.energy == pytest.approx(8.0 / 2 * speed**2, rel=0.03)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.6, 0.88])
@pytest.mark.parametrize("gap", [0.0005, 0.002, 0.008])
def test_a_keyframed_body_that_stops_short_of_another_one_within_the_tolerance(phase, gap):
    """It strikes with its speed as where it arrives, also if nothing moves afterwards."""
    stop, speed = (12 + phase) / 24, 4.0

    def place(time):
        (matrix,) = poses((0, 0, 0.6 + gap + max(stop - time, 0.0) * speed))
        return matrix

    hammer = Body("hammer", Box((0.2, 0.2, 0.2)), 8.0, motion="kinematic")
    anvil = Body("anvil", Box((1, 1, 1)), 500.0, motion="static")
    (impact,) = animated(hammer, place, anvil, np.eye(4))
    assert impact.time == pytest.approx(stop + gap / speed, abs=0.001)
    assert impact.energy == pytest.approx(8.0 / 2 * speed**2, rel=0.03)


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.3, 0.5, 0.75, 0.88])
def test_a_keyframed_arm_that_stops_between_two_frames(phase):
    """An arm turns about its origin, which stays in place, and lands flat on a block, whose middle
    is 0.8 m from the arm's: each adds its own to the inverse of the effective mass."""
    stop, spin = (12 + phase) / 24, 2.0

    def place(time):
        angle = spin * max(stop - time, 0.0)
        matrix = np.eye(4)
        matrix[0, [0, 2]] = math.cos(angle), -math.sin(angle)
        matrix[2, [0, 2]] = math.sin(angle), math.cos(angle)
        return matrix

    corners = CUBE * (2, 0.1, 0.1) + (1, 0, 0)
    arm = Body("arm", ConvexHull(corners), 5.0, motion="kinematic")
    (block_pose,) = poses((1.8, 0, -0.15))
    block = Body("block", Box((0.3, 0.3, 0.2)), 1.0)
    (impact,) = animated(arm, place, block, block_pose, "effective")
    assert impact.time == pytest.approx(stop, abs=0.001)
    inertia = 5.0 * (2**2 + 0.1**2) / 12
    mass = 1 / (1 / 5.0 + 0.8**2 / inertia + 1 / 1.0)
    assert impact.energy == pytest.approx(mass * (spin * 1.8) ** 2 / 2, rel=0.01)


def test_a_keyframed_body_that_brakes_before_it_strikes():
    """From 4 m/s, at 8 m/s^2, to 2 m/s, with which it goes on into the other one."""

    def place(time):
        braking = min(max(time - 0.11, 0.0), 0.5)
        (matrix,) = poses((0, 0, 1.35 + 4 * (0.11 - min(time, 0.11)) - 4 * braking * (1 - braking)))
        return matrix

    hammer = Body("hammer", Box((0.2, 0.2, 0.2)), 8.0, motion="kinematic")
    anvil = Body("anvil", Box((1, 1, 1)), 500.0, motion="static")
    (impact,) = animated(hammer, place, anvil, np.eye(4))
    assert impact.time == pytest.approx(0.36, abs=0.002)
    assert impact.energy == pytest.approx(8.0 / 2 * 2.0**2, rel=0.05)


def fall_of(tracker, frames, rate=24.0, mass=5.0, start=0.0, h=2.0):
    places = [(frame, (0, 0, 0.2 + height(h, 0.3, frame / rate))) for frame in frames]
    return [
        tracker.update(start + frame / rate, poses((0, 0, -0.5), place)) for frame, place in places
    ]


def falling():
    return ContactTracker(
        [Body("ground", Box((50, 50, 1)), motion="static"), Body("box", Box((1, 0.6, 0.4)), 5.0)]
    )


@pytest.mark.parametrize("on", [17, 20, 24, 30])
@pytest.mark.parametrize("restitution", [0.0, 0.8])
def test_impacts_that_are_looked_for_from_a_frame_on(restitution, on):
    """Dropped from 2 m at 24 frames a second, it hits the ground in frame 16, and bounces for a
    second if at all: what lies there when impacts are switched on has hit already, what comes down
    later hits."""
    tracker, rate, impacts = falling(), 24.0, []
    for frame in range(60):
        place = (0, 0, 0.2 + height(2.0, restitution, frame / rate))
        impacts += tracker.update(
            frame / rate, poses((0, 0, -0.5), place), impacts=frame >= on
        ).impacts
    assert len(impacts) == (restitution > 0)
    for impact in impacts:
        assert impact.time == pytest.approx(
            math.sqrt(2 * 2.0 / G) * (1 + 2 * restitution), abs=0.002
        )
        assert impact.energy == pytest.approx(5 * G * 2.0 * restitution**2, rel=0.03)


def test_the_same_timeline_twice_gives_the_same_bits():
    first, tracker = falling(), falling()
    runs = [fall_of(tracker_, range(40)) for tracker_ in (first, tracker)]
    tracker.reset()
    runs.append(fall_of(tracker, range(40)))
    runs.append(fall_of(tracker, range(40)))  # time starts again: history is forgotten by itself
    for run in runs[1:]:
        for one, other in zip(runs[0], run, strict=True):
            assert one.impacts == other.impacts
            assert one.contacts.positions.tobytes() == other.contacts.positions.tobytes()
            assert one.contacts.distance.tobytes() == other.contacts.distance.tobytes()
    assert sum(len(f.impacts) for f in runs[0]) >= 1


@pytest.mark.parametrize("jump", ["forwards", "backwards", "said"])
def test_jumps_make_no_impacts(jump):
    tracker = falling()
    fall_of(tracker, range(10))
    if jump == "said":
        matrices = poses((0, 0, -0.5), (0, 0, 0.2))
        found = [
            tracker.update(10 / 24, matrices, continuous=False),
            tracker.update(11 / 24, matrices),
        ]
    elif jump == "forwards":
        tracker.reset()
        found = fall_of(tracker, range(30, 40), h=0.001)
    else:
        found = fall_of(tracker, range(5), h=0.0)
    assert not any(f.impacts for f in found)
    assert len(found[0].contacts) == 1


def test_frames_left_out_do_not_matter():
    """Every other frame dropped in playback: the same impact."""
    found = fall_of(falling(), range(0, 60, 2))
    impacts = [i for f in found for i in f.impacts]
    assert impacts[0].energy == pytest.approx(5 * G * 2, rel=0.03)
    assert impacts[0].time == pytest.approx(math.sqrt(4 / G), abs=0.002)


def test_bodies_that_move_together_make_no_impact():
    """A crate on a lorry at 20 m/s, rattling by a tenth of a millimetre, and the lorry on the road:
    nothing begins."""
    generator = np.random.default_rng(1)
    bodies = [
        Body("road", Box((500, 10, 1)), motion="static"),
        Body("lorry", Box((6, 2, 1)), 2000.0, motion="kinematic"),
        Body("crate", Box((1, 1, 1)), 50.0),
    ]
    tracker = ContactTracker(bodies)
    found = []
    for frame in range(60):
        x = 20 * frame / 24
        shake = generator.normal(size=2) * 1e-4
        found.append(
            tracker.update(
                frame / 24, poses((0, 0, -0.5), (x, 0, 0.5), (x + shake[0], 0, 1.5 + shake[1]))
            )
        )
    assert not any(f.impacts for f in found)
    assert all(len(f.contacts) == 2 for f in found)


def test_sliding_from_tile_to_tile_is_no_impact():
    tiles = [Body(f"tile {k}", Box((1, 1, 0.2)), motion="static") for k in range(12)]
    tracker = ContactTracker([*tiles, Body("puck", Box((0.4, 0.4, 0.1)), 20.0)])
    found = []
    for frame in range(24):
        x = 0.2 + 9 * frame / 24
        found.append(
            tracker.update(frame / 24, poses(*[(k, 0, -0.1) for k in range(12)], (x, 0, 0.05)))
        )
    touched = {pair for f in found for pair in map(tuple, f.contacts.pairs.tolist())}
    assert len(touched) >= 9
    assert not any(f.impacts for f in found)


def test_one_impact_of_many_points_and_one_within_the_refractory_time():
    """A table lands on four feet at once; a bouncing one makes the next source only after the
    refractory time."""
    feet = [
        [x + dx, y + dy, z]
        for x in (-0.5, 0.5)
        for y in (-0.4, 0.4)
        for dx in (0, 0.1)
        for dy in (0, 0.1)
        for z in (-0.4, 0.4)
    ]
    table = ConvexHull(np.array(feet))
    for refractory, expected in ((0.1, 3), (1.0, 1)):
        bodies = [Body("ground", Box((50, 50, 1)), motion="static"), Body("table", table, 20.0)]
        rules = ContactSettings(refractory=refractory, least_energy=5.0)
        tracker = ContactTracker(bodies, rules)
        impacts = []
        for frame in range(48):
            impacts += tracker.update(
                frame / 24, poses((0, 0, -0.5), (0, 0, 0.4 + height(1.5, 0.5, frame / 24)))
            ).impacts
        assert len(impacts) == expected


PLATES = {  # as Blender hands them to Bullet with its default margin, thicknesses in metres
    "box": lambda thickness: shape_from_bounding_box("BOX", CUBE * [2, 2, thickness]),
    "hull": lambda thickness: convex_hull_shape(CUBE * [2, 2, thickness]),
    "mesh": lambda thickness: mesh_shape(
        [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
        [[0, 1, 2], [0, 2, 3]],
        margin=thickness / 2,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("plate", PLATES)
@pytest.mark.parametrize("thickness", [0.002, 0.005, 0.01, 0.02])
@pytest.mark.parametrize("speed", [40.0, 150.0, 800.0])
@pytest.mark.parametrize("stopped", [True, False])
def test_a_bullet_does_not_pass_a_thin_plate_unseen(plate, thickness, speed, stopped):
    """A sphere of 5 mm at 24 frames a second moves 170 to 3,300 times its size between frames;
    Bullet stops it or lets it through."""
    shape = PLATES[plate](thickness)
    surface = -0.005 - (
        0.0 if plate == "mesh" else thickness / 2
    )  # a sphere meets the triangles themselves
    for share in (0.03, 0.35, 0.66, 0.97):
        tracker = ContactTracker(
            [Body("plate", shape, motion="static"), Body("bullet", Sphere(0.005), 0.05)],
            ContactSettings(gravity=(0, 0, 0)),
        )
        impacts = []
        for frame in range(9):
            z = surface + speed * (frame - 4 - share) / 24
            impacts += tracker.update(
                frame / 24, poses((0, 0, 0), (0.1, 0.05, min(z, surface) if stopped else z))
            ).impacts
        assert len(impacts) == 1
        assert impacts[0].energy == pytest.approx(0.05 * speed**2 / 2, rel=0.01)
        assert impacts[0].time == pytest.approx((4 + share) / 24, abs=1e-3)


def falling_rod(
    tilt: float, drop: float, length: float = 2.0
) -> tuple[float, float, float, Callable[[float], tuple[float, float]]]:
    """A thin rod that drops by ``drop`` onto the end of a frictionless ground, and onto its other
    end, both times without a bounce.

    Returns the times of the two blows, the speed of the second, and height and angle over time. The
    first takes the end's speed: v' = v - J / m and w' = J l cos(a) / I with l half the length and J
    = m v / (1 + 3 cos^2 a). From then on height h = l sin(a), and the energy m h'^2 / 2 + I a'^2 /
    2 + m g h is constant.
    """
    half, inertia = length / 2, length**2 / 12  # per kg
    first, speed = math.sqrt(2 * drop / G), math.sqrt(2 * G * drop)
    impulse = speed / (1 + 3 * math.cos(tilt) ** 2)
    spin = impulse * half * math.cos(tilt) / inertia
    energy = (inertia + (half * math.cos(tilt)) ** 2) * spin**2 / 2 + G * half * math.sin(tilt)

    def rate(angle: float) -> float:
        return math.sqrt(
            2 * (energy - G * half * math.sin(angle)) / (inertia + (half * math.cos(angle)) ** 2)
        )

    angles = np.linspace(tilt, 0, 2001)
    slowness = 1 / np.array([rate(angle) for angle in angles])
    times = first + np.concatenate(
        [[0], np.cumsum((slowness[1:] + slowness[:-1]) / 2 * -np.diff(angles))]
    )

    def place(t: float) -> tuple[float, float]:
        if t < first:
            return drop + half * math.sin(tilt) - G * t * t / 2, tilt
        angle = float(np.interp(t, times, angles))
        return half * math.sin(angle), angle

    return first, float(times[-1]), 2 * half * rate(0.0), place


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 120.0, 240.0])
@pytest.mark.parametrize("tilt", [0.15, 0.2, 0.3])
@pytest.mark.parametrize("drop", [0.5, 0.86, 2.0])
def test_the_harder_blow_of_the_other_end_of_a_rod_counts(rate, tilt, drop):
    """It follows within 31 to 109 ms, while the first end still lies on the ground; the refractory
    time is 100 ms."""
    first, second, speed, place = falling_rod(tilt, drop)
    if math.ceil(first * rate) >= math.floor(second * rate):
        return  # both within two intervals: no frame shows one end on the ground
    rules = ContactSettings(energy="effective", least_energy=1.0)
    tracker = ContactTracker(
        [Body("ground", Box((50, 50, 1)), motion="static"), Body("rod", Box((2, 0.02, 0.02)), 5.0)],
        rules,
    )
    impacts = []
    for frame in range(math.ceil(second * rate) + 6):
        height, angle = place(frame / rate)
        matrices = poses((0, 0, -0.5), (0, 0, height + 0.01))
        matrices[1, :3, :3] = np.array(
            [
                [math.cos(angle), 0, math.sin(angle)],
                [0, 1, 0],
                [-math.sin(angle), 0, math.cos(angle)],
            ]
        )
        impacts += tracker.update(frame / rate, matrices).impacts
    assert len(impacts) == 2
    assert impacts[0].time == pytest.approx(first, abs=0.004)
    assert impacts[1].time == pytest.approx(second, abs=1 / rate)
    assert 1.25**2 * impacts[0].energy <= impacts[1].energy <= 1.05 * 5.0 * speed**2 / 2
    assert abs(impacts[1].positions[0][0]) == pytest.approx(1.0, abs=0.05)
    assert np.sign(impacts[1].positions[0][0]) == -np.sign(impacts[0].positions[0][0])


@pytest.mark.parametrize(
    "shape",
    [
        Sphere(0.3),
        Capsule(0.3, 1.0),
        ConvexHull(
            [
                [0.3 * math.cos(a), y, 0.3 * math.sin(a)]
                for a in np.arange(32) * math.pi / 16
                for y in (-0.2, 0.2)
            ]
        ),
    ],
)
@pytest.mark.parametrize("speed", [1.0, 4.0, 13.0])
def test_rolling_makes_no_impact(shape, speed):
    tracker = ContactTracker(
        [Body("ground", Box((100, 100, 1)), motion="static"), Body("wheel", shape, 50.0)],
        ContactSettings(least_energy=0.5),
    )
    for frame in range(48):
        x, matrices = speed * frame / 24, poses((0, 0, -0.5), (speed * frame / 24, 0, 0.3))
        turn = np.array(
            [
                [math.cos(x / 0.3), 0, math.sin(x / 0.3)],
                [0, 1, 0],
                [-math.sin(x / 0.3), 0, math.cos(x / 0.3)],
            ]
        )
        lying = (
            np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
            if isinstance(shape, Capsule)
            else np.eye(3)
        )
        matrices[1, :3, :3] = turn @ lying
        assert tracker.update(frame / 24, matrices).impacts == ()


@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (3.0, -2.0, 5.0)])
@pytest.mark.parametrize("motions", [("dynamic", "dynamic"), ("kinematic", "dynamic")])
def test_no_frame_of_reference_changes_the_energy(drift, motions):
    """Two balls meet off centre, and everything drifts along."""
    first, second = (
        Body(name, Sphere(0.2), mass, motion=motion)
        for name, mass, motion in zip("ab", (3.0, 5.0), motions, strict=True)
    )
    tracker = ContactTracker([first, second], ContactSettings(gravity=(0, 0, 0)))
    meet, speed, offset = 0.51, 4.0, 0.1
    gap = math.sqrt(0.4**2 - offset**2)
    impacts = []
    for frame in range(24):
        t = frame / 24
        d = np.array(drift) * t
        x = gap + speed * max(meet - t, 0.0)
        impacts += tracker.update(t, poses(d, d + np.array([x, offset, 0]))).impacts
    (impact,) = impacts
    normal = speed * gap / 0.4
    assert impact.energy == pytest.approx(3 * 5 / 8 / 2 * normal**2, rel=0.01)


def test_two_bodies_that_nothing_moves_make_no_blow():
    bodies = [Body(name, Box((1, 1, 1)), 5.0, motion="static") for name in "ab"]
    tracker = ContactTracker(bodies, ContactSettings())
    heights = [2.0 - 0.1 * frame for frame in range(16)]
    assert not any(
        tracker.update(k / 24, poses((0, 0, 0), (0, 0, max(z, 1.0)))).impacts
        for k, z in enumerate(heights)
    )


@pytest.mark.parametrize(("energy", "share"), [("effective", 0.75), ("as_in_the_paper", 1.0)])
def test_a_hinged_bar_that_lands_flat(energy, share):
    """Its blow has 3/4 of 1/2 I w^2 about the hinge: a free bar would turn on about the middle of
    what it lands on. The paper counts all of it."""
    length, spin, stop = 1.2, 3.0, 0.43

    def place(time):
        angle = spin * max(stop - time, 0.0)
        matrix = np.eye(4)
        matrix[0, [0, 2]] = math.cos(angle), -math.sin(angle)
        matrix[2, [0, 2]] = math.sin(angle), math.cos(angle)
        return matrix

    corners = CUBE * (length, 0.1, 0.001) + (length / 2, 0, 0.0005)
    bar = Body("bar", ConvexHull(corners), 5.0, motion="kinematic")
    (table_pose,) = poses((length / 2 + 0.01, 0, -0.5))
    table = Body("table", Box((length, 1, 1)), motion="static")
    (impact,) = animated(bar, place, table, table_pose, energy)
    whole = 5.0 * length**2 / 3 * spin**2 / 2
    assert impact.energy == pytest.approx(share * whole, rel=0.03)


@pytest.mark.parametrize("phase", [0.0, 0.2, 0.4, 0.6, 0.8])
def test_a_plank_that_lies_on_one_trestle_strikes_the_other_one_of_the_same_body(phase):
    """Its end comes down about the edge on which it lies; each is 0.8 m from its middle."""
    trestle = Box((0.1, 0.6, 0.7))
    stand = Compound.of([(trestle, Pose((x, 0, -0.35))) for x in (-0.8, 0.8)])
    plank = Body("plank", Box((2.0, 0.3, 0.04)), 9.0, motion="kinematic")
    stop, spin = (14 + phase) / 24, 1.5

    def place(time):
        angle = spin * max(stop - time, 0.0)
        matrix = np.eye(4)
        matrix[0, [0, 2]] = math.cos(angle), -math.sin(angle)
        matrix[2, [0, 2]] = math.sin(angle), math.cos(angle)
        edge = np.array([-0.8, 0.0, 0.0])
        matrix[:3, 3] = edge + matrix[:3, :3] @ (np.array([0, 0, 0.02]) - edge)
        return matrix

    trestles = Body("trestles", stand, motion="static")
    (impact,) = animated(plank, place, trestles, np.eye(4), "effective")
    assert impact.time == pytest.approx(stop, abs=0.002)
    inertia = 9.0 * (2.0**2 + 0.04**2) / 12
    mass = 1 / (1 / 9.0 + 0.8**2 / inertia)
    assert impact.energy == pytest.approx(mass * (spin * 1.6) ** 2 / 2, rel=0.1)
