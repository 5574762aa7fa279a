"""``haptic-tracing study analyse DIR``: the statistics of a study with people."""

from __future__ import annotations

import argparse

from ..study.people.report import analyse
from . import answer


def run(args: argparse.Namespace) -> int:
    """Write the tables and the page into the folder. Returns exit code 0."""
    written = [str(path) for path in analyse(args.folder)]
    for path in written:
        print(f"wrote {path}")
    answer(args, {"files": written})
    return 0
