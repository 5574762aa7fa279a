"""The console program ``haptic-tracing``.

Each subcommand is a module with ``run(args) -> int``. Only the requested one is imported;
`arguments` describes the arguments of all of them, so that help loads nothing else.

What a command prints on stdout is its result alone: Blender's own lines, which it writes to the
process' stdout, go to stderr, and with ``--json`` the text for people as well.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext, redirect_stdout
from difflib import get_close_matches
from importlib import import_module
from io import TextIOWrapper
from types import FrameType
from typing import Any, NoReturn, TextIO

from .. import __version__
from ..core.forms import Form
from . import standard_streams
from .arguments import SUBCOMMANDS

BAD_INPUT = 2
INTERRUPTED = 130

_interrupts: list[int] = []
"""The signals noted since `note_interrupts`."""


def note_interrupts() -> None:
    """Note each Ctrl-C. Blender drops the KeyboardInterrupt where it has called a handler: the
    command would lack a result, or go on."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)


def was_interrupted() -> bool:
    """Whether there was a Ctrl-C since `note_interrupts`."""
    return bool(_interrupts)


def _note(number: int, frame: FrameType | None) -> None:
    _interrupts.append(number)
    signal.default_int_handler(number, frame)


class _OneLineParser(argparse.ArgumentParser):
    """A parser that reports invalid arguments in one line, and takes ``--json``."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.add_argument(
            "--json",
            action="store_true",
            default=argparse.SUPPRESS,
            help="print the result as one JSON object, and all text on stderr",
        )

    def error(self, message: str) -> NoReturn:
        wrong = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        near = get_close_matches(wrong[1], re.findall(r"[\w-]+", wrong[2])) if wrong else ()
        message += f"; did you mean {near[0]}?" if near else ""
        self.exit(BAD_INPUT, f"{self.prog}: {one_line(message)} (see {self.prog} --help)\n")


class _Completion(argparse.Action):
    """Print what makes a shell complete the arguments, and end."""

    def __call__(self, parser: argparse.ArgumentParser, *arguments: Any) -> NoReturn:
        try:
            shtab: Any = import_module("shtab")
        except ModuleNotFoundError:
            parser.error("shtab is not installed: pip install shtab")
        print(shtab.complete(parser, arguments[1]))
        parser.exit()


def one_line(text: str) -> str:
    """``text`` with line breaks and other control characters escaped."""
    text = standard_streams.in_words(text)
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def say(lines: Iterable[str]) -> None:
    """Print warnings on stderr, one line each."""
    for line in lines:
        print(one_line(line), file=sys.stderr)


def build_parser() -> argparse.ArgumentParser:
    """The parser of all subcommands."""
    parser = _OneLineParser(
        prog="haptic-tracing", description="Vibration propagated through touching objects."
    )
    parser.add_argument("--version", action="version", version=f"haptic-tracing {__version__}")
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=("bash", "zsh", "tcsh"),
        help="print what makes a shell complete the arguments",
    )
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, command in SUBCOMMANDS.items():
        about = command.description
        command.describe(subparsers.add_parser(name, help=about, description=about))
    return parser


def run(args: argparse.Namespace) -> int:
    """Import the subcommand and run it."""
    module = command_module(args.command)
    args.json, args.stdout = getattr(args, "json", False), sys.stdout
    for key, suffix in standard_streams.INPUTS.items():
        if getattr(args, key, None) == standard_streams.DASH:
            setattr(args, key, standard_streams.from_input(suffix))
    with redirect_stdout(sys.stderr) if args.json else nullcontext():
        code: int = module.run(args)
    return code


def command_module(name: str) -> Any:
    """Import a module of this package. Raises ValueError if it needs Blender and there is none."""
    try:
        return import_module(f".{name}", __name__)
    except ModuleNotFoundError as error:
        if error.name in ("scipy", "pandas"):
            raise ValueError(f"this needs {error.name}: pip install {error.name}") from None
        if error.name != "bpy":
            raise
        raise ValueError(
            "this needs Blender as a Python module: pip install bpy (its version decides the "
            "Python version)"
        ) from None


def answer(args: argparse.Namespace, result: Form) -> None:
    """Print the result of a command, of JSON values, if ``--json`` asks for it."""
    if args.json:
        print_json(result, args.stdout)


def print_json(result: Form, file: TextIO | None = None) -> None:
    """Print one JSON object."""
    print(json.dumps(result, indent=1, ensure_ascii=False, allow_nan=False), file=file)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program on ``argv`` (the process' arguments by default) and return its exit code: 0,
    130 after Ctrl-C, or 2 for bad input, which is explained in one line on stderr."""
    standard_streams.keep_stdout_for_results()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(encoding="utf-8")
    try:
        return _exit_code(argv)
    finally:
        standard_streams.remove()


def _exit_code(argv: Sequence[str] | None) -> int:
    try:
        code = run(build_parser().parse_args(argv))
        sys.stdout.flush()
        return code
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except BrokenPipeError:
        # The reader of the output has exited: the interpreter would report an error when it closes
        # stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as error:
        reason = (
            f"{error.filename}: {error.strerror}"
            if error.filename is not None and error.strerror
            else str(error)
        )
    except ValueError as error:
        reason = str(error)
    if was_interrupted():
        return INTERRUPTED
    print(one_line(reason), file=sys.stderr)
    return BAD_INPUT
