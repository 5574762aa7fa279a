"""Exact frames hold nothing of what hardly moves: what follows one is the same with and without the
frames before it."""

import numpy as np
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.events.frame import EXACT_FRAMES, Frame
from haptic_tracing.core.scene.values import HapticObject, Listener, Source
from haptic_tracing.core.tracer import Tracer

FRAMES = range(1, EXACT_FRAMES + 12)
BODIES = (Body("cart", Box((4.0, 4.0, 1.0)), 100.0), Body("load", Box((1.0, 1.0, 1.0)), 10.0))
OBJECTS = tuple(HapticObject(body.name, kappa=0.2, rho=0.9) for body in BODIES)


def frame(number, exact):
    """A load rides on a cart: their relative motion is rounding, and the load trembles by a tenth
    of what counts as motion."""
    place = np.array([0.37 * number, 0.011 * number, 0.5])
    transforms = np.tile(np.eye(4), (2, 1, 1))
    transforms[0, :3, 3] = place
    transforms[1, :3, 3] = (
        place + [0.1, 0.2, 1.0] + 1e-13 * np.sin(number * np.array([1.0, 2.0, 3.0]))
    )
    top = tuple((transforms[1, :3, 3] + [0.0, 0.0, 0.5]).tolist())
    return Frame(
        number=number,
        time=number / 24,
        objects=OBJECTS,
        sources=(Source("motor", "cart", tuple(place.tolist())),),
        listeners=(Listener("hand", "load", top, radius=0.0),),
        bodies=BODIES,
        transforms=transforms,
        exact=exact,
    )


def traced(first, exact):
    """Contacts' positions, gains and the tracer's checksum by frame, from ``first`` on."""
    tracer, found = Tracer(), {}
    for number in range(first, FRAMES.stop):
        result = tracer.step(frame(number, exact and number % EXACT_FRAMES == 0))
        assert len(result.contacts) == 1
        found[number] = (
            result.contacts.positions.tobytes(),
            result.amplitudes.tobytes(),
            tracer.checksum(),
        )
    return found


def test_frames_after_an_exact_one_do_not_depend_on_those_before():
    whole, later = traced(FRAMES.start, exact=True), traced(EXACT_FRAMES, exact=True)
    for number, (positions, gains, checksum) in later.items():
        assert whole[number][:2] == (positions, gains)
        # Motion is estimated from the last poses.
        assert number < EXACT_FRAMES + 6 or whole[number][2] == checksum


def test_without_exact_frames_they_do():
    whole, later = traced(FRAMES.start, exact=False), traced(EXACT_FRAMES, exact=False)
    assert any(whole[number][0] != later[number][0] for number in later)
