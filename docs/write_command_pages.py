"""Writes a page of the manual for each command, docs/commands/NAME.md, from its arguments.

python docs/write_command_pages.py      (part of `make docs`)
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from haptic_tracing.command_line import build_parser
from haptic_tracing.command_line.arguments import SUBCOMMANDS

FOLDER = Path(__file__).resolve().parent / "commands"


def pages() -> dict[str, str]:
    """The pages by command."""
    parsers = _actions(build_parser())
    return {name: "\n".join(_page(name, parsers[name])) for name in SUBCOMMANDS}


def _actions(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """The parsers of the actions of a command."""
    return {
        name: action
        for argument in parser._actions
        if isinstance(argument, argparse._SubParsersAction)
        for name, action in argument.choices.items()
    }


def _page(name: str, parser: argparse.ArgumentParser) -> Iterator[str]:
    command = SUBCOMMANDS[name]
    yield f"# {name}\n\n{command.description}\n\n    {command.example}\n"
    yield from _arguments(parser)
    for action, described in _actions(parser).items():
        yield f"## {name} {action}\n"
        yield from _arguments(described, shared=("json",))


def _arguments(parser: argparse.ArgumentParser, shared: tuple[str, ...] = ()) -> Iterator[str]:
    """The table of a parser's arguments, without those that the command itself has (``shared``)."""
    rows = [
        f"| {_shown(one)} | {(one.help or '').replace('|', chr(92) + '|')} |"
        for one in parser._actions
        if one.help is not argparse.SUPPRESS
        and one.dest not in shared
        and not isinstance(one, (argparse._HelpAction, argparse._SubParsersAction))
    ]
    yield "\n".join(["| argument | meaning |\n|---|---|", *rows]) + "\n"


def _shown(one: argparse.Action) -> str:
    names = one.metavar if isinstance(one.metavar, tuple) else (one.metavar,) if one.metavar else ()
    values = " ".join(names) or ("|".join(map(str, one.choices)) if one.choices else "")
    if one.nargs == 0:
        values = ""
    text = " ".join(filter(None, [one.option_strings[0] if one.option_strings else "", values]))
    return "`" + (text or one.dest).replace("|", "\\|") + "`"


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for path in FOLDER.glob("*.md"):
        path.unlink()
    for name, text in pages().items():
        (FOLDER / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
