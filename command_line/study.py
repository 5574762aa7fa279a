"""``haptic-tracing study``: the paper's ride rendered in four ways, HT, SD, MD and MN, with a report of what tells them apart."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..study.checks import Check
    from ..study.rendition import Ride

NAME = "mine_ride"


def add_parser(subparsers: Any) -> None:
    """Describe the subcommand."""
    parser = subparsers.add_parser("study", help="render the paper's ride in its four modes and report", description=__doc__)
    parser.add_argument("--out", default="out/study", type=Path, metavar="FOLDER", help="where the results are written (out/study)")
    parser.add_argument("--frames", type=_frames, metavar="FIRST:LAST", help="only these frames, counted from 1 (all 3,600)")
    parser.add_argument("--pictures", type=int, default=3, metavar="N", help="pictures of the ride in each section (3)")
    parser.add_argument("--no-tracks", action="store_true", help="write no WAV files")
    parser.set_defaults(run=run)


def _frames(text: str) -> tuple[int, int]:
    first, colon, last = text.partition(":")
    if not (colon and first.isdecimal() and last.isdecimal() and 1 <= int(first) < int(last)):
        raise argparse.ArgumentTypeError(f"must be FIRST:LAST with 1 <= FIRST < LAST, got {text}")
    return int(first), int(last)


def run(args: argparse.Namespace) -> int:
    """Play, render, measure, write, print. Exit code 0."""
    from .trace import start_blender

    start_blender()
    from tqdm import tqdm

    from ..addon.changes.suspension import suspended
    from ..sample_scenes import build_sample
    from ..study import baking, plots
    from ..study.checks import checks_of
    from ..study.report import write_numbers, write_report

    with suspended():
        scene = build_sample(NAME)
    first, last = args.frames or (scene.frame_start, scene.frame_end)
    if last > scene.frame_end:
        raise ValueError(f"--frames: the ride ends with frame {scene.frame_end}, not {last}")
    args.out.mkdir(parents=True, exist_ok=True)
    notes = []
    with tqdm(total=last - first + 1, desc="Tracing", unit="frame") as bar:
        ride = baking.bake_ride(scene, first, last, lambda frame: bar.update())
    checks = checks_of(ride)
    pictures = {}
    if args.pictures > 0 and baking.can_draw():
        pictures = baking.draw_frames(scene, baking.lively_frames(ride, args.pictures))
    elif args.pictures > 0:
        notes.append("There are no pictures of the ride: off-screen drawing needs Blender 5.2 or a window, and OpenGL.")
    figures = []
    if plots.can_plot():
        figures = list(plots.plots(ride))
    else:
        notes.append("There are no plots: matplotlib is not installed (pip install 'haptic-tracing[report]').")
    written = [] if args.no_tracks else _write_tracks(args.out, ride)
    written += [args.out / "study.json", args.out / "report.html"]
    write_numbers(written[-2], ride, checks)
    write_report(written[-1], ride, checks, figures, pictures, notes)
    print_checks(checks)
    for note in notes:
        print(note)
    for path in written:
        print(f"wrote {path}")
    return 0


def _write_tracks(folder: Path, ride: Ride) -> list[Path]:
    from ..core.formats.tracks.wav import write_wav

    written = []
    for mode, rendition in ride.renditions.items():
        written.append(folder / f"{NAME}.{mode}.wav")
        write_wav(rendition.tracks, written[-1])
    return written


def print_checks(checks: tuple[Check, ...]) -> None:
    """One line each."""
    signs = {True: "holds        ", False: "DOES NOT HOLD", None: "no data      "}
    for check in checks:
        print(f"{signs[check.holds]}  {check.name}: {check.measured}")
