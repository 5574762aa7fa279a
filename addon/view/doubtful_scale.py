"""Whether the sizes of a scene's objects or their number without a contact let one doubt its unit
scale."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
from bpy.types import Scene

from ..session.derived import Derived
from ..session.sessions import Traced

_LARGEST = {
    **dict.fromkeys(("bolt", "screw", "finger", "cup", "bottle", "hand"), 2.0),
    **dict.fromkeys(("chair", "piston", "keyboard", "pedal"), 5.0),
    **dict.fromkeys(("door", "engine", "gear", "motor", "robot", "sofa", "table", "wheel"), 20.0),
}
"""Sizes [m] beyond which hardly anything is called so."""
_MANY = 1000

Doubt = tuple[str, float]
"""The word for what is too large and its size [m], or "" and the number of objects of which none
touch."""


def _doubt(traced: Traced, *_: object) -> Doubt | None:
    """Why the unit scale is doubtful: a word of an object's name, and its size [m], which is too
    large for that; or "" and the number of objects, none of which touch. None if nothing is.
    Computed on the worker.

    A word that half of the objects have in their names counts for all of them together."""
    reading = traced.reading
    if reading is None or not reading.bodies:
        return None
    if len(reading.bodies) >= _MANY and not len(traced.result.contacts):
        return "", len(reading.bodies)
    across = float(np.ptp(reading.transforms[:, :3, 3], axis=0).max())
    counts: Counter[str] = Counter()
    for body in reading.bodies:
        for word in _LARGEST.keys() & set(re.findall("[a-z]+", body.name.lower())):
            counts[word] += 1
            size = float(np.ptp(body.shape.local_bounds, axis=0).max())
            if size > _LARGEST[word]:
                return word, size
    for word, count in counts.items():
        if 2 * count >= len(reading.bodies) and across > _LARGEST[word]:
            return word, across
    return None


_DOUBT: Derived[None, Doubt | None] = Derived(_doubt)


def doubt(scene: Scene) -> Doubt | None:
    """Why the unit scale is doubtful, as computed last, without waiting."""
    latest = _DOUBT.latest(scene, None)
    return None if latest is None else latest.value
