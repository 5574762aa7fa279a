"""``haptic-tracing study``: renders the paper's ride in the modes HT, SD, MD and MN, and writes a
report of their differences."""

from __future__ import annotations

import argparse
from pathlib import Path

from bpy.types import Scene

from ..addon.changes.suspension import suspended
from ..core.formats.tracks.wav import write_wav
from ..pictures.picture import starts_gpu
from ..sample_scenes import build_sample
from ..sample_scenes.mine_ride import FRAMES
from ..study import baking, physical_scenes, plots
from ..study.checks import Check, checks_of
from ..study.rendition import Ride
from ..study.report import write_numbers, write_report
from ..study.sensitivity import variations
from ..study.side_by_side import TITLES
from . import answer
from .frame_bar import frame_bar
from .trace import start_blender

NAME = "mine_ride"


def run(args: argparse.Namespace) -> int:
    """Play, render, measure, write, print. Exit code 0."""
    first, last = args.frames or (1, FRAMES)
    if last > FRAMES:
        raise ValueError(f"--frames: the ride ends with frame {FRAMES}, not {last}")
    start_blender()
    with suspended():
        scene = build_sample(NAME)
    args.out.mkdir(parents=True, exist_ok=True)
    notes = []
    with frame_bar(last - first + 1, "Tracing") as advance:
        ride, varied = baking.bake_ride(
            scene, first, last, lambda frame: advance(), variations() if args.sensitivity else ()
        )
    checks = checks_of(ride)
    pictures = {}
    if args.pictures > 0 and starts_gpu():
        pictures = baking.draw_frames(scene, baking.frames_to_draw(ride, args.pictures))
    elif args.pictures > 0:
        notes.append(
            "There are no pictures of the ride: off-screen drawing needs Blender 5.2 or a "
            "window, and OpenGL."
        )
    rides = {} if args.no_materials else _other_materials(scene, first, last)
    figures = []
    if plots.can_plot():
        figures = list(plots.plots(ride))
    else:
        notes.append("There are no plots: matplotlib is not installed: pip install matplotlib.")
    written = [] if args.no_tracks else _write_tracks(args.out, ride)
    written += [args.out / "study.json", args.out / "report.html"]
    write_numbers(written[-2], ride, checks, rides)
    write_report(written[-1], ride, checks, figures, pictures, notes, varied, rides)
    print_checks(checks)
    for note in notes:
        print(note)
    for path in written:
        print(f"wrote {path}")
    found = [{"name": one.name, "holds": one.holds, "measured": one.measured} for one in checks]
    answer(args, {"checks": found, "files": [str(path) for path in written]})
    return 0


def _other_materials(scene: Scene, first: int, last: int) -> dict[str, Ride]:
    """The ride by variant: with measured materials, and with contacts by impedance as well. The
    scene keeps both changes."""
    rides = {}
    for way in physical_scenes.WAYS[1:]:
        physical_scenes.make(scene, way)
        with frame_bar(last - first + 1, f"With {TITLES[way]}") as advance:
            rides[way], _ = baking.bake_ride(scene, first, last, lambda frame: advance())
    return rides


def _write_tracks(folder: Path, ride: Ride) -> list[Path]:
    written = []
    for mode, rendition in ride.renditions.items():
        written.append(folder / f"{NAME}.{mode}.wav")
        write_wav(rendition.tracks, written[-1])
    return written


def print_checks(checks: tuple[Check, ...]) -> None:
    """Print one line per check."""
    signs = {True: "holds        ", False: "DOES NOT HOLD", None: "no data      "}
    for check in checks:
        print(f"{signs[check.holds]}  {check.name}: {check.measured}")
