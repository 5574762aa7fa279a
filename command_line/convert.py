"""``haptic-tracing convert IN OUT``: a vibration, or a haptic scene, from one format to another, told by the endings."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.formats import haptic_scene, registry
from ..core.formats.export import Export
from ..core.formats.io.catalogue import named
from . import warn_of_unknown
from .export import chosen_options, may_replace, print_written

SAMPLE_RATE = 8000


def run(args: argparse.Namespace) -> int:
    """Read, write, print. Exit code 0."""
    folder = args.target.parent
    if is_scene(args.source):
        if not is_scene(args.target):
            raise ValueError(f"{args.target}: a haptic scene becomes a haptic scene; to render it, use export")
        export = haptic_scene.read_export(args.source)
        warn_of_unknown(args.source, export.unknown)
        tracks = "none" if export.tracks is None else "inline"
        files = haptic_scene.write_export(export, args.target, tracks=tracks, encoding="float32")
        print_written({"scene": registry.Written(tuple(files), ())})
        return 0
    names = {named(name).suffix: name for name in registry.FORMATS if name != "scene"}
    if args.target.suffix.lower() not in names:
        raise ValueError(f"{args.target}: can't be written: the ending must be one of {', '.join(names)}")
    name = names[args.target.suffix.lower()]
    reading = registry.read(args.source)
    try:
        export = Export(args.target.stem, tracks=reading.to_tracks())
    except ValueError as error:
        raise ValueError(f"{args.source}: {error}") from None
    written = registry.write(name, export, folder, chosen_options(args.options, [name])[name], may_replace)
    lost = tuple(f"{args.source.name}: {loss}" for loss in reading.losses)
    print_written({name: registry.Written(written.files, (*lost, *written.losses))})
    return 0


def is_scene(path: Path) -> bool:
    """Whether the ending is that of a haptic scene."""
    return path.name.lower().endswith((".json", ".json.gz"))
