"""``haptic-tracing export SCENE.json --to FORMATS --out FOLDER``: the listeners' tracks of a haptic
scene in the formats of other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TextIO

from ..core.diagnosis.doubts import doubts
from ..core.formats import registry
from ..core.formats.export import Export
from ..core.formats.io.catalogue import Value, formats, named, value_of
from ..core.formats.io.file_names import file_stem
from ..core.formats.tracks.track_recorder import TrackRecorder
from ..core.forms import JsonObject
from ..core.run_time import Scene, load
from . import print_json, say
from .picture import check_matplotlib, write_picture
from .silence import silent_listeners
from .standard_streams import DASH, folder, put_out

LONGEST = 3600.0
"""Seconds."""


def run(args: argparse.Namespace) -> int:
    """Read, render missing tracks, write, print. Returns exit code 0."""
    if not args.to and not args.methods:
        raise ValueError(f"--to: say at least one of {', '.join(formats())}")
    names = chosen_formats(args.to) if args.to else []
    chosen = chosen_options(args.options, names)
    if not 0 < args.seconds <= LONGEST:
        raise ValueError(
            f"--seconds: must be above 0 and at most {LONGEST:g}, not {args.seconds:g}"
        )
    scene = load(args.scene)
    export = scene.export
    say(f"{args.scene}: {words}" for words in doubts(scene.content))
    if args.methods:
        if args.json:
            print_json({"methods": export.methods()}, args.stdout)
        else:
            print(export.methods(), file=args.stdout)
        return 0
    if names != ["scene"]:
        export = rendered(scene, args.seconds, args.sample_rate)
    if args.losses:
        losses = {name: registry.losses(name, export, chosen[name]) for name in names}
        print_json({"losses": losses}, args.stdout)
        return 0
    names = writable(args.to, names, export, chosen)
    if args.out == DASH:
        return _put_out(export, names, chosen, args)
    args.out.mkdir(parents=True, exist_ok=True)
    if args.picture:
        check_matplotlib("--picture")
    written = {
        name: registry.write(name, export, args.out, chosen[name], may_replace) for name in names
    }
    if args.picture and export.tracks is not None:
        written = {
            name: _with_picture(name, export, result, args.out) for name, result in written.items()
        }
    print_written(written, args.stdout)
    return 0


def _put_out(
    export: Export,
    names: Sequence[str],
    options: Mapping[str, Mapping[str, Value]],
    args: argparse.Namespace,
) -> int:
    """Write the one file of an export to standard output, and what it loses to stderr."""
    written = {name: registry.write(name, export, folder(), options[name]) for name in names}
    put_out([path for result in written.values() for path in result.files], args.stdout)
    say(loss for result in written.values() for loss in result.losses)
    return 0


def may_replace(written: registry.Written) -> bool:
    """Ask on the terminal whether files are replaced by ones that keep little of the vibration;
    True without a terminal."""
    if not sys.stdin.isatty():
        return True
    names = ", ".join(path.name for path in written.files[:3])
    print(
        *written.losses, f"Replace {names}? [y/N] ", sep="\n", end="", file=sys.stderr, flush=True
    )
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _with_picture(
    name: str, export: Export, written: registry.Written, folder: Path
) -> registry.Written:
    path = write_picture(name, export.need_tracks(), written, folder, file_stem(export.name))
    return written if path is None else replace(written, files=(*written.files, path))


def chosen_formats(text: str) -> list[str]:
    """The formats in ``text``, each once; ``all`` are all of them."""
    return list(formats()) if text == "all" else list(dict.fromkeys(text.split(",")))


def writable(
    text: str, names: Sequence[str], export: Export, options: Mapping[str, Mapping[str, Value]]
) -> list[str]:
    """The formats ``names``, as chosen by ``text``; of ``all`` those that can be written, and a
    line for each other one."""
    found = []
    for name in names:
        try:
            registry.losses(name, export, options[name])
        except ValueError as error:
            if text != "all":
                raise
            say([f"{name}: {error}"])
        else:
            found.append(name)
    return found


def write_all(
    export: Export,
    args: argparse.Namespace,
    options: Mapping[str, Mapping[str, Value]],
) -> JsonObject:
    """Write an export in each format, and print the files and what is not in them; `in_json`."""
    written = {}
    for name in writable(args.to, list(options), export, options):
        written[name] = result = registry.write(name, export, args.out, options[name])
        for path in result.files:
            print(f"wrote {path}")
        for loss in result.losses:
            print(f"not in {name}: {loss}")
    return in_json(written)


def chosen_options(settings: list[str], names: list[str]) -> dict[str, dict[str, Value]]:
    """The options of each format from ``format.option=value``. Raises ValueError for unknown names
    and values out of range."""
    chosen: dict[str, dict[str, Value]] = {name: {} for name in names}
    known = {name: named(name).options for name in names}
    for setting in settings:
        key, equals, text = setting.partition("=")
        name, _, option = key.partition(".")
        if not equals or option not in known.get(name, {}):
            offered = ", ".join(
                f"{name}.{option}" for name, entries in known.items() for option in entries
            )
            raise ValueError(
                f"{setting}: expected FORMAT.OPTION=VALUE"
                + (f" with one of {offered}" if offered else "")
            )
        try:
            chosen[name][option] = value_of(known[name][option], text)
        except ValueError as error:
            raise ValueError(f"{setting}: {error}") from None
    return chosen


def print_written(written: Mapping[str, registry.Written], file: TextIO) -> None:
    """Print one JSON object: `in_json`."""
    print_json(in_json(written), file)


def in_json(written: Mapping[str, registry.Written]) -> JsonObject:
    """The files of an export, their losses, and what each listener loses, as JSON values."""
    files = [str(path) for result in written.values() for path in result.files]
    losses = {name: result.losses for name, result in written.items()}
    listeners = {
        name: [asdict(item) for item in result.fidelity.listeners]
        for name, result in written.items()
        if result.fidelity
    }
    return {"files": files, "losses": losses, "listeners": listeners}


def rendered(scene: Scene, seconds: float, sample_rate: int) -> Export:
    """What a scene's file holds, with its tracks, which are rendered if it has none. Prints why a
    listener feels nothing."""
    export = scene.export
    if export.tracks is not None or not scene.content.listeners:
        return export
    recorder, last = TrackRecorder(), None
    for last in scene.frames(seconds, sample_rate):
        recorder.add(last)
    tracks = recorder.tracks()
    if last is not None:
        settings = scene.content.settings
        say(f"{export.name}: {words}" for words in silent_listeners(tracks, last, settings))
    return replace(export, tracks=tracks)
