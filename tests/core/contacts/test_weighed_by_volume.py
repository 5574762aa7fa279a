"""What animation moves without a mass strikes with that of its volume, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body, ContactSettings, Motion
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.contacts.tracker import ContactTracker

RATE = 24.0
FLOOR = Body("floor", Box((4.0, 4.0, 1.0)), motion=Motion.STATIC)
WALL = Body("wall", Box((4.0, 4.0, 1.0)), motion=Motion.KINEMATIC, density=2000.0)
HAMMER = Body("hammer", Box((0.2, 0.2, 0.2)), motion=Motion.KINEMATIC, density=1000.0)
"""Of 8 kg."""


def impacts_of(bodies, place, frames=24, rate=RATE):
    """The impacts where the last of some bodies is at a ``place`` (3,), which may be followed by
    the turn about the y axis, and the others at the end of a way: the floor's top is at z = 0."""
    tracker = ContactTracker(bodies, ContactSettings(gravity=(0, 0, 0)))
    found = []
    for frame in range(frames):
        transforms = np.tile(np.eye(4), (len(bodies), 1, 1))
        transforms[:-1, 2, 3] = -0.5
        x, y, z, *turn = place(frame / rate)
        transforms[-1, :3, 3] = x, y, z
        if turn:
            c, s = math.cos(turn[0]), math.sin(turn[0])
            transforms[-1, :3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        found += tracker.update(frame / rate, transforms).impacts
    return found


@pytest.mark.parametrize("ground", [FLOOR, WALL], ids=lambda body: body.name)
@pytest.mark.parametrize("phase", np.arange(8) / 8)
@pytest.mark.parametrize("speed", [0.5, 2.0, 6.0])
def test_a_keyed_box_strikes_with_its_volume_times_density(ground, speed, phase):
    lands = (12 + phase) / RATE
    (impact,) = impacts_of([ground, HAMMER], lambda t: (0, 0, 0.1 + speed * max(lands - t, 0.0)))
    assert impact.energy == pytest.approx(8.0 * speed**2 / 2, rel=0.02)
    assert impact.time == pytest.approx(lands, abs=2e-3)


def test_what_stands_or_slides_or_rolls_without_a_mass_strikes_nothing():
    ball = Body("ball", Sphere(0.1), motion=Motion.KINEMATIC, density=1000.0)
    ways = {
        "slides": (HAMMER, lambda t: (math.sin(3 * t), 0, 0.1)),
        "trembles": (HAMMER, lambda t: (0, 0, 0.1 + 1e-5 * math.sin(37 * t))),
        "rolls": (ball, lambda t: (t / 10, 0, 0.1, t)),
        "is set down": (HAMMER, lambda t: (0, 0, 0.1 + 0.05 * (1 + math.cos(2 * t)))),
    }
    for body, way in ways.values():
        assert not impacts_of([FLOOR, body], way, 500)


@pytest.mark.parametrize("moves", ["hammer", "ball"])
def test_both_count_where_animation_meets_a_body(moves):
    """While it stands, what has no mass yields to nothing."""
    ball = Body("ball", Sphere(0.2), 2.0)
    tracker = ContactTracker([HAMMER, ball], ContactSettings(gravity=(0, 0, 0)))
    impacts = []
    for frame in range(24):
        away = 4.0 * max(0.5 - frame / 24, 0.0)
        transforms = np.tile(np.eye(4), (2, 1, 1))
        transforms[0, 2, 3] = 0.3 + (away if moves == "hammer" else 0.0)
        transforms[1, 2, 3] = 0.0 if moves == "hammer" else -away
        impacts += tracker.update(frame / 24, transforms).impacts
    (impact,) = impacts
    mass = 8 * 2 / (8 + 2) if moves == "hammer" else 2.0
    assert impact.energy == pytest.approx(mass * 4.0**2 / 2, rel=0.02)
