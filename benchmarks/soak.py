"""Live output for half an hour: drift, memory, open files, threads and missed deadlines, as a
table.

    python -m benchmarks.soak [--minutes 30] [--bodies 100]

The paper's first figure plays in time, in a loop, while boxes fall beside it. It is felt on four
devices that umockdev makes up: a DualSense over USB, a Switch Pro Controller and an Xbox pad over
Bluetooth, and a DualSense over Bluetooth that takes samples. Every two seconds the source gets
louder or softer: the lag is the time from that frame's handler to the first report that says so.
Every 20 s Python's lock is held for 300 ms. A report of silence is false wherever one comes, as the
source never pauses. A deadline is missed where a device waits for its next report 20 ms longer than
it has to.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "core" / "devices"))

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.blender.time import frame_seconds
from haptic_tracing.addon.live_output import handlers, outputs
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.inventory import Found, Inventory
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.profiles import Adjustment, Profile
from made_up_devices import DUALSENSE_BT, DUALSENSE_USB, SWITCH_PRO_BT, XBOX_BT, describe
from timed_hid import TimedHid, reports_of

from .bench_latency import build
from .report import publish, table

LOOP = 2000  # frames: a whole number of the tone's cycles
STEP = 48  # frames between two changes of the source's strength
LOCKED_EVERY, LOCKED = 20.0, 0.3
SLACK = 0.020
ROW = 300.0  # seconds of a row


@dataclass(frozen=True, slots=True)
class Pad:
    """A device of the soak: its profile, what umockdev makes up, the seconds in which it needs a
    report, and how strongly one drives it."""

    name: str
    fake: Any
    due: float
    level: Callable[[bytes], int]


def switch_level(data: bytes) -> int:
    """Twice the larger index of both tones; -1 for what is no rumble report."""
    return max(data[3] & 0xFE, 4 * (data[5] - 0x40)) if data[0] == 0x10 else -1


PADS = (
    Pad("dualsense", DUALSENSE_USB, 2.0, lambda data: max(data[3], data[4])),
    Pad("switch-pro", SWITCH_PRO_BT, 0.060, switch_level),
    Pad("xbox", XBOX_BT, 0.100, lambda data: max(data[4], data[5])),
    Pad(
        "dualsense-pcm",
        DUALSENSE_BT,
        0.01067,
        lambda data: int(np.abs(np.frombuffer(data, np.int8)[13:77].astype(int)).max()),
    ),
)


@dataclass(slots=True)
class Record:
    """What was measured while it played: moments are those of `time.perf_counter`."""

    # When the source changed, and whether it got louder.
    steps: list[tuple[float, bool]] = field(default_factory=list)
    # KiB, files and threads of Blender, then of the guard.
    sampled: list[tuple[float, list[int]]] = field(default_factory=list)
    frames: int = 0
    late: int = 0  # frames that came more than half a frame late
    locks: int = 0


def in_umockdev(module: str) -> None:
    """Run ``module`` with the same arguments under umockdev, and exit; nothing if this is there."""
    if "UMOCKDEV_DIR" not in os.environ:
        described = describe(Path(tempfile.mkdtemp(prefix="soak")), [pad.fake for pad in PADS])
        command = [
            "umockdev-run",
            *described,
            "--",
            sys.executable,
            "-m",
            module,
            *sys.argv[1:],
        ]
        # The folder of temporary files goes with this process.
        sys.exit(subprocess.run(command).returncode)


def main() -> None:
    """Run under umockdev, which is started if need be."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--bodies", type=int, default=100)
    options = parser.parse_args()
    in_umockdev("benchmarks.soak")
    with tempfile.TemporaryDirectory() as folder:
        began, record, statuses = soak(options.minutes, options.bodies, folder)
        report(began, record, statuses, folder, options)


def soak(minutes: float, bodies: int, folder: str) -> tuple[float, Record, dict[str, Any]]:
    """Play. Returns when playing began, what was measured, and how the outputs ended."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    scene = build(bodies, True)
    scene.rigidbody_world.point_cache.frame_end = LOOP
    source = prepare_source(scene)
    connect(folder)
    scene.frame_set(scene.frame_start)
    handlers.animation_playback_pre(scene)
    record, first = Record(), time.perf_counter()
    try:
        play(scene, source, first + 60.0 * minutes, record)
        statuses = {pad.name: outputs.running()[pad.name].status for pad in PADS}
        handlers.animation_playback_post(scene)
    finally:
        haptic_tracing.unregister()
    return first, record, statuses


def prepare_source(scene: Any) -> Any:
    """Make the source a steady tone whose strength is set while it plays. Returns its
    properties."""
    (source,) = [obj.haptics.source for obj in scene.objects if obj.haptics.source.enabled]
    source.signal, source.frequency, source.amplitude = "SINE", 60.0, 0.4
    return source


def connect(folder: str) -> None:
    """Drive the four devices, and write down what is written to them."""

    def opened(own: Profile, adjustment: Adjustment) -> DeviceOutput:
        return DeviceOutput(own, adjustment=adjustment, hid=TimedHid(folder))

    found = [
        Found(pad.name, pad.name, "", own, partial(opened, own))
        for pad in PADS
        for own in [replace(profile(pad.name), sustained_maximum=1.0)]
    ]
    outputs._state.inventory = Inventory(tuple(found))
    for pad in PADS:
        bpy.ops.haptic.connect_device(device=pad.name)
    while not all(output.status.state == "open" for output in outputs.running().values()):
        time.sleep(0.05)


def play(scene: Any, source: Any, end: float, record: Record) -> None:
    """Play in time until ``end``."""
    clock = time.perf_counter
    seconds = frame_seconds(scene)
    due = locked = sampled = clock()
    guard = next(iter(children(os.getpid())))
    while clock() < end:
        due += seconds
        wait = due - clock()
        if wait > 0.0:
            time.sleep(wait)
        record.late += wait < -seconds / 2
        due = max(due, clock() - seconds)  # frames are dropped, not caught up
        record.frames += 1
        if record.frames % STEP == 0:
            louder = record.frames // STEP % 2 == 1
            source.amplitude = 0.8 if louder else 0.4
            record.steps.append((clock(), louder))
        scene.frame_set(scene.frame_start + 1 + record.frames % LOOP)
        if clock() - locked > LOCKED_EVERY:
            locked, record.locks = clock(), record.locks + 1
            ctypes.PyDLL(None).usleep(round(1e6 * LOCKED))
        if clock() - sampled > 60.0 or not record.sampled:
            sampled = clock()
            record.sampled.append((sampled, [*usage(os.getpid()), *usage(guard)]))


def children(program: int) -> list[int]:
    """The processes that a process has started."""
    found = []
    for path in Path("/proc").iterdir():
        if path.name.isdigit():
            try:
                parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            if parent == program:
                found.append(int(path.name))
    return found


def usage(process: int) -> list[int]:
    """KiB of memory, open files and threads."""
    fields = dict(
        line.split(":\t", 1)
        for line in Path(f"/proc/{process}/status").read_text().splitlines()
        if ":\t" in line
    )
    return [
        int(fields["VmRSS"].split()[0]),
        len(list(Path(f"/proc/{process}/fd").iterdir())),
        int(fields["Threads"]),
    ]


def report(
    began: float, record: Record, statuses: dict[str, Any], folder: str, options: argparse.Namespace
) -> None:
    """Print and keep the tables."""
    written = {pad.name: reports_of(folder, f"hidraw{number}") for number, pad in enumerate(PADS)}
    end = began + 60.0 * options.minutes
    rows, data = [], []
    for start in np.arange(began, end - 1.0, min(ROW, end - began)):
        window = start, min(start + ROW, end)
        numbers = [values for at, values in record.sampled if window[0] <= at < window[1]][-1:] or [
            record.sampled[-1][1]
        ]
        lags = {pad.name: lag(pad, written[pad.name], record.steps, window) for pad in PADS}
        missed = {pad.name: missed_deadlines(pad, written[pad.name], window) for pad in PADS}
        use = numbers[0]
        memory = [
            f"{use[0] / 1024:.0f}",
            f"{use[1]}",
            f"{use[2]}",
            f"{use[3] / 1024:.0f}",
            f"{use[4]}",
            f"{use[5]}",
        ]
        felt = [f"{1000 * lags[pad.name]:.1f}" for pad in PADS] + [
            f"{missed[pad.name]}" for pad in PADS
        ]
        rows.append([f"{(window[1] - began) / 60:.0f}", *felt, *memory])
        data.append(
            {"minute": (window[1] - began) / 60, "lag": lags, "missed": missed, "usage": numbers[0]}
        )
    heading = [
        "minute",
        *(f"lag {pad.name} ms" for pad in PADS),
        *(f"missed {pad.name}" for pad in PADS),
    ]
    heading += ["Blender MiB", "files", "threads", "guard MiB", "files", "threads"]
    false = {pad.name: false_silences(pad, written[pad.name], (began + 1.0, end)) for pad in PADS}
    totals = [
        [
            pad.name,
            f"{len(written[pad.name])}",
            f"{false[pad.name]}",
            f"{s.failed_writes}",
            f"{s.losses}",
            f"{s.dropped_blocks}",
        ]
        for pad, s in ((pad, statuses[pad.name]) for pad in PADS)
    ]
    text = (
        f"{options.minutes:g} minutes, {options.bodies} bodies, {record.frames} frames of which "
        f"{record.late} came late, "
        f"Python's lock held {record.locks} times for {1000 * LOCKED:.0f} ms. Lags are "
        f"medians.\n\n{table(heading, rows)}\n\n"
        + table(
            ["device", "reports", "false silences", "failed writes", "losses", "blocks replaced"],
            totals,
        )
    )
    publish("soak", "Half an hour of live output", text, {"rows": data, "false_silences": false})
    assert not any(false.values()), "no device is silenced while it plays"


def lag(
    pad: Pad,
    written: list[tuple[float, bytes]],
    steps: list[tuple[float, bool]],
    window: tuple[float, float],
) -> float:
    """Median seconds from a change of the source to the first report whose level is nearer to the
    new one."""
    times = np.array([at for at, _ in written])
    levels = np.array([pad.level(data) for _, data in written])
    lags = []
    for at, louder in steps:
        if not window[0] <= at < window[1]:
            continue
        begin, end = np.searchsorted(times, [at, at + 1.5])
        before, after = np.searchsorted(times, [at - 0.5, at])
        if end - begin < 1 or begin < 1:
            continue
        old = np.median(levels[before:after]) if after > before else levels[begin - 1]
        new = np.median(levels[max(end - 20, begin) : end])
        changed = np.flatnonzero(
            levels[begin:end] > (old + new) / 2 if louder else levels[begin:end] < (old + new) / 2
        )
        if abs(new - old) > 4 and len(changed):
            lags.append(times[begin + changed[0]] - at)
    return float(np.median(lags)) if lags else 0.0


def missed_deadlines(
    pad: Pad, written: list[tuple[float, bytes]], window: tuple[float, float]
) -> int:
    """How often a report came later than the device needs it."""
    times = np.array([at for at, _ in written if window[0] <= at < window[1]])
    return int(np.count_nonzero(np.diff(times) > pad.due + SLACK))


def false_silences(
    pad: Pad, written: list[tuple[float, bytes]], window: tuple[float, float]
) -> int:
    """Reports of silence while the source sounds."""
    return sum(window[0] <= at < window[1] and pad.level(data) == 0 for at, data in written)


if __name__ == "__main__":
    main()
