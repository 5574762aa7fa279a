"""The export of a Blender file, which is played with its physics, once in each mode; and the parts
of such exports."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path

from bpy.types import Scene

from ..addon.io.capture import Capture
from ..addon.session import session
from ..core.formats.export import Export
from ..core.scene.values import Mode
from . import say
from .frame_bar import frame_bar
from .part import write_parts_of
from .setting import assign
from .silence import silent_listeners
from .standard_streams import DASH
from .trace import open_file, start_blender


def exports(args: argparse.Namespace, formats: Sequence[str]) -> Iterator[Export]:
    """The tracks in each mode, with the recorded scene if it is among the formats."""
    for scene, name, frames in _played(args):
        yield _export(scene, name, frames, recorded="scene" in formats)


def write_parts(args: argparse.Namespace) -> list[Path]:
    """Write the parts that are asked for, in each mode; their files."""
    return [
        path
        for scene, name, frames in _played(args)
        for path in write_parts_of(scene, args, name, frames)
    ]


def write_files(args: argparse.Namespace, module: str) -> list[Path]:
    """Let a plug-in's module write the file in each mode; the files."""
    write = import_module(module).write
    return [
        path
        for scene, name, frames in _played(args)
        for path in write(scene, *frames, args.out / name)
    ]


def _played(args: argparse.Namespace) -> Iterator[tuple[Scene, str, tuple[int, int]]]:
    """The opened scene in each mode, with the name of what is written and the range of frames."""
    modes = list(dict.fromkeys(args.modes.split(","))) if args.modes else []
    for mode in modes:
        if mode not in list(Mode):
            raise ValueError(f"--modes: must be some of {', '.join(Mode)}, not {mode}")
    (file,) = args.files
    start_blender()
    scene = open_file(file)
    for setting in args.set:
        assign(scene, setting)
    if args.out != DASH:  # before the long part, in case it can't be made
        args.out.mkdir(parents=True, exist_ok=True)
    frames = args.frames or (scene.frame_start, scene.frame_end)
    for mode in modes or [scene.haptics.mode]:
        scene.haptics.mode = mode
        yield scene, f"{file.stem}.{mode}" if len(modes) > 1 else file.stem, frames


def _export(scene: Scene, name: str, frames: tuple[int, int], recorded: bool) -> Export:
    """The tracks of a range in the scene's mode; ``recorded``: with the scene itself. Prints why a
    listener feels nothing."""
    work, own = Capture(scene, *frames, recorded, felt=True), session.of(scene)
    result, settings = None, None
    with frame_bar(work.frames + 1, name) as advance:
        for _ in work.steps():
            result, settings = own.result, own.reading.settings if own.reading is not None else None
            advance()
    export = work.export(name)
    if export.tracks is not None and result is not None and settings is not None:
        say(f"{name}: {words}" for words in silent_listeners(export.tracks, result, settings))
    return export
