"""The program and its guard fail at random times while four devices are played: the time to
silence, as a table.

    python -m benchmarks.soak_failures [--minutes 10] [--seed 0]

In each round a program plays on the devices of `benchmarks.soak`, which umockdev makes up. At a
random time the program or the guard is killed, stopped or crashes. This process reads what the
devices were told, beside both.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .report import publish, table
from .soak import PADS, Pad, children, in_umockdev

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "core" / "devices"))

from timed_hid import reports_of

LIMITS = {"program": 0.150, "guard": 1.5}
SIGNALS = {"program": ("SIGKILL", "SIGTERM", "SIGSEGV", "SIGSTOP"), "guard": ("SIGKILL", "SIGSTOP")}
FAILURES = [(who, name) for who, names in SIGNALS.items() for name in names]
WATCHED = 2.5
"""Seconds for which devices are watched after a failure."""

PROGRAM = """
import sys, time
from dataclasses import replace
import numpy as np
sys.path[0] = {tests!r}
from timed_hid import TimedHid
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.profile_files import profile

devices = [replace(profile(name), slew=10_000.0, sustained_maximum=1.0) for name in {names!r}]
outputs = [DeviceOutput(device, hid=TimedHid({folder!r})) for device in devices]
for output in outputs:
    output.start()
while not all(output.status.state == "open" for output in outputs):
    ended = [output.status.message for output in outputs if output.status.is_over]
    if ended:
        sys.exit(ended[0])
    time.sleep(0.01)
print(flush=True)
begun = time.perf_counter()
while True:
    first = round(8000 * (time.perf_counter() - begun))
    wave = 0.5 * np.sin(2 * np.pi * 60.0 * (first + np.arange(4320)) / 8000)
    for output in outputs:
        rows = len(output.profile.actuators)
        sent = output.send(np.tile(wave[:320], (rows, 1)))
        output.expect(np.tile(wave[320:], (rows, 1)), sent)
    time.sleep(0.04)
"""


def main() -> None:
    """Run under umockdev, which is started if need be."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    in_umockdev("benchmarks.soak_failures")
    generator, found = random.Random(options.seed), dict[tuple[str, str], list[float]]()
    end = time.monotonic() + 60.0 * options.minutes
    while time.monotonic() < end or len(found) < len(FAILURES):
        failure = FAILURES[sum(len(times) for times in found.values()) % len(FAILURES)]
        with tempfile.TemporaryDirectory() as folder:
            found.setdefault(failure, []).append(
                silence(*failure, generator.uniform(0.3, 3.0), folder)
            )
    report(found)


def silence(who: str, how: str, after: float, folder: str) -> float:
    """Seconds from a failure to the silence of the last device."""
    names = [pad.name for pad in PADS]
    tests = str(Path(__file__).resolve().parents[1] / "tests" / "core" / "devices")
    source = PROGRAM.format(tests=tests, names=names, folder=folder)
    program = subprocess.Popen([sys.executable, "-c", source], stdout=subprocess.PIPE)
    assert program.stdout is not None
    if not program.stdout.readline():
        raise OSError("the devices can't be opened")
    (guard,) = children(program.pid)
    time.sleep(after)
    os.kill(program.pid if who == "program" else guard, signal.Signals[how])
    failed = time.perf_counter()
    time.sleep(WATCHED)
    program.kill()
    program.wait()
    try:
        return max(
            silence_of(pad, reports_of(folder, f"hidraw{number}"), failed)
            for number, pad in enumerate(PADS)
        )
    except AssertionError as error:
        error.add_note(f"{who}: {how}")
        raise


def silence_of(pad: Pad, written: list[tuple[float, bytes]], failed: float) -> float:
    """Seconds from a failure to the end of what a device plays: to its zero, or to the last report
    of one that lives on samples."""
    levels = [(at - failed, pad.level(data)) for at, data in written]
    drives = [at for at, level in levels if level > 0]
    assert drives and drives[-1] > -0.3, f"{pad.name} is not driven when the failure comes"
    if pad.name.endswith("pcm"):
        return max(drives[-1], 0.0)
    zeros = [at for at, level in levels if at > drives[-1] and level == 0]
    assert zeros, f"{pad.name} goes on"
    return max(zeros[0], 0.0)


def report(found: dict[tuple[str, str], list[float]]) -> None:
    """Print and keep the table. Raises AssertionError if a silence came too late."""
    rows = [
        [
            who,
            how,
            f"{len(times)}",
            f"{1000 * sorted(times)[len(times) // 2]:.0f}",
            f"{1000 * max(times):.0f}",
            f"{1000 * LIMITS[who]:.0f}",
        ]
        for (who, how), times in found.items()
    ]
    text = table(["who", "fails by", "times", "median ms", "longest ms", "limit ms"], rows)
    publish(
        "soak_failures",
        "Time to silence after failures at random times",
        text,
        {" ".join(key): times for key, times in found.items()},
    )
    late = {key: max(times) for key, times in found.items() if max(times) > LIMITS[key[0]]}
    assert not late, f"silent too late: {late}"


if __name__ == "__main__":
    main()
