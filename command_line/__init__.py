"""The console program ``haptic-tracing``.

Each subcommand is a module with ``run(args) -> int``. Only the requested one is imported;
`arguments` describes the arguments of all of them, so that help loads nothing else.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from types import FrameType
from typing import NoReturn

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
    """A parser that reports invalid arguments in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {one_line(message)} (see {self.prog} --help)\n")


def one_line(text: str) -> str:
    """``text`` with line breaks and other control characters escaped."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def say(lines: Iterable[str]) -> None:
    """Print warnings on stderr, one line each."""
    for line in lines:
        print(one_line(line), file=sys.stderr)


def warn_of_unknown(file: object, unknown: Sequence[str]) -> None:
    """Warn about ignored keys of a newer version."""
    if unknown:
        say([f"{file}: of a newer version; not read: {', '.join(unknown)}"])


def build_parser() -> argparse.ArgumentParser:
    """The parser of all subcommands."""
    parser = _OneLineParser(
        prog="haptic-tracing", description="Vibration propagated through touching objects."
    )
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, command in SUBCOMMANDS.items():
        command.describe(
            subparsers.add_parser(name, help=command.summary, description=command.description)
        )
    return parser


def run(args: argparse.Namespace) -> int:
    """Import the subcommand and run it. Raises ValueError if it needs Blender and there is none."""
    try:
        module = import_module(f".{args.command}", __name__)
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        raise ValueError(
            "this needs Blender as a Python module: pip install bpy (its version decides the "
            "Python version)"
        ) from None
    code: int = module.run(args)
    return code


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program on ``argv`` (the process' arguments by default) and return its exit code: 0,
    130 after Ctrl-C, or 2 for bad input, which is explained in one line on stderr."""
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
