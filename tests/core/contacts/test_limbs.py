"""Parts of skins strike with their own motion, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.inertia import inertia_of
from haptic_tracing.core.contacts.settings import Body, ContactSettings, Motion
from haptic_tracing.core.contacts.shapes import Box, Compound, ConvexHull, Sphere, quaternions
from haptic_tracing.core.contacts.tracker import ContactTracker

RATE = 24.0
LENGTH, HEIGHT = 0.28, 0.08
"""Of a foot, whose heel is at its origin [m]."""
MASS = 4.4
FLOOR = Body("floor", Box((6.0, 6.0, 1.0)), motion=Motion.STATIC)


def block(low, high):
    return ConvexHull(
        [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )


FOOT = block((0, -0.05, 0), (LENGTH, 0.05, HEIGHT))
TRUNK = block((-0.2, -0.2, 0.6), (0.2, 0.2, 1.6))
WHEEL = ConvexHull(
    [
        (0.3 * math.cos(turn), y, 0.3 * math.sin(turn))
        for turn in np.linspace(0, 2 * math.pi, 64, endpoint=False)
        for y in (-0.05, 0.05)
    ]
)


def turned(angle):
    """A rotation about the y axis that lifts what is in front, along x."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


class Walk:
    """A skin of a trunk and a foot, whose heel is at (x, z) and which is lifted by an angle, over a
    floor at z = 0, and whoever else is there."""

    def __init__(self, *others, limbs=(0.0, MASS), foot=FOOT, rate=RATE, **rest):
        self.parts, self.limbs, self.rest, self.rate = (TRUNK, foot), limbs, rest, rate
        self.others = (FLOOR, *others)
        self.tracker = ContactTracker([self.skin(0, 0, 0), *self.others], ContactSettings())
        self.frame = 0

    def skin(self, x, z, angle):
        poses = np.array([(0, 0, 0, 1, 0, 0, 0), (x, 0, z, *quaternions(turned(angle)[None])[0])])
        shape = Compound(self.parts, poses)
        return Body("skin", shape, motion=Motion.KINEMATIC, limbs=self.limbs, **self.rest)

    def to(self, x, z, angle=0.0, *places):
        """The impacts up to the next frame."""
        self.tracker.replace_bodies([self.skin(x, z, angle), *self.others])
        transforms = np.tile(np.eye(4), (2 + len(places), 1, 1))
        transforms[1, 2, 3] = -0.5
        for k, place in enumerate(places):
            transforms[2 + k, :3, 3] = place
        found = self.tracker.update(self.frame / self.rate, transforms)
        self.frame += 1
        return list(found.impacts)


def along(walk, way, frames):
    return [impact for k in range(frames) for impact in walk.to(*way(k / walk.rate))]


@pytest.mark.parametrize("phase", np.arange(8) / 8)
@pytest.mark.parametrize("rate", [24.0, 25.0, 30.0, 60.0])
@pytest.mark.parametrize("speed", [0.3, 0.6, 2.0])
def test_a_foot_that_comes_down_strikes_with_half_m_v_squared(speed, rate, phase):
    lands = (8 + phase) / rate
    walk = Walk(rate=rate)
    (impact,) = along(walk, lambda t: (0.0, speed * max(lands - t, 0.0)), 20)
    assert impact.energy == pytest.approx(MASS * speed**2 / 2, rel=0.01)
    assert impact.time == pytest.approx(lands, abs=2e-3)
    assert impact.objects == (0, 1)
    assert impact.normal == pytest.approx((0, 0, -1))
    assert impact.positions[0] == pytest.approx((LENGTH / 2, 0, 0), abs=1e-6)


def test_a_part_without_a_published_mass_has_that_of_its_volume():
    volume = LENGTH * 0.1 * HEIGHT
    walk = Walk(limbs=(0.0, 0.0), density=1050.0)
    (impact,) = along(walk, lambda t: (0.0, 2.0 * max(8 / RATE - t, 0.0)), 20)
    assert impact.energy == pytest.approx(1050.0 * volume * 2.0**2 / 2, rel=0.01)


def test_a_part_of_a_body_with_a_mass_has_its_share_of_it():
    walk = Walk(limbs=(0.0, 0.0), mass=70.0)
    volumes = [inertia_of(part).volume for part in (TRUNK, FOOT)]
    (impact,) = along(walk, lambda t: (0.0, 3.0 * max(8 / RATE - t, 0.0)), 20)
    mass = 70.0 * volumes[1] / sum(volumes)
    assert impact.energy == pytest.approx(mass * 3.0**2 / 2, rel=0.01)


def test_heel_and_toe_strike_where_they_land():
    """The foot comes down on its heel at 0.6 m/s, tilted by 0.25 rad, and then turns about the heel
    at 3 rad/s until it is flat: the toe lands at that speed times its distance."""
    heel, toe, tilt, spin = 8 / RATE, 16 / RATE, 0.25, 3.0

    def way(t):
        return (
            0.0,
            0.6 * max(heel - t, 0.0),
            min(max(tilt - spin * (t - toe + tilt / spin), 0.0), tilt),
        )

    first, second = along(Walk(), way, 24)
    assert first.energy == pytest.approx(MASS * 0.6**2 / 2, rel=0.01)
    assert first.time == pytest.approx(heel, abs=2e-3)
    assert first.positions[0] == pytest.approx((0, 0, 0), abs=1e-3)
    assert second.energy == pytest.approx(MASS * (spin * LENGTH) ** 2 / 2, rel=0.05)
    assert second.time == pytest.approx(toe, abs=5e-3)
    assert second.positions[0] == pytest.approx((LENGTH, 0, 0), abs=1e-6)


@pytest.mark.parametrize(
    "way",
    {
        "stands and trembles": lambda t: (0.0, 1e-5 * math.sin(37 * t)),
        "slides": lambda t: (math.sin(3 * t), 0.0),
        "is set down and lifted": lambda t: (0.0, 0.05 * (1 + math.cos(2 * t))),
        "rolls": lambda t: (t, 0.3, -t / 0.3),
        "rolls from heel to toe": lambda t: (0.3 * math.sin(t), 0.3, -math.sin(t)),
        "rises": lambda t: (0.0, 0.02 * t),
        "hovers": lambda t: (math.sin(5 * t), 0.004),
    }.items(),
    ids=lambda way: way[0],
)
def test_what_stands_slides_rolls_or_is_set_down_strikes_nothing(way):
    name, way = way
    assert not along(Walk(foot=WHEEL if "rolls" in name else FOOT), way, 500)


def test_a_foot_strikes_once_a_step_while_the_other_stands():
    """A skin touches the floor all the time; its parts come and go."""
    walk = Walk(foot=FOOT)
    walk.parts = (block((-1.2, -0.05, 0), (-1.0, 0.05, 1.0)), FOOT)
    walk.tracker = ContactTracker([walk.skin(0, 0, 0), *walk.others], ContactSettings())
    impacts = along(walk, lambda t: (0.5 * t, 0.15 * abs((t * 2) % 2 - 1)), 24 * 5)
    assert [round(impact.time, 2) for impact in impacts] == [0.5, 1.5, 2.5, 3.5, 4.5]


def test_a_kick_counts_once_with_the_masses_of_both():
    """A foot at 3 m/s kicks a ball of 0.5 kg, which then flies ahead of it."""
    ball, speed = Body("ball", Sphere(0.11), 0.5), 3.0
    walk = Walk(ball)
    impacts = []
    for frame in range(20):
        x = speed * (frame / RATE - 0.5)
        at = LENGTH + 0.11 + max(2 * x, 0.0)
        impacts += walk.to(min(x, 0.3), 0.01, 0.0, (at, 0.0, 0.05))
    (impact,) = impacts
    assert impact.energy == pytest.approx(MASS * 0.5 / (MASS + 0.5) * speed**2 / 2, rel=0.02)


def test_a_ball_that_falls_on_a_part_that_stands_counts_once():
    ball, height = Body("ball", Sphere(0.1), 2.0), 0.5
    walk = Walk(ball)
    impacts = []
    for frame in range(24):
        fallen = min(9.81 * (frame / RATE) ** 2 / 2, height)
        impacts += walk.to(1.0, 0.0, 0.0, (0.0, 0.0, 1.7 + height - fallen))
    (impact,) = impacts
    assert impact.energy == pytest.approx(2.0 * 9.81 * height, rel=0.02)


def test_nothing_strikes_through_the_edge_of_a_step():
    """A heel stands on a step whose edge is below the middle of the foot: the toe goes down past
    it."""
    walk = Walk()
    impacts = along(walk, lambda t: (3.0 - LENGTH / 2, 0.0, -2.0 * max(t - 0.5, 0.0)), 16)
    assert not impacts
