"""``haptic-tracing export SCENE.json --to FORMATS --out FOLDER``: what the listeners of a haptic scene feel, in the formats of others."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core.formats.export import Export
    from ..core.formats.io.options import Value
    from ..core.render.frame_result import FrameResult
    from ..core.scene.values import HapticScene

STILL_RATE = 30
"""Frames a second in which a scene without frames is traced."""
LONGEST = 3600.0
"""Seconds."""


def add_parser(subparsers: Any) -> None:
    """Add the command to the program's."""
    parser = subparsers.add_parser("export", help="write a haptic scene in other formats", description=__doc__)
    parser.add_argument("scene", help="haptic scene, .json or .json.gz")
    formats = "scene, wav, ohm, hjif, wyvrn, haptic, ahap, tact, hla, csv, npz, or all"
    parser.add_argument("--to", required=True, metavar="FORMAT,...", help=formats)
    parser.add_argument("--out", default="out", type=Path, metavar="FOLDER", help="where the files are written (out)")
    add_option_argument(parser)
    parser.add_argument("--seconds", type=float, default=10.0, metavar="X", help="how long a scene without frames is rendered (10)")
    parser.add_argument("--sample-rate", type=int, default=8000, metavar="HZ", help="of the rendered tracks (8000)")
    parser.add_argument("--losses", action="store_true", help="only say what the formats can't carry")
    parser.set_defaults(run=run)


def add_option_argument(parser: argparse.ArgumentParser) -> None:
    """``--set``, for the options of formats."""
    parser.add_argument("--set", action="append", default=[], metavar="FORMAT.OPTION=VALUE", help="an option of a format", dest="options")


def run(args: argparse.Namespace) -> int:
    """Read, render what is not in the file, write, print. Exit code 0."""
    from ..core.formats import registry
    from ..core.formats.haptic_scene import read_export
    from . import warn_of_unknown

    names = list(registry.FORMATS) if args.to == "all" else list(dict.fromkeys(args.to.split(",")))
    chosen = chosen_options(args.options, names)
    if not 0 < args.seconds <= LONGEST:
        raise ValueError(f"--seconds: must be above 0 and at most {LONGEST:g}, not {args.seconds:g}")
    export = read_export(args.scene)
    warn_of_unknown(args.scene, export.unknown)
    if export.tracks is None and export.need_scene().listeners and names != ["scene"]:
        export = replace(export, tracks=_rendered(export, args.seconds, args.sample_rate))
    if args.losses:
        print(json.dumps({"losses": {name: registry.losses(name, export, chosen[name]) for name in names}}, ensure_ascii=False, indent=1))
        return 0
    args.out.mkdir(parents=True, exist_ok=True)
    written = {name: registry.write(name, export, args.out, chosen[name]) for name in names}
    print_written(written)
    return 0


def chosen_options(settings: list[str], names: list[str]) -> dict[str, dict[str, Value]]:
    """The options of each format from ``format.option=value``. Raises ValueError that names what is unknown or out of range."""
    from ..core.formats.io.catalogue import named

    chosen: dict[str, dict[str, Value]] = {name: {} for name in names}
    known = {name: {option.name: option for option in named(name).options} for name in names}
    for setting in settings:
        key, equals, text = setting.partition("=")
        name, _, option = key.partition(".")
        if not equals or option not in known.get(name, {}):
            offered = ", ".join(f"{name}.{option}" for name, entries in known.items() for option in entries)
            raise ValueError(f"--set {setting}: expected FORMAT.OPTION=VALUE" + (f" with one of {offered}" if offered else ""))
        try:
            chosen[name][option] = known[name][option].parse(text)
        except ValueError as error:
            raise ValueError(f"--set {setting}: {error}") from None
    return chosen


def print_written(written: dict[str, Any]) -> None:
    """One JSON object: the files, and what they can't carry."""
    files = [str(path) for result in written.values() for path in result.files]
    print(json.dumps({"files": files, "losses": {name: result.losses for name, result in written.items()}}, ensure_ascii=False, indent=1))


def _rendered(export: Export, seconds: float, sample_rate: int) -> Any:
    from ..core.formats.scene.recording import traced
    from ..core.formats.tracks.track_recorder import recorded_tracks

    scene = export.need_scene()
    if export.recording is not None:
        return recorded_tracks(traced(scene, export.recording, sample_rate))
    return recorded_tracks(_still(scene, seconds, sample_rate))


def _still(scene: HapticScene, seconds: float, sample_rate: int) -> Iterator[FrameResult]:
    """The frames of a scene in which nothing moves."""
    from ..core.contacts.scene_contacts import contacts_of_scene
    from ..core.formats.scene.recording import frame_of
    from ..core.tracer import Tracer

    if not scene.contacts:
        names = [item.name for item in scene.objects]
        scene = replace(scene, contacts=contacts_of_scene(scene).to_contacts(names))
    tracer = Tracer(sample_rate=sample_rate)
    count = max(round(seconds * STILL_RATE), 1)
    for number in range(count + 1):
        yield tracer.step(frame_of(scene, number, number * seconds / count, detect=False))
