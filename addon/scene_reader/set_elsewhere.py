"""Bodies that keyframes teleport: in the next frame they are elsewhere, and did not move there."""

from __future__ import annotations

from itertools import compress
from typing import Any

import numpy as np
from bpy.types import Object, Scene

from ...core.contacts.settings import Motion
from ...core.contacts.shapes import transformed_bounds
from ..blender.compatibility import fcurves_of
from ..blender.full_names import object_named
from ..blender.time import frame_seconds, stretching
from .digest import with_movers
from .known_motion import transforms_before
from .plain_values import TRANSFORM
from .reading import Reading

_SLOW = 1.0
"""Speed up to which a body moves, whatever its curves [m/s]."""
_PARTS = 16
"""Parts of the time between two frames; a curve jumps that changes in one of them alone."""
_MOST = 0.9
"""Part of its change from which on that is so."""


def set_elsewhere(
    scene: Scene, since: int, frame: int, before: Reading, now: Reading
) -> frozenset[str]:
    """Names of the bodies that keys have set elsewhere in a ``frame``, read as ``now``, since the
    frame ``since``, whose reading is ``before``: those that lie clear of where they
    were, and of which a curve of their place, or of what they follow, jumps, as by constant
    interpolation, or where a cycle begins again."""
    known = transforms_before(before, now)
    way = now.transforms[:, :3, 3] - known[:, :3, 3]
    frames = frame - since
    fast = (way * way).sum(axis=1) > (_SLOW * frames * frame_seconds(scene)) ** 2
    rows = np.array(
        [k for k in fast.nonzero()[0].tolist() if now.bodies[k].motion is not Motion.DYNAMIC],
        dtype=np.int64,
    )
    if not len(rows):
        return frozenset()
    bodies = [now.bodies[k] for k in rows.tolist()]
    bounds = np.array([body.shape.local_bounds for body in bodies])
    low, high = np.stack(
        [transformed_bounds(bounds, poses[rows]) for poses in (known, now.transforms)], axis=2
    ).transpose(1, 2, 0, 3)
    apart = (low > high[::-1]).any(axis=(0, 2))
    span = since / stretching(scene), frame / stretching(scene)
    return frozenset(
        body.name
        for body in compress(bodies, apart.tolist())
        if (obj := object_named(body.name)) is not None and _jumps(obj, *span)
    )


def _jumps(obj: Object, begin: float, end: float) -> bool:
    """Whether any curve that places an object, or what it follows, jumps between two frames."""
    return any(
        _jumps_within(curve, begin, end)
        for mover in with_movers([obj])
        for curve in fcurves_of(mover)
        if not curve.mute
        and (curve.data_path in TRANSFORM or curve.data_path.startswith("constraints["))
    )


def _jumps_within(curve: Any, begin: float, end: float) -> bool:
    steps = np.abs(np.diff([curve.evaluate(t) for t in np.linspace(begin, end, _PARTS + 1)]))
    return bool(steps.max() > _MOST * steps.sum() > 0)
