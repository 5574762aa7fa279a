"""First blows of turning bodies: one motion, sampled at several frame rates."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.contacts.tracker import ContactTracker
from thrown_bodies import RATE, Thrown, thrown


@cache
def bodies() -> list[Thrown]:
    return [thrown(number) for number in range(100)]


@pytest.mark.slow
@pytest.mark.parametrize("rate", [30, 60, 120])
@pytest.mark.parametrize("ground", [8.0, 500.0])
def test_first_blows_of_thrown_bodies(rate, ground):
    """None above 5 J is missed and none comes before it, whatever the size of the ground."""
    found = []
    for body in bodies():
        floor = Body("ground", Box((ground, ground, 1)), motion="static")
        tracker = ContactTracker([floor, Body("body", body.shape, body.mass)], ContactSettings())
        impacts, place = [], np.tile(np.eye(4), (2, 1, 1))
        place[0, 2, 3] = -0.5
        for frame in range(0, len(body.poses), RATE // rate):
            place[1] = body.poses[frame].astype(np.float32)
            impacts += tracker.update(frame / RATE, place.copy()).impacts
        assert body.energy > 5.25
        found.append(
            (impacts[0].time - body.time, impacts[0].energy / body.energy - 1)
            if impacts
            else (np.inf, np.inf)
        )
    late, error = np.abs(found).T
    # Half a substep of Blender's physics, 10 a frame at 24 frames a second.
    assert late.max() <= 1 / 240 / 2
    assert error.max() <= 0.05
