"""``haptic-tracing demo``: builds the paper's first figure by script, plays it in Blender and writes what the avatar feels."""

from __future__ import annotations

import argparse
from typing import Any

from .trace import add_output_arguments, start_blender, trace_and_report


def add_parser(subparsers: Any) -> None:
    """Add the command to the program's."""
    parser = subparsers.add_parser("demo", help="trace the paper's first figure: a jackhammer felt on a bench", description=__doc__)
    add_output_arguments(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Build, trace, write. Exit code 0."""
    start_blender()
    from ..sample_scenes import build_sample

    build_sample("jackhammer_bench")
    return trace_and_report(args, "jackhammer_bench")
