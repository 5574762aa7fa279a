"""Blender as a module, with the add-on registered once for the tests of a module."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import bpy
import haptic_tracing
import pytest


@pytest.fixture(scope="session")
def ride_file(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The scene of the ride as a .blend file, built once."""
    from haptic_tracing.addon.changes.suspension import suspended
    from haptic_tracing.sample_scenes import build_sample

    path = str(tmp_path_factory.mktemp("ride") / "mine_ride.blend")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    with suspended():
        scene = build_sample("mine_ride")
        # All of it moves by keys: nothing has to be simulated up to the frames wanted.
        scene.rigidbody_world.enabled = False
    bpy.ops.wm.save_as_mainfile(filepath=path)
    haptic_tracing.unregister()
    return path


@pytest.fixture(scope="module")
def mine_ride(ride_file: str) -> Iterator[Any]:
    """The scene of the ride, in a file of its own."""
    haptic_tracing.register()
    bpy.ops.wm.open_mainfile(filepath=ride_file)
    yield bpy.context.scene
    haptic_tracing.unregister()


@pytest.fixture(scope="session")
def baked() -> dict[tuple[int, int], Any]:
    """What was baked of the ride as it is in its file, by first and last frame."""
    return {}


@pytest.fixture(scope="module")
def bake(
    request: pytest.FixtureRequest, baked: dict[tuple[int, int], Any]
) -> Callable[[int, int], Any]:
    """Bakes frames of the ride in all four modes; the same range only once."""
    from haptic_tracing.study.baking import bake_ride

    def of(first: int, last: int) -> Any:
        if (first, last) not in baked:
            baked[first, last], _ = bake_ride(request.getfixturevalue("mine_ride"), first, last)
        return baked[first, last]

    return of
