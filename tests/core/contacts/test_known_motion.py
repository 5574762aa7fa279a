"""Blows of bodies whose motion between frames is known, or not, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.known_motion import KnownMotion
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.contacts.tracker import ContactTracker

MASS, HEIGHT, LAST = 20.0, 1.5, 0.25
BOUNCES = [(1 / 2.75, 5.5), (2 / 2.75, 2.75), (2.5 / 2.75, 1.375), (1.0, 0.6875)]


def bounce(u):
    """Penner's equation, with the places above and the speeds there."""
    for end, rise, height in ((1, 0, 0), (2, 1.5, 0.75), (2.5, 2.25, 0.9375)):
        if u < end / 2.75:
            return 7.5625 * (u - rise / 2.75) ** 2 + height
    return 7.5625 * (u - 2.625 / 2.75) ** 2 + 0.984375


def in_and_out(way):
    """Penner's: the way at twice the pace for its first half, then backwards."""
    return lambda u: way(2 * u) / 2 if u < 0.5 else 1 - way(2 - 2 * u) / 2


WAYS = {  # the way down by time, both up to 1, and where it touches with which speed
    "at constant speed": (lambda u: u, [(1.0, 1.0)]),
    "smooth step": (lambda u: 3 * u**2 - 2 * u**3, []),
    "cubic in": (lambda u: u**3, [(1.0, 3.0)]),
    "cubic out": (lambda u: 1 - (1 - u) ** 3, []),
    "quintic out": (lambda u: 1 - (1 - u) ** 5, []),
    "sine out": (lambda u: math.sin(math.pi / 2 * u), []),
    "cubic in-out": (in_and_out(lambda u: u**3), []),
    "quartic in-out": (in_and_out(lambda u: u**4), []),
    "circular in-out": (in_and_out(lambda u: 1 - math.sqrt(1 - u**2)), []),
    "exponential in-out": (in_and_out(lambda u: 2 ** (10 * u - 10)), []),
    "back out": (
        lambda u: 1 + 2.70158 * (u - 1) ** 3 + 1.70158 * (u - 1) ** 2,
        [(0.370154, 1.071734)],
    ),
    "bounce out": (bounce, BOUNCES),
    "a jump": (lambda u: 0.0, []),
}


def blows(way, rate, begin, known=True, motion="kinematic", last=LAST):
    """Of a box that goes down to the floor from ``begin`` [s] on, within ``last`` seconds."""

    def pose(time):
        u = (time - begin) / last
        matrix = np.eye(4)
        matrix[2, 3] = np.float32(
            0.2 + HEIGHT * (1 - (0.0 if u <= 0 else 1.0 if u >= 1 else way(u)))
        )
        return matrix

    floor = Body("floor", Box((20, 20, 1)), motion="static")
    box = Body("box", Box((0.4, 0.4, 0.4)), MASS, motion=motion)
    tracker = ContactTracker([floor, box], ContactSettings(refractory=0.0))
    (ground,) = np.eye(4)[None].copy()
    ground[2, 3] = -0.5
    count = 8 * math.ceil(1 / rate / 0.0007 / 8)
    step = 1 / rate / count
    found = []
    for frame in range(math.ceil((begin + last) * rate) + 4):
        time = frame / rate
        samples = [pose(time - 1 / rate + (k - 2) * step) for k in range(count + 3)]
        curve = KnownMotion(step, {"box": np.array(samples)}) if known and frame else None
        found += tracker.update(time, np.array([ground, pose(time)]), motion=curve).impacts
    return found


@pytest.mark.parametrize("name", WAYS)
@pytest.mark.parametrize("rate", [24, 25, 30, 60])
def test_blows_come_where_and_as_fast_as_the_motion_touches(name, rate):
    """Whatever the phase of the frames; nothing strikes that comes to rest where it touches."""
    way, touches = WAYS[name]
    for phase in range(8):
        begin = (10 + phase / 8) / rate
        found = blows(way, rate, begin)
        assert len(found) == len(touches)
        for blow, (part, speed) in zip(found, touches, strict=True):
            assert blow.time == pytest.approx(begin + part * LAST, abs=0.0005)
            truth = MASS / 2 * (HEIGHT / LAST * speed) ** 2
            assert blow.energy == pytest.approx(truth, rel=0.02)


@pytest.mark.parametrize("name", [name for name, (_, touches) in WAYS.items() if not touches])
@pytest.mark.parametrize("rate", [24, 25, 30, 60])
@pytest.mark.parametrize(("motion", "last"), [("kinematic", LAST), ("dynamic", 1.0)])
def test_what_brakes_to_rest_strikes_nothing_where_no_curve_is_known(name, rate, motion, last):
    """It slows down as it sped up, or through three poses, and is not yet there."""
    for phase in range(8):
        found = blows(WAYS[name][0], rate, (10 + phase / 8) / rate, False, motion, last)
        assert all(blow.energy <= 0.5 for blow in found)


@pytest.mark.parametrize("rate", [24, 25, 30, 60])
def test_what_bounces_strikes_each_time_where_no_curve_is_known(rate):
    """Each blow is found within a frame, with at most its true energy. The body rises at half the
    speed: where it touches so shortly before a frame that it still touches in it, only the mean
    speed of that frame is known."""
    for phase in range(8):
        begin = (10 + phase / 8) / rate
        found = blows(bounce, rate, begin, known=False, last=1.0)
        for blow, (part, speed) in zip(found[:3], BOUNCES[:3], strict=True):
            assert blow.time == pytest.approx(begin + part, abs=1 / rate)
            late = ContactSettings().tolerance / (HEIGHT * speed / 2) * rate
            part = blow.energy / (MASS / 2 * (HEIGHT * speed) ** 2)
            assert (1 - 1.5 * late) ** 2 < part < 1.01


@pytest.mark.parametrize(
    ("gap", "speed"), [(0.1, 5.0), (0.2, 5.0), (0.25, 4.0), (0.26, None), (0.5, None)]
)
def test_over_a_gap_a_blow_has_the_mean_speed(gap, speed):
    """Gravity adds nothing to it; after more than a quarter of a second nothing strikes."""
    floor = Body("floor", Box((20, 20, 1)), motion="static")
    box = Body("box", Box((0.4, 0.4, 0.4)), MASS)
    tracker = ContactTracker([floor, box], ContactSettings())
    way = (speed or 5.0) * gap
    found, time = [], 0.0
    for step, height in [(0.02, way)] * 5 + [(gap, 0.0)] + [(0.02, 0.0)] * 5:
        time += step
        places = np.tile(np.eye(4), (2, 1, 1))
        places[:, 2, 3] = -0.5, 0.2 + height
        found += tracker.update(time, places).impacts
    expected = [] if speed is None else [MASS / 2 * speed**2]
    assert [blow.energy for blow in found] == pytest.approx(expected, rel=1e-3)


def blows_of_ball(ball, other, places, rate):
    """Of a ball of 0.1 m and another body, by their ``places`` along x and z in each frame."""
    tracker = ContactTracker([ball, other], ContactSettings(refractory=0.0))
    found = []
    for frame, both in enumerate(places):
        transforms = np.tile(np.eye(4), (2, 1, 1))
        transforms[:, (0, 2), 3] = both
        found += tracker.update(frame / rate, transforms).impacts
    return found


@pytest.mark.parametrize("leap", [1.0, -1.0, 0.3])
@pytest.mark.parametrize("phase", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_what_was_set_elsewhere_does_not_strike_at_the_speed_of_its_leap(leap, phase):
    """A ball meets it in the next interval, at its own speed and with the reduced mass of both."""
    rate, leaps, speed, mass = 24, 6, 2.0, 2.0
    ball = Body("ball", Sphere(0.1), mass)
    box = Body("box", Box((0.4, 0.4, 0.4)), MASS, motion="kinematic")
    places = []
    for frame in range(14):
        after = (frame - leaps - phase) / rate
        x = 0.3 + speed * after * (-1.0 if after < 0 else 0.3)
        places.append([(x, 0.0), (-leap if frame < leaps else 0.0, 0.0)])
    (blow,) = blows_of_ball(ball, box, places, rate)
    assert blow.time * rate == pytest.approx(leaps + phase, abs=0.01)
    assert blow.energy == pytest.approx(mass * MASS / (mass + MASS) / 2 * speed**2, rel=0.01)


@pytest.mark.parametrize("phase", [0.2, 0.5, 0.8])
def test_what_flies_on_as_before_strikes_at_its_speed(phase):
    """In the third interval of its flight, of which only the mean speeds are known until then."""
    rate, speed, mass, hits = 24, 3.0, 2.0, 2 + phase
    ball = Body("ball", Sphere(0.1), mass)
    wall = Body("wall", Box((0.2, 40.0, 40.0)), motion="static")
    places = []
    for frame in range(8):
        after = (frame - hits) / rate
        places.append([(speed * after * (1.0 if after < 0 else -0.3) - 0.2, 0.0), (0.0, 0.0)])
    (blow,) = blows_of_ball(ball, wall, places, rate)
    assert blow.time * rate == pytest.approx(hits, abs=0.01)
    assert blow.energy == pytest.approx(mass / 2 * speed**2, rel=0.01)


@pytest.mark.parametrize("phase", [*(k / 8 for k in range(8)), 0.9])
def test_what_falls_from_rest_soon_after_it_is_let_go_strikes_with_its_height(phase):
    """It lands in the next interval, or is let go so shortly before a frame that it has moved by
    less than a millimetre there."""
    rate, mass, height, gravity = 24, 2.0, 0.02, 9.81
    ball = Body("ball", Sphere(0.1), mass)
    floor = Body("floor", Box((20.0, 20.0, 1.0)), motion="static")
    released = (5 + phase) / rate
    lands = released + math.sqrt(2 * height / gravity)
    bounce_speed = 0.3 * math.sqrt(2 * gravity * height)
    places = []
    for frame in range(14):
        fallen, after = frame / rate - released, frame / rate - lands
        z = height - gravity / 2 * max(fallen, 0.0) ** 2
        if after > 0:
            z = max(bounce_speed * after - gravity / 2 * after**2, 0.0)
        places.append([(0.0, 0.1 + z), (0.0, -0.5)])
    blow = blows_of_ball(ball, floor, places, rate)[0]
    assert blow.time == pytest.approx(lands, abs=0.0005)
    assert blow.energy == pytest.approx(mass * gravity * height, rel=0.01)


@pytest.mark.parametrize("rate", [24, 25, 30])
@pytest.mark.parametrize("phase", [k / 8 for k in range(8)])
def test_a_bat_that_eases_in_and_out_strikes_once_where_the_ball_is(rate, phase):
    """While it brakes, with its cubic speed there; of this, six poses a stroke tell most."""
    mass, part = 2.0, 0.85
    way, _ = WAYS["cubic in-out"]
    begin = (6 + phase) / rate
    touch, speed = begin + LAST * part, HEIGHT / LAST * 12 * (1 - part) ** 2
    places = []
    for frame in range(16):
        time = frame / rate
        swing = HEIGHT * way(min(max((time - begin) / LAST, 0.0), 1.0))
        flown = 1.5 * speed * max(time - touch, 0.0)
        places.append([(HEIGHT * way(part) + 0.3 + flown, 0.0), (swing, 0.0)])
    ball = Body("ball", Sphere(0.1), mass)
    bat = Body("bat", Box((0.4, 0.4, 0.4)), MASS, motion="kinematic")
    (blow,) = blows_of_ball(ball, bat, places, rate)
    assert blow.time == pytest.approx(touch, abs=0.15 / rate)
    found = math.sqrt(2 * blow.energy * (mass + MASS) / (mass * MASS))
    assert 0.45 * speed < found < 1.2 * speed
