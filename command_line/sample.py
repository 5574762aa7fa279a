"""``haptic-tracing sample NAME``: builds a sample scene, bakes its rigid bodies and saves it as a Blender file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..sample_scenes import SAMPLES


def add_parser(subparsers: Any) -> None:
    """Add the command to the program's."""
    names = "\n".join(f"  {sample.name.ljust(18)} {sample.description}" for sample in SAMPLES.values())
    parser = subparsers.add_parser(
        "sample",
        help="build a sample scene as a .blend file",
        description=__doc__,
        epilog=f"samples:\n{names}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("name", metavar="NAME", choices=tuple(SAMPLES), help="one of the samples below")
    parser.add_argument("--output", type=Path, metavar="FILE.blend", help="where to save it (NAME.blend)")
    counted = " and ".join(f"{sample.name} ({sample.count})" for sample in SAMPLES.values() if sample.count)
    parser.add_argument("--count", type=int, metavar="N", help=f"how many things, for {counted}")
    parser.add_argument("--no-bake", action="store_true", help="leave the rigid bodies to be simulated when the file is played")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Build, bake, save. Exit code 0."""
    output = args.output or Path(f"{args.name}.blend")
    if output.suffix != ".blend":
        raise ValueError(f"{output}: a Blender file's name ends in .blend")
    if not output.resolve().parent.is_dir():
        raise ValueError(f"{output}: there is no folder {output.resolve().parent}")
    try:
        import bpy
    except ImportError:
        raise ValueError("this needs Blender as a Python module: pip install bpy (its version decides the Python version)") from None
    from ..addon.registration import properties
    from ..sample_scenes.baking import bake_rigid_bodies

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
