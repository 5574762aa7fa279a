"""Random inputs for everything that reads: `make fuzz`.

    python tests/addon/fuzzing [--inputs 1000000] [--seed 0] [--only TARGET ...]

Inputs are numbered: the same seed and number give the same input. They are tried in processes of
20,000, one after the other. What raises an error that a reader should not raise, takes more than 12
s of the processor or more memory than 64 MB and 50 times its size, or ends the process, is printed
with its number and written to ``out/crashers``, from where it is taken over into the corpus once it
is mended.
"""

from __future__ import annotations

import argparse
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "references"))

import own_temporary_folder

own_temporary_folder.make()

from haptic_tracing.core.formats.io.budget import budget_of
from inputs import changed, targets

BATCH = 20_000
SECONDS, BYTES = 12.0, 4 << 30
FOUND = Path("out") / "crashers"


class Hang(BaseException):
    """No error that a reader could take for one of its own."""


def hang(*_: object) -> None:
    raise Hang(f"more than {SECONDS:g} s of the processor")


class Glut(Exception):
    """An input took too much memory."""


def memory(key: str) -> int:
    """Bytes of this process's memory: ``VmRSS`` now, ``VmHWM`` the most since `forget_peak`."""
    (line,) = (
        line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(key)
    )
    return 1024 * int(line.split()[1])


def forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def batch(seed: int, first: int, count: int, only: list[str], place: Path) -> int:
    """Try inputs; returns how many got through. ``place``: a file that says which one is being
    tried."""
    known = {name: target for name, target in targets().items() if not only or name in only}
    names, crashes = sorted(known), 0
    warnings.simplefilter("error", RuntimeWarning)
    signal.signal(signal.SIGVTALRM, hang)
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    with tempfile.TemporaryDirectory() as folder:
        # What is loaded once is not counted, such as validators.
        for target in known.values():
            for content in dict.fromkeys(target.seeds):
                target.run(content, Path(folder))
    with tempfile.TemporaryDirectory() as folder, place.open("w") as now:
        for number in range(first, first + count):
            generator = random.Random(f"{seed} {number}")
            name = generator.choice(names)
            content = changed(known[name].seeds, generator)
            now.seek(0)
            now.write(f"{number:12} {name}\n")
            now.flush()
            signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
            forget_peak()
            before = memory("VmRSS")
            try:
                known[name].run(content, Path(folder))
                taken = memory("VmHWM") - before
                if taken > budget_of(len(content)):
                    raise Glut(f"{taken >> 20} MB for {len(content)} bytes")
            except (Exception, Hang):
                crashes += 1
                FOUND.mkdir(parents=True, exist_ok=True)
                (FOUND / f"{name}.{number}").write_bytes(content)
                print(
                    f"input {number}, {name}: {content[:200]!r}\n{traceback.format_exc(limit=-4)}",
                    flush=True,
                )
            finally:
                signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return crashes


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=[], metavar="TARGET")
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--place", type=Path, help=argparse.SUPPRESS)  # in a process of a batch
    options = parser.parse_args()
    if options.place is not None:
        return min(
            batch(options.seed, options.first, options.inputs, options.only, options.place), 100
        )
    crashes, begun, end = 0, time.monotonic(), options.first + options.inputs
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "now"
        for first in range(options.first, end, BATCH):
            numbers = ["--first", str(first), "--inputs", str(min(BATCH, end - first))]
            command = [
                sys.executable,
                __file__,
                *numbers,
                "--seed",
                str(options.seed),
                "--place",
                str(place),
                "--only",
                *options.only,
            ]
            code = subprocess.run(command).returncode
            crashes += abs(code)
            if code < 0 or code > 100:
                print(
                    f"the process ended with {code} at input {place.read_text().strip()}",
                    flush=True,
                )
            done = min(first + BATCH, end) - options.first
            print(
                f"{done} inputs, {crashes} got through, {time.monotonic() - begun:.0f} s",
                flush=True,
            )
    return 1 if crashes else 0


if __name__ == "__main__":
    sys.exit(main())
