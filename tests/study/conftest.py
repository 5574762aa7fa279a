"""Blender as a module, with the add-on registered once for the tests of a module."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

# Keep this machine's own extensions and preferences out; must be set before bpy is imported.
os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="haptic-tracing-blender-"))

import bpy
import haptic_tracing
import pytest


@pytest.fixture(scope="module")
def mine_ride() -> Iterator[Any]:
    """The scene of the ride, in a file of its own."""
    from haptic_tracing.addon.changes.suspension import suspended
    from haptic_tracing.sample_scenes import build_sample

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    with suspended():
        scene = build_sample("mine_ride")
        scene.rigidbody_world.enabled = False  # all of it moves by keys: nothing has to be simulated up to the frames wanted
    yield scene
    haptic_tracing.unregister()


@pytest.fixture(scope="module")
def bake(mine_ride: Any) -> Callable[[int, int], Any]:
    """Bakes frames of the ride in all four modes; the same range only once."""
    from haptic_tracing.study.baking import bake_ride

    done: dict[tuple[int, int], Any] = {}

    def baked(first: int, last: int) -> Any:
        if (first, last) not in done:
            done[first, last], _ = bake_ride(mine_ride, first, last)
        return done[first, last]

    return baked
