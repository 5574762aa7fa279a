"""``haptic-tracing bake FILE.blend``: plays a Blender file with its physics and writes the
listeners' tracks in the formats of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from bpy.types import Scene

from ..addon.io.capture import Capture
from ..addon.session import session
from ..core.formats.export import Export
from ..core.scene.values import Mode
from . import answer, say
from .export import chosen_formats, chosen_options, write_all
from .frame_bar import frame_bar
from .part import write_parts_of
from .setting import assign
from .silence import silent_listeners
from .trace import open_file, start_blender


def run(args: argparse.Namespace) -> int:
    """Open the file, play it once in each mode, write the tracks, and print their losses. Returns
    exit code 0."""
    formats = chosen_formats(args.to)
    options = chosen_options(args.options, formats)
    modes = _chosen_modes(args.modes)
    start_blender()
    scene = open_file(args.file)
    for setting in args.set:
        assign(scene, setting)
    frames = args.frames or (scene.frame_start, scene.frame_end)
    args.out.mkdir(parents=True, exist_ok=True)
    stem, results = Path(args.file).stem, []
    for mode in modes or [scene.haptics.mode]:
        scene.haptics.mode = mode
        name = f"{stem}.{mode}" if len(modes) > 1 else stem
        if args.part:
            parts = [str(path) for path in write_parts_of(scene, args, name, frames)]
            results.append({"name": name, "mode": mode, "parts": parts})
            continue
        export = _bake(scene, name, frames, recorded="scene" in formats)
        result = {"name": name, "mode": mode, **write_all(export, args, options)}
        if args.methods:
            result["methods"] = export.methods()
            print(result["methods"])
        results.append(result)
    answer(args, {"bakes": results})
    return 0


def _chosen_modes(text: str) -> list[str]:
    """The modes in ``text``, without duplicates; [] for the file's own."""
    modes = list(dict.fromkeys(text.split(","))) if text else []
    for mode in modes:
        if mode not in list(Mode):
            raise ValueError(f"--modes: must be some of {', '.join(Mode)}, not {mode}")
    return modes


def _bake(scene: Scene, name: str, frames: tuple[int, int], recorded: bool) -> Export:
    """The tracks of a range in the scene's mode; ``recorded``: with the scene itself. Prints why a
    listener feels nothing."""
    work, own = Capture(scene, *frames, recorded, felt=True), session.of(scene)
    result, settings = None, None
    with frame_bar(work.frames, name) as advance:
        for _ in work.steps():
            result, settings = own.result, own.reading.settings if own.reading is not None else None
            advance()
    export = work.export(name)
    if export.tracks is not None and result is not None and settings is not None:
        say(f"{name}: {words}" for words in silent_listeners(export.tracks, result, settings))
    return export
