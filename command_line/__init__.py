"""The console program ``haptic-tracing``.

Each subcommand is a module with ``add_parser(subparsers)``, which sets ``run=run``, and ``run(args) -> int``, which imports what it needs
when it is called: asking for help loads nothing heavy.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

SUBCOMMANDS = ("propagate", "contacts", "devices", "export", "convert", "sample", "trace", "demo", "study")

BAD_INPUT = 2
INTERRUPTED = 130


class _OneLineParser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {one_line(message)} (see {self.prog} --help)\n")


def one_line(text: str) -> str:
    """``text`` with line breaks and other control characters escaped."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def warn_of_unknown(file: object, unknown: Sequence[str]) -> None:
    """Say on stderr which keys of a newer version were not read."""
    if unknown:
        print(one_line(f"{file}: of a newer version; not read: {', '.join(unknown)}"), file=sys.stderr)


def build_parser() -> argparse.ArgumentParser:
    """The parser of all subcommands."""
    parser = _OneLineParser(prog="haptic-tracing", description="Vibration propagated through touching objects.")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in SUBCOMMANDS:
        import_module(f".{name}", __name__).add_parser(subparsers)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program on ``argv`` (the process' arguments by default) and return its exit code: 0, or 2 for bad input, which is
    explained in one line on stderr."""
    try:
        args = build_parser().parse_args(argv)
        code: int = args.run(args)
        sys.stdout.flush()
        return code
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except BrokenPipeError:
        # The reader of our output went away: keep the interpreter from complaining about it when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as error:
        reason = f"{error.filename}: {error.strerror}" if error.filename is not None and error.strerror else str(error)
    except ValueError as error:
        reason = str(error)
    print(one_line(reason), file=sys.stderr)
    return BAD_INPUT
