"""``haptic-tracing trace FILE.blend``: plays a tagged Blender file and writes the listeners'
tracks."""

from __future__ import annotations

import argparse
import atexit
import math
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from bpy.types import Scene

from .. import register, unregister
from ..addon.changes.suspension import suspended
from ..addon.io.capture import Capture
from ..addon.io.frame_scene import scene_of_result, written_export
from ..addon.session import session
from ..core.formats.haptic_scene import read_export, write_export
from ..core.formats.tracks.track_export import credit
from ..core.formats.tracks.wav import write_wav
from ..core.forms import Form, JsonObject
from ..core.render.masking import shown_sounding
from ..pictures.picture import draw_picture
from . import answer, note_interrupts, temporary_folder
from .frame_bar import frame_bar
from .playing import ImpactFelt, Played, play
from .propagate import who_is_felt


def run(args: argparse.Namespace) -> int:
    """Open the file, trace it, write the results. Exit code 0."""
    start_blender()
    open_file(args.file)
    return trace_and_report(args, Path(args.file).stem)


def start_blender() -> None:
    """Begin with an empty file and enable the add-on until the program ends."""
    temporary_folder.use()
    note_interrupts()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    register()
    # With handlers or timers left at exit, Blender 4.2 crashes and 4.5 hangs.
    atexit.register(unregister)


def open_file(file: str | Path) -> Scene:
    """Open a Blender file without running its scripts, and return its scene. Raises ValueError if
    it cannot be opened."""
    path = Path(file).resolve()
    if not path.is_file():
        raise ValueError(f"{file}: there is no such file")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False, load_ui=False)
    except RuntimeError as error:
        raise ValueError(f"{path}: {str(error).strip().removeprefix('Error: ')}") from None
    return bpy.context.scene


def trace_and_report(args: argparse.Namespace, name: str) -> int:
    """Play the open file's scene, write haptic scene, WAV and picture into the folder, print the
    results and the run times."""
    scene = bpy.context.scene
    start = scene.frame_start if args.start is None else args.start
    end = scene.frame_end if args.end is None else args.end
    args.out.mkdir(parents=True, exist_ok=True)
    capture, own = Capture(scene, start, end, recorded=args.whole, felt=False), session.of(scene)
    with frame_bar(max(end - start + 2, 0), "Tracing") as advance:

        def played_frame(frame: int) -> None:
            if args.whole and own.result is not None:
                capture.add(own.result)
            advance()

        played = play(scene, start, end, played_frame)

    written = [args.out / f"{name}.json", args.out / f"{name}.wav"]
    last = written_export(name, scene, scene_of_result(played.last, played.last_reading, scene))
    write_export(capture.export(name) if args.whole else last, written[0])
    read_export(written[0])  # validates the written file
    write_wav(played.tracks(), written[1], comment=credit(last))
    if not args.no_picture and scene.camera is None:
        print(f"no picture: scene {scene.name!r} has no camera to draw it from")
    elif not args.no_picture:
        written.append(args.out / f"{name}.png")
        with suspended():
            scene.frame_set(played.liveliest.number)
            draw_picture(scene, played.liveliest, written[-1], meters=True)

    result = in_json(played, written)
    print(f"\nFrame {result['frame']}")
    print_gains(result["gains"])
    print_felt(result["felt"])
    print_impacts(played.impacts, played.listeners)
    print_statistics(played)
    for path in written:
        shown = (
            f"frames {start} to {end}" if path.suffix == ".wav" or args.whole else f"frame {end}"
        )
        print(f"wrote {path}" + (f" ({shown})" if path.suffix != ".png" else ""))
    answer(args, result)
    return 0


def in_json(played: Played, written: Sequence[Path]) -> JsonObject:
    """What was printed, as JSON values: gains and margins of the last frame, all impacts with the
    amplitudes that arrive at the listeners, and the files."""
    last = played.last
    return {
        "files": [str(path) for path in written],
        "frame": last.number,
        "gains": [
            {
                "source": source.name,
                "listener": listener.name,
                "path_gain": float(last.gains[s, i]),
                "path": list(last.path_objects(s, i)),
            }
            for s, source in enumerate(last.sources)
            for i, listener in enumerate(last.listeners)
        ],
        "felt": [
            part
            for i in range(len(last.listeners))
            for part in who_is_felt(shown_sounding(last), i, last.sample_rate)
        ],
        "impacts": [
            {
                "time": impact.source.onset,
                "objects": [impact.source.object, impact.source.second_object],
                "amplitudes": dict(
                    zip(played.listeners, map(float, impact.amplitudes), strict=True)
                ),
            }
            for impact in played.impacts
        ],
        "statistics": dict(last.statistics),
    }


def print_gains(gains: Sequence[Form]) -> None:
    """Print the table (source, listener, gain of the paths, dB, best path) of a frame."""
    rows = [
        (
            item["source"],
            item["listener"],
            *_gain_cells(item["path_gain"]),
            " > ".join(item["path"]),
        )
        for item in gains
    ]
    _print_table(("source", "listener", "gain", "dB", "best path"), rows)


def print_felt(felt: Sequence[Form]) -> None:
    """Print the felt and the masked sources of each listener of a frame, with their maskers."""
    rows = [
        (
            item["listener"],
            item["source"],
            f"{item['margin']:+.0f} dB" + (" (assumed)" if item["assumed"] else ""),
            f"masked by {item['masked_by']}" if item["state"] == "masked" else item["state"],
        )
        for item in felt
    ]
    if rows:
        print("\nWho is felt")
        _print_table(("listener", "source", "above threshold", ""), rows)


def print_impacts(impacts: Sequence[ImpactFelt], listeners: Sequence[str]) -> None:
    """Print the impacts, each with the listener at which it arrives with the largest amplitude."""
    if not impacts:
        return
    rows = []
    for impact in impacts:
        i = int(impact.amplitudes.argmax()) if len(listeners) else -1
        felt = (
            (listeners[i], *_gain_cells(float(impact.amplitudes[i])), " > ".join(impact.paths[i]))
            if i >= 0
            else ("", "", "", "")
        )
        rows.append(
            (
                f"{impact.source.onset:.3f} s",
                f"{impact.source.object} and {impact.source.second_object}",
                *felt,
            )
        )
    print("\nImpacts")
    _print_table(("time", "objects", "felt most at", "amplitude", "dB", "best path"), rows)


def print_statistics(played: Played) -> None:
    """Print the counts of the last frame, and the time per frame compared with Blender's own."""
    print("\nStatistics of the last frame")
    _print_table(
        ("", ""),
        [(key.replace("_", " "), f"{value:g}") for key, value in played.last.statistics.items()],
    )
    print("\nMilliseconds per frame")
    times = {"Blender": played.blender_milliseconds, "tracing": played.tracing_milliseconds}
    rows = [
        (name, *(f"{np.percentile(values, part):.2f}" for part in (50, 95, 100)))
        for name, values in times.items()
    ]
    own, tracing = (float(np.median(values)) for values in times.values())
    _print_table(
        ("", "median", "95 %", "longest"),
        [*rows, ("ratio", f"{tracing / max(own, 1e-9):.3f}", "", "")],
    )


def _gain_cells(gain: float) -> tuple[str, str]:
    return f"{gain:.4f}", f"{20 * math.log10(gain):.1f}" if gain > 0 else "-inf"


def _print_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    widths = [max(len(row[i]) for row in (heads, *rows)) for i in range(len(heads))]
    for row in (heads, *rows) if any(heads) else rows:
        print(
            "  "
            + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        )
