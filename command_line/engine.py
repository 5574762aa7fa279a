"""``haptic-tracing engine FILE.blend``: writes a Blender file for an engine, as glTF, with its
haptics and a baked pack."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..addon.io.engine import EngineExport
from . import answer
from .frame_bar import frame_bar
from .trace import open_file, start_blender


def run(args: argparse.Namespace) -> int:
    """Open the file, play it, and write the files. Exit code 0."""
    start_blender()
    scene = open_file(args.file)
    start, end = args.frames or (scene.frame_start, scene.frame_end)
    args.out.mkdir(parents=True, exist_ok=True)
    name = Path(args.file).stem
    work = EngineExport(scene, start, end, args.out / name, not args.no_pack)
    with frame_bar(end - start + 1, name) as advance:
        for _ in work.steps():
            advance()
    files = [str(path) for path in work.write()]
    print("\n".join(f"wrote {path}" for path in files))
    answer(args, {"files": files})
    return 0
