"""The arguments of every subcommand. Imports none of the commands' modules."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from ..core.formats.io.catalogue import FORMATS, READERS
from ..sample_scenes import SAMPLES

Parser = argparse.ArgumentParser

FORMAT_NAMES = f"{', '.join(FORMATS)}, or all"


class Subcommand(NamedTuple):
    """``summary``: its line in the program's help. ``describe`` adds its arguments to a parser."""

    summary: str
    description: str
    describe: Callable[[Parser], None]


def _propagate(parser: Parser) -> None:
    parser.add_argument(
        "scene",
        metavar="SCENE.json",
        help="haptic scene; without contacts they are found from shapes and poses",
    )
    strategies = ("auto", "as_in_the_paper", "best_path", "all_paths", "energy_balance")
    parser.add_argument(
        "--strategy", choices=strategies, help="how gains are computed (the scene's)"
    )
    parser.add_argument(
        "--mode",
        choices=("HT", "SD", "MD", "MN"),
        help="haptic graph, nearest listener, distance, no decay (the scene's)",
    )
    parser.add_argument(
        "--max-connections",
        type=_connections,
        default=argparse.SUPPRESS,
        metavar="N|none",
        help="most connections on a path (the scene's)",
    )
    parser.add_argument(
        "--threshold",
        type=_share,
        metavar="X",
        help="a path ends where its gain falls below; 0: no limit (the scene's)",
    )
    parser.add_argument(
        "--tolerance",
        type=_not_negative,
        metavar="X",
        help="relative error of a sum that is too large to be exact (0.01)",
    )
    parser.add_argument(
        "--felt",
        action="store_true",
        help="also which sources each listener feels, and which are masked by others",
    )


def _fit(parser: Parser) -> None:
    parser.add_argument(
        "scene",
        metavar="SCENE.json",
        help="haptic scene; without contacts they are found from shapes and poses",
    )
    parser.add_argument(
        "recorded_source", metavar="SOURCE.wav", type=Path, help="recorded at the source"
    )
    parser.add_argument(
        "recorded_listener",
        metavar="LISTENER.wav",
        type=Path,
        help="recorded at the listener at the same time",
    )
    parser.add_argument("--source", required=True, metavar="NAME", help="the source in the scene")
    parser.add_argument(
        "--listener", required=True, metavar="NAME", help="the listener in the scene"
    )
    parser.add_argument(
        "--object",
        required=True,
        metavar="NAME",
        help="the object, of function physical, whose loss is fitted",
    )
    parser.add_argument(
        "--contact", nargs=2, metavar=("A", "B"), help="the contact whose gain is fitted, too"
    )
    parser.add_argument(
        "--uncalibrated",
        action="store_true",
        help="the recordings differ by an unknown factor; no contact is fitted then",
    )
    parser.add_argument(
        "--out", type=Path, metavar="NEW.json", help="write the scene with the fitted values"
    )


def _sound(parser: Parser) -> None:
    parser.add_argument("sound", metavar="IN.wav", type=Path, help="the sound")
    parser.add_argument(
        "--output",
        required=True,
        metavar="OUT.json",
        type=Path,
        help="the signal, as in a source of a haptic scene",
    )
    parser.add_argument(
        "--carrier",
        default="160",
        metavar="HERTZ|pitch|DEVICE",
        help="a frequency, the sound's pitch, or a device's best (160)",
    )
    parser.add_argument(
        "--gate",
        type=_number,
        default=-40.0,
        metavar="DB",
        help="what is quieter makes no vibration (-40)",
    )
    parser.add_argument(
        "--gain", type=_not_negative, default=1.0, metavar="X", help="factor on the amplitude (1)"
    )


def _contacts(parser: Parser) -> None:
    parser.add_argument("scene", metavar="SCENE.json", help="haptic scene")
    parser.add_argument(
        "--tolerance",
        type=_not_negative,
        metavar="M",
        help="greatest signed distance of a contact (the file's, else 0.01 m)",
    )


def _serve(parser: Parser) -> None:
    parser.add_argument(
        "scene",
        metavar="SCENE.json",
        type=Path,
        nargs="?",
        help="haptic scene; without it each client sends its own",
    )
    parser.add_argument(
        "--listen",
        default="127.0.0.1:7710",
        metavar="HOST:PORT",
        help="address of the WebSocket (127.0.0.1:7710)",
    )
    parser.add_argument(
        "--osc",
        type=int,
        metavar="PORT",
        help="also answer OSC over UDP on this port, such as 7711",
    )
    parser.add_argument(
        "--device",
        action="append",
        default=[],
        metavar="NAME",
        help="a device to play on, as `devices` lists it",
    )
    parser.add_argument(
        "--osc-devices", action="store_true", help="steps by OSC are played on the devices, too"
    )
    parser.add_argument(
        "--token", metavar="TEXT", help="what clients say to play on devices (drawn and printed)"
    )
    parser.add_argument(
        "--allow-origin",
        action="append",
        default=[],
        metavar="ORIGIN",
        help="a web page that may connect",
    )


def _conformance(parser: Parser) -> None:
    parser.add_argument("url", metavar="URL", help="a run-time server, such as ws://127.0.0.1:7710")
    parser.add_argument(
        "file",
        metavar="FILE.json",
        type=Path,
        nargs="*",
        help="conversations to play (those of the repository)",
    )
    parser.add_argument("--token", metavar="TEXT", help="what the server wants to hear")
    parser.add_argument(
        "--most", type=int, default=10, metavar="N", help="differences printed for each file (10)"
    )


def _devices(parser: Parser) -> None:
    parser.add_argument(
        "--profiles",
        metavar="FOLDER",
        type=Path,
        help="folder with device profiles of your own (*.json)",
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")

    test = actions.add_parser(
        "test",
        help="play a sweep on each actuator of a device in turn, then silence and release it",
    )
    test.add_argument("name", metavar="NAME", help="a device's name as listed, such as dualsense")
    test.add_argument("--serial", default="", help="of one device among several of the same kind")
    test.add_argument(
        "--seconds", type=float, default=3.0, help="length of the sweep, 0.1 to 60 (default 3)"
    )

    encode = actions.add_parser(
        "encode", help="print the report that drives a device, as hexadecimal"
    )
    encode.add_argument("device", metavar="DEVICE", help="dualsense, switch-pro, xbox, ...")
    encode.add_argument("--transport", choices=("usb", "bt"), help="default: the device's first")
    encode.add_argument(
        "--left",
        type=float,
        default=0.0,
        help="amplitude in [0, 1] of the left or low-frequency motor (default 0)",
    )
    encode.add_argument(
        "--right",
        type=float,
        default=0.0,
        help="amplitude in [0, 1] of the right or high-frequency motor (default 0)",
    )
    encode.add_argument(
        "--sequence", type=int, default=0, help="number of the report, 0 to 15 (default 0)"
    )


def _export(parser: Parser) -> None:
    parser.add_argument("scene", help="haptic scene, .json or .json.gz")
    parser.add_argument("--to", required=True, metavar="FORMAT,...", help=FORMAT_NAMES)
    parser.add_argument(
        "--out",
        default="out",
        type=Path,
        metavar="FOLDER",
        help="where the files are written (out)",
    )
    _add_format_options(parser)
    parser.add_argument(
        "--seconds",
        type=float,
        default=10.0,
        metavar="X",
        help="how long a scene without frames is rendered (10)",
    )
    parser.add_argument(
        "--sample-rate", type=int, default=8000, metavar="HZ", help="of the rendered tracks (8000)"
    )
    parser.add_argument(
        "--losses", action="store_true", help="only say what the formats can't carry"
    )
    parser.add_argument(
        "--picture",
        action="store_true",
        help="a picture beside each format that is read back: waves, spectra, difference",
    )


def _convert(parser: Parser) -> None:
    parser.add_argument(
        "source", metavar="IN", type=Path, help=f"{', '.join(READERS)}, or a scene: .json, .json.gz"
    )
    parser.add_argument(
        "target",
        metavar="OUT",
        type=Path,
        help="its ending tells the format; some formats take one file per channel",
    )
    _add_format_options(parser)


def _sample(parser: Parser) -> None:
    names = "\n".join(
        f"  {sample.name.ljust(18)} {sample.description}" for sample in SAMPLES.values()
    )
    parser.epilog, parser.formatter_class = (
        f"samples:\n{names}",
        argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "name", metavar="NAME", choices=tuple(SAMPLES), help="one of the samples below"
    )
    parser.add_argument(
        "--output", type=Path, metavar="FILE.blend", help="where to save it (NAME.blend)"
    )
    counted = " and ".join(
        f"{sample.name} ({sample.count})" for sample in SAMPLES.values() if sample.count
    )
    parser.add_argument("--count", type=int, metavar="N", help=f"number of objects, for {counted}")
    parser.add_argument(
        "--no-bake",
        action="store_true",
        help="leave the rigid bodies to be simulated when the file is played",
    )


def _trace(parser: Parser) -> None:
    parser.add_argument("file", help="Blender file with haptic objects, sources and listeners")
    _demo(parser)


def _bake(parser: Parser) -> None:
    parser.add_argument(
        "file", metavar="FILE.blend", help="Blender file with haptic objects, sources and listeners"
    )
    parser.add_argument(
        "--frames", type=_frame_range, metavar="FIRST:LAST", help="only these frames (the scene's)"
    )
    parser.add_argument(
        "--modes",
        default="",
        metavar="MODE,...",
        help="HT, SD, MD, MN: played once in each (the scene's)",
    )
    parser.add_argument("--to", default="wav", metavar="FORMAT,...", help=f"{FORMAT_NAMES} (wav)")
    parser.add_argument(
        "--out",
        default="out",
        type=Path,
        metavar="FOLDER",
        help="where the files are written (out)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help='a property, such as objects["Bench"].haptics.kappa=0.2 or scene.haptics.threshold=0',
    )
    _add_format_options(parser, "--option")
    parser.add_argument(
        "--part",
        type=_part,
        metavar="K/N",
        help="only the K-th of N parts, for merge: NAME.K-of-N.npz in the folder",
    )
    parser.add_argument(
        "--from-start",
        action="store_true",
        help="trace a part from the first frame of the range, if merge demands it",
    )


def _merge(parser: Parser) -> None:
    parser.add_argument(
        "parts",
        metavar="PARTS",
        nargs="+",
        type=Path,
        help="all parts of one bake or of several, or folders with them",
    )
    parser.add_argument("--to", default="wav", metavar="FORMAT,...", help=f"{FORMAT_NAMES} (wav)")
    parser.add_argument(
        "--out",
        default="out",
        type=Path,
        metavar="FOLDER",
        help="where the files are written (out)",
    )
    _add_format_options(parser, "--option")


def _sweep(parser: Parser) -> None:
    wanted = "the study, or the table of a sweep to plot"
    parser.add_argument("study", nargs="+", metavar="STUDY.toml | plot TABLE.parquet", help=wanted)
    parser.add_argument(
        "--on",
        default="local",
        metavar="local | tcp://SCHEDULER",
        help="this machine, or a Dask cluster (local)",
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes on this machine (one per core)",
    )
    parser.add_argument(
        "--tracks", action="store_true", help="keep the tracks of every variant as WAV files, too"
    )
    parser.add_argument(
        "--out",
        default="out",
        type=Path,
        metavar="FOLDER",
        help="where results, table and pictures are written (out)",
    )
    parser.add_argument(
        "--over",
        metavar="COLUMN",
        help="plot: the parameter along the axis (the first with several numbers)",
    )
    wish = "plot: print the variant nearest to these levels in dB; may be repeated"
    parser.add_argument("--wish", action="append", default=[], metavar="LISTENER=LEVEL", help=wish)


def _demo(parser: Parser) -> None:
    parser.add_argument(
        "--out",
        default="out",
        type=Path,
        metavar="FOLDER",
        help="where the results are written (out)",
    )
    parser.add_argument("--start", type=int, help="first frame (the scene's)")
    parser.add_argument("--end", type=int, help="last frame (the scene's)")
    parser.add_argument(
        "--whole", action="store_true", help="all frames in the haptic scene, not only the last one"
    )
    parser.add_argument("--no-picture", action="store_true", help="draw no picture")


def _study(parser: Parser) -> None:
    parser.add_argument(
        "--out",
        default="out/study",
        type=Path,
        metavar="FOLDER",
        help="where the results are written (out/study)",
    )
    parser.add_argument(
        "--frames",
        type=_frame_range,
        metavar="FIRST:LAST",
        help="only these frames, counted from 1 (all 3,600)",
    )
    parser.add_argument(
        "--pictures",
        type=int,
        default=3,
        metavar="N",
        help="pictures of the ride in each section (3)",
    )
    parser.add_argument(
        "--sensitivity",
        action="store_true",
        help="render with other values and strategies as well, and say what still holds",
    )
    parser.add_argument(
        "--no-materials",
        action="store_true",
        help="leave out the ride with measured materials, two thirds of the time",
    )
    parser.add_argument("--no-tracks", action="store_true", help="write no WAV files")


def _validate(parser: Parser) -> None:
    parser.add_argument(
        "--out", type=Path, metavar="FOLDER", help="write the page and its picture here"
    )


SUBCOMMANDS: Mapping[str, Subcommand] = {
    "propagate": Subcommand(
        "gains of a haptic scene file",
        "Print the gains of a haptic scene file as one JSON object.",
        _propagate,
    ),
    "fit": Subcommand(
        "fit the loss of an object and the gain of a contact",
        "Fit the loss of an object and the gain of a contact to two recordings of one event, at "
        "the source and at a listener.",
        _fit,
    ),
    "contacts": Subcommand(
        "contacts of a haptic scene file",
        "Print the contacts of a haptic scene file, found from the shapes and poses of its "
        "objects.",
        _contacts,
    ),
    "serve": Subcommand(
        "levels and samples for an engine, over a WebSocket or OSC",
        "Answer poses from an engine with what each listener feels, and play it on devices.",
        _serve,
    ),
    "conformance": Subcommand(
        "compares the answers of a run-time server with closed forms",
        "Play conversations with a run-time server and compare its answers with what closed "
        "forms say.",
        _conformance,
    ),
    "devices": Subcommand(
        "haptic devices: list, test, encode", "List the connected haptic devices.", _devices
    ),
    "export": Subcommand(
        "write a haptic scene in other formats",
        "Write what the listeners of a haptic scene feel, in the formats of other programs.",
        _export,
    ),
    "sound": Subcommand(
        "turn a sound into the signal of a source",
        "Follow the level and the pitch of a sound and find its onsets, and write the vibration "
        "as the signal of a source.",
        _sound,
    ),
    "convert": Subcommand(
        "convert between file formats",
        "Convert a vibration, or a haptic scene, to the format that the new name ends in.",
        _convert,
    ),
    "sample": Subcommand(
        "build a sample scene as a .blend file",
        "Build a sample scene, bake its rigid bodies and save it as a Blender file.",
        _sample,
    ),
    "trace": Subcommand(
        "play a tagged .blend file and write what is felt",
        "Play a tagged Blender file and write what its listeners feel.",
        _trace,
    ),
    "bake": Subcommand(
        "play a tagged .blend file and write its tracks in other formats",
        "Play a Blender file, physics included, and write what its listeners feel, in the "
        "formats of other programs.",
        _bake,
    ),
    "merge": Subcommand(
        "merge the parts of a bake",
        "Merge the parts of a bake into tracks that are bit-identical to those of a bake without "
        "parts.",
        _merge,
    ),
    "sweep": Subcommand(
        "trace many variants of scenes in parallel, and plot the results",
        "Trace every combination of scenes, settings, materials and seeds of a study into one "
        "table, on this machine or on a Dask cluster; "
        "or draw such a table.",
        _sweep,
    ),
    "demo": Subcommand(
        "trace the paper's first figure: a jackhammer felt on a bench",
        "Build the paper's first figure, play it in Blender and write what the avatar feels.",
        _demo,
    ),
    "validate": Subcommand(
        "compare the model with published measurements",
        "Compare attenuation, damping and energies with published measurements and printed "
        "answers.",
        _validate,
    ),
    "study": Subcommand(
        "render the paper's ride in its four modes and report",
        "Render the paper's ride in the four modes HT, SD, MD and MN and report how they differ.",
        _study,
    ),
}


def _add_format_options(parser: Parser, flag: str = "--set") -> None:
    parser.add_argument(
        flag,
        action="append",
        default=[],
        metavar="FORMAT.OPTION=VALUE",
        help="an option of a format",
        dest="options",
    )


def _connections(text: str) -> int | None:
    if text == "none":
        return None
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number, 0 or more, or none, got {text}")
    return int(text)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, got {text}") from None


def _share(text: str) -> float:
    value = _number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must lie in [0, 1], got {text}")
    return value


def _not_negative(text: str) -> float:
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be finite and >= 0, got {text}")
    return value


def _part(text: str) -> tuple[int, int]:
    number, slash, parts = text.partition("/")
    if not (slash and number.isdecimal() and parts.isdecimal() and 1 <= int(number) <= int(parts)):
        raise argparse.ArgumentTypeError(f"must be K/N with 1 <= K <= N, got {text}")
    return int(number), int(parts)


def _frame_range(text: str) -> tuple[int, int]:
    first, colon, last = text.partition(":")
    if not (colon and first.isdecimal() and last.isdecimal() and 1 <= int(first) < int(last)):
        raise argparse.ArgumentTypeError(f"must be FIRST:LAST with 1 <= FIRST < LAST, got {text}")
    return int(first), int(last)
