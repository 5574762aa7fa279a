"""Runs the benchmarks: all of them, or those named.

    python benchmarks [NAME ...]

A benchmark is a module ``bench_NAME.py`` that measures and prints when run with ``python -m
benchmarks.bench_NAME``, and that needs no arguments. Each runs in a process of its own. What it
prints is shown, and kept in ``results/NAME.md`` unless it writes that file itself.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.machine import described  # noqa: E402


def run(name: str) -> bool:
    """Run one benchmark; whether it ended well."""
    kept = HERE / "results" / f"{name}.md"
    before = kept.stat().st_mtime_ns if kept.exists() else None
    printed = []
    command = [sys.executable, "-u", "-m", f"benchmarks.bench_{name}"]
    with subprocess.Popen(
        command, cwd=HERE.parent, stdout=subprocess.PIPE, text=True, encoding="utf-8"
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="", flush=True)
            printed.append(line)
    wrote_it = kept.exists() and kept.stat().st_mtime_ns != before
    if process.returncode == 0 and not wrote_it:
        kept.parent.mkdir(exist_ok=True)
        kept.write_text(
            f"# {name}\n\n{described()}\n\n```\n{''.join(printed)}```\n", encoding="utf-8"
        )
    return process.returncode == 0


def main() -> int:
    """Run those named, or all; exit code 1 where one failed."""
    names = sorted(path.stem.removeprefix("bench_") for path in HERE.glob("bench_*.py"))
    parser = argparse.ArgumentParser(
        prog="benchmarks", description="Runs the benchmarks: all of them, or those named."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names)}")
    chosen = parser.parse_args().names or names
    unknown = [name for name in chosen if name not in names]
    if unknown:
        parser.error(f"unknown benchmark {', '.join(unknown)}: there are {', '.join(names)}")
    failed = []
    for name in chosen:
        print(f"\n{name}\n{'=' * len(name)}", flush=True)
        if not run(name):
            failed.append(name)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
