"""``haptic-tracing sample NAME``: builds a sample scene, bakes its rigid bodies and saves it as a Blender file."""

from __future__ import annotations

import argparse
from pathlib import Path

import bpy

from ..addon.registration import properties
from ..sample_scenes import SAMPLES
from ..sample_scenes.baking import bake_rigid_bodies


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
            bake_rigid_bodies(scene)
        bpy.ops.wm.save_as_mainfile(filepath=str(output.resolve()), compress=True, check_existing=False)
    except RuntimeError as error:
        raise ValueError(f"{output}: {str(error).strip().removeprefix('Error: ')}") from None
    finally:
        properties.unregister()
    print(f"wrote {output}")
    return 0
