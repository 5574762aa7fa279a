"""The arguments of every subcommand. Imports none of the commands' modules."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..core.formats.io.catalogue import formats, readers
from ..core.plugins import offered
from ..sample_scenes import SAMPLES

Parser = argparse.ArgumentParser
Options = argparse._ActionsContainer
"""A parser, or a group of its arguments."""

FORMAT_NAMES = "; ".join(
    (
        f"{', '.join(formats())}, or all",
        *(f"{name}, alone, of a Blender file" for name, _ in offered("exports")),
    )
)


class Subcommand(NamedTuple):
    """``describe`` adds its arguments to a parser. ``example``: a call of it, for its page in the
    manual."""

    description: str
    describe: Callable[[Parser], None]
    example: str


def _add(
    parser: Options, name: str, metavar: str | tuple[str, ...], about: str, **more: Any
) -> None:
    """Add an argument; a number has the type of its default. ``more``: as in argparse."""
    if isinstance(more.get("default"), int | float):
        more = {"type": type(more["default"]), **more}
    parser.add_argument(name, metavar=metavar, help=about, **more)


def _flag(parser: Options, name: str, about: str) -> None:
    """Add an option that is on where it is given, and takes no value."""
    parser.add_argument(name, action="store_true", help=about)


def _propagate(parser: Parser) -> None:
    _add_scene(parser)
    parser.add_argument(
        "--strategy",
        choices=("best_path", "as_in_the_paper"),
        help="how gains are computed (the scene's)",
    )
    parser.add_argument(
        "--mode",
        choices=("HT", "SD", "MD", "MN"),
        help="haptic graph, nearest listener, distance, no decay (the scene's)",
    )
    _add(
        parser,
        "--max-connections",
        "N|none",
        "as in the paper: most connections on a path (the scene's)",
        type=_connections,
        default=argparse.SUPPRESS,
    )
    _add(
        parser,
        "--threshold",
        "X",
        "as in the paper: a path ends where its gain falls below; 0: no limit (the scene's)",
        type=_share,
    )
    _flag(
        parser, "--felt", "also which sources each listener feels, and which are masked by others"
    )
    _flag(parser, "--contacts", "also the contacts that the shapes and poses of objects give")


def _serve(parser: Parser) -> None:
    _add(
        parser,
        "scene",
        "SCENE.json",
        "haptic scene; without it each client sends its own",
        type=Path,
        nargs="?",
    )
    _add(
        parser,
        "--listen",
        "HOST:PORT",
        "address of the WebSocket (127.0.0.1:7710)",
        default="127.0.0.1:7710",
    )
    _add(parser, "--osc", "PORT", "also answer OSC over UDP on this port, such as 7711", type=int)
    _add_devices(parser)
    _flag(parser, "--osc-devices", "the devices play for OSC, in place of clients")
    _add(parser, "--token", "TEXT", "what clients say to play on devices (drawn and printed)")
    _add(
        parser,
        "--allow-origin",
        "ORIGIN",
        "a web page that may connect",
        action="append",
        default=[],
    )


def _conformance(parser: Parser) -> None:
    _add(parser, "url", "URL", "a run-time server, such as ws://127.0.0.1:7710")
    _add(
        parser,
        "file",
        "FILE.json",
        "conversations to play (those of the repository)",
        type=Path,
        nargs="*",
    )
    _add(parser, "--token", "TEXT", "what the server wants to hear")
    _add(parser, "--most", "N", "differences printed for each file (10)", default=10)


def _devices(parser: Parser) -> None:
    _add(
        parser,
        "--profiles",
        "FOLDER",
        "folder with device profiles of your own (*.json)",
        type=Path,
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")

    test = actions.add_parser(
        "test",
        help="play a sweep on each actuator of a device in turn, then silence and release it",
    )
    _add(test, "name", "NAME", "a device's name as listed, such as dualsense")
    test.add_argument("--serial", default="", help="of one device among several of the same kind")
    test.add_argument(
        "--seconds", type=float, default=3.0, help="length of the sweep, 0.1 to 60 (default 3)"
    )

    _add(test, "--actuator", "NAME", "play on this actuator only")

    calibrate = actions.add_parser(
        "calibrate",
        help="find what a device does at full scale, for the margins of a listener",
        description="Record with an accelerometer on an actuator while `devices test NAME "
        "--actuator NAME` plays, then give the recording; or take the values of a profile.",
    )
    calibrate.add_argument("recording", metavar="RECORDING.wav", type=Path, nargs="?")
    _add(
        calibrate,
        "--unit",
        "M/S2",
        "acceleration that the recording's full scale stands for [m/s^2] (default 1)",
        default=1.0,
    )
    calibrate.add_argument(
        "--seconds", type=float, default=3.0, help="length of the sweep played (default 3)"
    )
    _add(calibrate, "--played", "FILE.wav", "what was played instead of the sweep", type=Path)
    _add(calibrate, "--device", "NAME", "take the values of this profile")
    _add(calibrate, "--actuator", "NAME", "its actuator (the first)")
    _add(calibrate, "--scene", "SCENE.json", "write the values into this haptic scene", type=Path)
    _add(calibrate, "--listener", "NAME", "its listener", default="")

    encode = actions.add_parser(
        "encode", help="print the report that drives a device, as hexadecimal"
    )
    _add(encode, "device", "DEVICE", "dualsense, switch-pro, xbox, ...")
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
    _add(
        parser,
        "files",
        "FILE",
        "a haptic scene (-: standard input), a Blender file, or parts of one or folders with them",
        nargs="+",
        type=Path,
    )
    _add(parser, "--to", "FORMAT,...", f"{FORMAT_NAMES} (wav)", default="wav")
    _add_folder(parser, "where the files are written; -: one file, to standard output")
    _add_format_options(parser)
    _flag(
        parser,
        "--absolute",
        "keep the traced levels and every listener; else one gain uses the range, and who feels "
        "nothing is left out",
    )
    _flag(parser, "--losses", "only say what the formats can't carry")
    _flag(
        parser,
        "--methods",
        "also print a paragraph for a paper: program, settings, scene and its digest",
    )
    _flag(
        parser,
        "--picture",
        "a picture beside each format that is read back: waves, spectra, difference",
    )
    scene = parser.add_argument_group("of a haptic scene")
    _add(scene, "--seconds", "X", "how long a scene without frames is rendered (10)", type=_number)
    _add(scene, "--sample-rate", "HZ", "of the tracks rendered from a scene (8000)", type=int)
    blend = parser.add_argument_group("of a Blender file")
    _add_frames(blend)
    _add(
        blend,
        "--modes",
        "MODE,...",
        "HT, SD, MD, MN: played once in each (the scene's)",
        default="",
    )
    _add(
        blend,
        "--set",
        "PATH=VALUE",
        'a property, such as objects["Bench"].haptics.kappa=0.2 or scene.haptics.minimum_energy=1',
        action="append",
        default=[],
    )
    _add(
        blend,
        "--part",
        "K/N|K-L/N",
        "only write the K-th of N parts, or the K-th to the L-th: NAME.K-of-N.npz in the folder",
        type=_part,
    )
    _flag(
        blend,
        "--from-start",
        "trace a part from the first frame of the range, if the export of the parts demands it",
    )
    blend.add_argument(
        "--progress",
        choices=("bar", "openjd"),
        default="bar",
        help="a bar, if stderr is a terminal, or lines for workers of Open Job Description",
    )
    blend.add_argument(
        "--job-template",
        action=_JobTemplate,
        help="print an Open Job Description of an export in parts",
    )


def _convert(parser: Parser) -> None:
    _add(
        parser,
        "source",
        "IN",
        f"{', '.join(readers())}, or a scene: .json, .json.gz; -: standard input",
        type=Path,
    )
    _add(
        parser,
        "target",
        "OUT",
        "its ending tells the format, .json the signal that a sound becomes; some formats take one "
        "file per channel; -: standard output",
        type=Path,
    )
    _add_from(parser)
    parser.add_argument("--to", choices=(*formats(), "signal"), help="the format of - as a target")
    _add_format_options(parser)
    sound = parser.add_argument_group("of a sound that becomes a signal")
    _add(
        sound,
        "--carrier",
        "HERTZ|pitch|DEVICE",
        "a frequency, the sound's pitch, or a device's best (160)",
    )
    _add(sound, "--gate", "DB", "what is quieter makes no vibration (-40)", type=_number)
    _add(sound, "--gain", "X", "factor on the amplitude (1)", type=_not_negative)


def _add_from(parser: Parser) -> None:
    parser.add_argument("--from", dest="read_as", choices=tuple(formats()), help="the format of -")


def _play(parser: Parser) -> None:
    _add(
        parser,
        "file",
        "FILE",
        f"{', '.join(readers())}, or a scene: .json, .json.gz; -: standard input",
        type=Path,
    )
    _add_from(parser)
    _add_devices(parser, " (all)")
    _add(parser, "--seconds", "X", "how long a scene without frames is played (10)", default=10.0)


def _sample(parser: Parser) -> None:
    names = "\n".join(
        f"  {sample.name.ljust(18)} {sample.description}" for sample in SAMPLES.values()
    )
    parser.epilog, parser.formatter_class = (
        f"samples:\n{names}",
        argparse.RawDescriptionHelpFormatter,
    )
    _add(parser, "name", "NAME", "one of the samples below", choices=tuple(SAMPLES))
    _add(parser, "--output", "FILE.blend", "where to save it (NAME.blend)", type=Path)
    counted = " and ".join(
        f"{sample.name} ({sample.count})" for sample in SAMPLES.values() if sample.count
    )
    _add(parser, "--count", "N", f"number of objects, for {counted}", type=int)
    _flag(parser, "--no-bake", "leave the rigid bodies to be simulated when the file is played")


def _trace(parser: Parser) -> None:
    parser.add_argument("file", help="Blender file with haptic objects, sources and listeners")
    _demo(parser)


def _sweep(parser: Parser) -> None:
    wanted = "the study, or the table of a sweep to plot"
    _add(parser, "study", "STUDY.toml | plot TABLE.parquet", wanted, nargs="+")
    _add(
        parser,
        "--on",
        "local | tcp://SCHEDULER",
        "this machine, or a Dask cluster (local)",
        default="local",
    )
    _add(
        parser,
        "--workers",
        "N",
        "processes on this machine (one per core)",
        default=os.cpu_count() or 1,
    )
    _flag(parser, "--tracks", "keep the tracks of every variant as WAV files, too")
    _add_folder(parser, "where results, table and pictures are written")
    _add(
        parser,
        "--over",
        "COLUMN",
        "plot: the parameter along the axis (the first with several numbers)",
    )


def _demo(parser: Parser) -> None:
    _add_folder(parser, "where the results are written")
    parser.add_argument("--start", type=int, help="first frame (the scene's)")
    parser.add_argument("--end", type=int, help="last frame (the scene's)")
    _flag(parser, "--whole", "all frames in the haptic scene, not only the last one")
    _flag(parser, "--no-picture", "draw no picture")


def _study(parser: Parser) -> None:
    _add_folder(parser, "where the results are written", "out/study")
    _add(
        parser,
        "--frames",
        "FIRST:LAST",
        "only these frames, counted from 1 (all 3,600)",
        type=_frame_range,
    )
    _add(parser, "--pictures", "N", "pictures of the ride in each section (3)", default=3)
    _flag(
        parser,
        "--sensitivity",
        "render with other values and strategies as well, and say what still holds",
    )
    _flag(
        parser,
        "--no-materials",
        "leave out the ride with measured materials, two thirds of the time",
    )
    _flag(parser, "--no-tracks", "write no WAV files")
    actions = parser.add_subparsers(metavar="run | analyse")

    run = actions.add_parser("run", help="let people feel it and ask them, on two local pages")
    run.set_defaults(command="study_run")
    _add(run, "--participants", "N", "how many", type=int, required=True)
    _add(
        run,
        "--out",
        "DIR",
        "folder with study.toml, which is put there to be filled in, and the answers",
        type=Path,
        required=True,
    )
    _add_devices(run, " (all that are connected)")
    run.add_argument("--port", type=int, default=7720, help="of the pages (7720)")
    _flag(run, "--prepare", "only render films and tracks")

    analyse = actions.add_parser("analyse", help="the statistics of a study with people")
    analyse.set_defaults(command="study_analyse")
    _add(analyse, "folder", "DIR", "the folder of the study", type=Path)


SUBCOMMANDS: Mapping[str, Subcommand] = {
    "propagate": Subcommand(
        "Print the gains of a haptic scene file as one JSON object.",
        _propagate,
        "haptic-tracing propagate bench.json --felt --contacts",
    ),
    "serve": Subcommand(
        "Answer poses from an engine with what each listener feels, and play it on devices.",
        _serve,
        "haptic-tracing serve bench.json --device dualsense",
    ),
    "conformance": Subcommand(
        "Play conversations with a run-time server and compare its answers with what closed "
        "forms say.",
        _conformance,
        "haptic-tracing conformance ws://127.0.0.1:7710 --token TOKEN",
    ),
    "devices": Subcommand(
        "List the connected haptic devices; or test or calibrate one, or encode its report.",
        _devices,
        "haptic-tracing devices test dualsense --seconds 5",
    ),
    "export": Subcommand(
        "Write what the listeners of a haptic scene or of a Blender file, which is played with its "
        "physics, feel in the formats of other programs; of a Blender file also in parts.",
        _export,
        "haptic-tracing export bench.blend --to wav,hjif --frames 1:250 --modes HT,SD",
    ),
    "play": Subcommand(
        "Play any haptic file, or what the listeners of a scene feel, on the connected devices. "
        "Space pauses, q stops.",
        _play,
        "haptic-tracing play out/bench.wav --device dualsense",
    ),
    "convert": Subcommand(
        "Convert a vibration, or a haptic scene, to the format that the new name ends in, or a "
        "sound to the signal of a source.",
        _convert,
        "haptic-tracing convert - buzz.haptic --from wav < buzz.wav",
    ),
    "sample": Subcommand(
        "Build a sample scene, bake its rigid bodies and save it as a Blender file.",
        _sample,
        "haptic-tracing sample rails --output rails.blend",
    ),
    "trace": Subcommand(
        "Play a tagged Blender file and write what its listeners feel.",
        _trace,
        "haptic-tracing trace bench.blend --out out --start 1 --end 48 --json",
    ),
    "sweep": Subcommand(
        "Trace every combination of scenes, settings, materials and seeds of a study into one "
        "table, on this machine or on a Dask cluster; "
        "or draw such a table.",
        _sweep,
        "haptic-tracing sweep study.toml --workers 4 --out out",
    ),
    "demo": Subcommand(
        "Build the paper's first figure, play it in Blender and write what the avatar feels.",
        _demo,
        "haptic-tracing demo --out out",
    ),
    "study": Subcommand(
        "Render the paper's ride in the four modes HT, SD, MD and MN and report how they differ; "
        "or let people feel it (run) and analyse what they answered (analyse).",
        _study,
        "haptic-tracing study --out out/study --sensitivity",
    ),
}


def _add_scene(parser: Parser) -> None:
    _add(
        parser,
        "scene",
        "SCENE.json",
        "haptic scene; without contacts they are found from shapes and poses; -: standard input",
        type=Path,
    )


def _add_folder(
    parser: Parser, about: str = "where the files are written", folder: str = "out"
) -> None:
    _add(parser, "--out", "FOLDER", f"{about} ({folder})", default=folder, type=Path)


def _add_devices(parser: Parser, default: str = "") -> None:
    about = f"a device to play on, as `devices` lists it{default}"
    _add(parser, "--device", "NAME", about, action="append", default=[])


def _add_frames(parser: Options) -> None:
    _add(parser, "--frames", "FIRST:LAST", "only these frames (the scene's)", type=_frame_range)


def _add_format_options(parser: Parser) -> None:
    _add(
        parser,
        "--option",
        "FORMAT.OPTION=VALUE",
        "an option of a format",
        action="append",
        default=[],
        dest="options",
    )


class _JobTemplate(argparse.Action):
    """Print the template of a job for farms, and end. Other arguments would say something that the
    template does not: farms give their values as its parameters."""

    def __init__(self, option_strings: list[str], dest: str, **others: Any) -> None:
        super().__init__(option_strings, dest, nargs=argparse.REMAINDER, **others)

    def __call__(self, parser: Parser, space: argparse.Namespace, after: Any, *_: Any) -> None:
        before = [key for key, value in vars(space).items() if value != parser.get_default(key)]
        if before or after:
            parser.error(
                f"--job-template: leave out {' '.join([*before, *after])}; the farm gives what "
                "differs as parameters of the template"
            )
        print((Path(__file__).parent / "export.yaml").read_text(encoding="utf-8"), end="")
        parser.exit()


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


def _part(text: str) -> tuple[int, int, int]:
    """First part, last part, number of parts."""
    match = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?/([0-9]{1,9})", text)
    first, last, parts = (int(n or match[1]) for n in match.groups()) if match else (1, 0, 0)
    if not 1 <= first <= last <= parts:
        raise argparse.ArgumentTypeError(f"must be K/N or K-L/N with 1 <= K <= L <= N, got {text}")
    return first, last, parts


def _frame_range(text: str) -> tuple[int, int]:
    first, colon, last = text.partition(":")
    if not (colon and first.isdecimal() and last.isdecimal() and 1 <= int(first) < int(last)):
        raise argparse.ArgumentTypeError(f"must be FIRST:LAST with 1 <= FIRST < LAST, got {text}")
    return int(first), int(last)
