"""Where one body of many moves, contacts of the others are kept: the same as found anew."""

import numpy as np
from haptic_tracing.core.contacts.authored import ARRAYS
from haptic_tracing.core.contacts.settings import Body, ContactSettings, Motion
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.scene.values import HapticObject, Settings
from haptic_tracing.core.tracer import Frame, Tracer

SIDE = 5
NAMES = [f"box {number:02d}" for number in range(SIDE**2)]
OBJECTS = tuple(HapticObject(name, 0.1, 0.9) for name in NAMES)
BODIES = tuple(Body(name, Box((1, 1, 1)), None, Motion.KINEMATIC) for name in NAMES)


def test_contacts_are_those_found_anew():
    places = np.tile(np.eye(4), (len(NAMES), 1, 1))
    places[:, :2, 3] = np.argwhere(np.ones((SIDE, SIDE)))
    followed = Tracer(ContactSettings())
    for number in range(6):
        places = places.copy()
        mover = (7 * number) % len(NAMES)
        places[mover, :3, 3] += (0.0, 0.0, 0.01)
        if number == 4:
            places[0, 2, 3] = 3.0  # its contacts end
        frame = Frame(number, number / 24, OBJECTS, (), (), Settings(), BODIES, places, heard=False)
        found = followed.step(frame).contacts
        anew = Tracer(ContactSettings()).step(frame).contacts
        assert len(found) > 40
        for key in ARRAYS:
            assert np.array_equal(getattr(found, key), getattr(anew, key)), (number, key)
