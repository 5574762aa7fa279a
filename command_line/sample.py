"""``haptic-tracing sample NAME``: builds a sample scene, bakes its rigid bodies and saves it as a
Blender file."""

from __future__ import annotations

import argparse
from pathlib import Path

import bpy
from bpy.types import Scene

from ..addon.changes.suspension import suspended
from ..addon.registration import properties
from ..sample_scenes import SAMPLES
from . import answer


def run(args: argparse.Namespace) -> int:
    """Build, bake, save. Exit code 0."""
    output = args.output or Path(f"{args.name}.blend")
    if output.suffix != ".blend":
        raise ValueError(f"{output}: a Blender file's name ends in .blend")
    if not output.resolve().parent.is_dir():
        raise ValueError(f"{output}: there is no folder {output.resolve().parent}")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    properties.register()
    try:
        scene = bpy.context.scene
        scene.name = SAMPLES[args.name].title
        SAMPLES[args.name].build(scene, args.count)
        if not args.no_bake:
            _bake_rigid_bodies(scene)
        bpy.ops.wm.save_as_mainfile(
            filepath=str(output.resolve()), compress=True, check_existing=False
        )
    except RuntimeError as error:
        raise ValueError(f"{output}: {str(error).strip().removeprefix('Error: ')}") from None
    finally:
        properties.unregister()
    print(f"wrote {output}")
    answer(args, {"files": [str(output)]})
    return 0


def _bake_rigid_bodies(scene: Scene) -> None:
    """Simulate all frames of the window's scene and keep the result in its cache.

    A scene without a rigid body world is left alone.
    """
    if scene.rigidbody_world is None:
        return
    cache = scene.rigidbody_world.point_cache
    with suspended():
        for frame in range(cache.frame_start, cache.frame_end + 1):
            scene.frame_set(frame)
        with bpy.context.temp_override(scene=scene, point_cache=cache):
            bpy.ops.ptcache.bake_from_cache()
        scene.frame_set(scene.frame_start)
