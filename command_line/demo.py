"""``haptic-tracing demo``: builds the paper's first figure by script, plays it in Blender and
writes the avatar's tracks."""

from __future__ import annotations

import argparse

from ..sample_scenes import build_sample
from .trace import start_blender, trace_and_report


def run(args: argparse.Namespace) -> int:
    """Build, trace, write. Exit code 0."""
    start_blender()
    build_sample("jackhammer_bench")
    return trace_and_report(args, "jackhammer_bench")
