"""``haptic-tracing engine FILE.blend``: writes a Blender file for an engine, as glTF, with its
haptics."""

from __future__ import annotations

import argparse
from pathlib import Path

import bpy

from . import answer
from .trace import open_file, start_blender


def run(args: argparse.Namespace) -> int:
    """Open the file, and write the files. Exit code 0."""
    start_blender()
    scene = open_file(args.file)
    start, end = args.frames or (scene.frame_start, scene.frame_end)
    args.out.mkdir(parents=True, exist_ok=True)
    path = args.out / f"{Path(args.file).stem}.glb"
    try:
        bpy.ops.export_scene.haptic_engine(filepath=str(path), frame_start=start, frame_end=end)
    except RuntimeError as error:
        raise ValueError(str(error).strip().removeprefix("Error: ")) from None
    files = [str(path), str(path.with_suffix(".json"))]
    print("\n".join(f"wrote {path}" for path in files))
    answer(args, {"files": files})
    return 0
