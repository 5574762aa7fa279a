"""Latency from the entry of the frame handler to the written report, while bodies simulate.

    python -m benchmarks.bench_latency [--bodies 1000] [--frames 240]

The paper's first figure plays in time, with ten listeners, while the bodies fall and settle beside
it: only simulated, then haptic too. A device that takes reports at once stands for a DualSense (a
report every 10 ms at most) and a Switch Pro Controller (every 30 ms). Its source is noise, so that
nearly every block makes a report. `frame` is Blender's own with tracing. The steps of a block's way
are `tracing` (from the handler's entry), `rendering` its samples, `handing over` to the guard
process, `encoding` what the actuators are to do, and `writing`; `latency` is all of it and the wait
until the device may be written to again, `beyond` all but that wait. `ahead` is the share of frames
whose tracing was not waited for, as it had been slow; when it is done, the rest of the block is
corrected.
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from typing import Any
from unittest import mock

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.blender.time import frame_seconds
from haptic_tracing.addon.live_output import handlers, outputs, player
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.inventory import Found, Inventory
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.sample_scenes import build_sample

from .timed_pad import TimedPad, events

MEDIAN_GOAL, WORST_GOAL = 6.0, 25.0
STAGES = ("tracing", "rendering", "handing over", "encoding", "writing", "latency", "beyond")
DEVICES = {"dualsense": (0x054C, 0x0CE6, 3), "switch-pro": (0x057E, 0x2009, 0)}


def build(bodies: int, haptic: bool) -> bpy.types.Scene:
    """The demo, its hammer noisy, and ``bodies`` boxes that fall beside it."""
    scene = build_sample("jackhammer_bench")
    for obj in scene.objects:
        if obj.haptics.source.enabled:
            obj.haptics.source.signal = "NOISE"
        # The bench passes little on: so levels change from report to report.
        obj.haptics.listener.gain = 10.0
    world = scene.rigidbody_world
    world.point_cache.frame_end = 10_000
    half = 0.15
    mesh = bpy.data.meshes.new("falling")
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    mesh.from_pydata(
        corners,
        [],
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
    )
    side = 10
    for number in range(bodies):
        obj = bpy.data.objects.new(f"falling {number}", mesh)
        scene.collection.objects.link(obj)
        x, y, z = number % side, number // side % side, number // side**2
        obj.location = (20 + 0.45 * x + 0.05 * (z % 3), 0.45 * y, 0.5 + 0.5 * z)
        world.collection.objects.link(obj)
        obj.rigid_body.collision_shape = "BOX"
        obj.rigid_body.mass = 10.0
        obj.haptics.function = "haptic_tracing"
        obj.haptics.enabled = haptic
    floor = bpy.data.objects.new("floor of the falling", mesh)
    scene.collection.objects.link(floor)
    floor.location, floor.scale = (22, 2, -0.15), (60, 60, 1)
    world.collection.objects.link(floor)
    floor.rigid_body.type, floor.rigid_body.collision_shape = "PASSIVE", "BOX"
    floor.haptics.function = "haptic_tracing"
    floor.haptics.enabled = haptic
    return scene


def measure(bodies: int, haptic: bool, device: str, frames: int) -> dict[str, np.ndarray]:
    """Milliseconds per frame of playback in time."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    with tempfile.TemporaryDirectory() as folder:
        log = f"{folder}/events"
        connect(device, log)
        scene = build(bodies, haptic)
        clock = time.perf_counter
        entered: list[float] = []
        played: list[float] = []
        handed: list[float] = []
        sent: list[float] = []
        real_comes, real_play, real_ahead, real_send = (
            handlers.frame_comes,
            player.play,
            player.play_ahead,
            DeviceOutput.send,
        )

        def timed_comes(*arguments: Any) -> None:
            entered.append(clock())
            real_comes(*arguments)

        def timed_play(*arguments: Any) -> None:
            played.append(clock())
            real_play(*arguments)

        def timed_ahead(*arguments: Any) -> None:
            begun, count = clock(), len(sent)
            real_ahead(*arguments)
            if len(sent) > count:
                played.append(begun)

        def timed_send(self: DeviceOutput, block: Any, when: float | None = None) -> float:
            if threading.current_thread() is not threading.main_thread():
                return real_send(self, block, when)  # a correction, of which no picture waits
            handed.append(clock())
            sent.append(real_send(self, block, when))
            return sent[-1]

        with (
            mock.patch.object(handlers, "frame_comes", timed_comes),
            mock.patch.multiple(player, play=timed_play, play_ahead=timed_ahead),
            mock.patch.object(DeviceOutput, "send", timed_send),
        ):
            try:
                own = play(scene, frames, (entered, played, handed, sent))
            finally:
                haptic_tracing.unregister()
        steps = stages(entered, played, handed, sent, events(log), outputs_interval(device))
    went = sum(stamp < call for stamp, call in zip(sent, handed, strict=True))
    return {"ahead": np.array([100.0 * went / frames]), "frame": np.array(own), **steps}


def connect(device: str, log: str) -> None:
    """Drive the device, whose guard writes down what it does."""
    found = profile(device)
    module = TimedPad(*DEVICES[device], log)
    pad = Found(
        device,
        "Pad",
        "USB",
        found,
        lambda adjustment: DeviceOutput(found, adjustment=adjustment, hid=module),
    )
    outputs._state.inventory = Inventory((pad,))
    bpy.ops.haptic.connect_device(device=device)


def play(scene: Any, frames: int, kept: tuple[list[float], ...]) -> list[float]:
    """Play in time; what is in ``kept`` before the first frame is dropped. Returns milliseconds of
    Blender's frames."""
    clock = time.perf_counter
    own: list[float] = []
    scene.frame_set(scene.frame_start)
    time.sleep(1.0)
    handlers.animation_playback_pre(scene)
    for times in kept:
        times.clear()
    due = clock()
    for number in range(1, frames + 1):
        due = max(due + frame_seconds(scene), clock())
        began = clock()
        scene.frame_set(scene.frame_start + number)
        own.append(1000 * (clock() - began))
        # In its window Blender draws now, and its lock on Python is free.
        time.sleep(max(due - clock(), 0.012))
    handlers.animation_playback_post(scene)
    return own


def stages(
    entered: list[float],
    played: list[float],
    handed: list[float],
    sent: list[float],
    noted: dict[str, list[list[float]]],
    interval: float,
) -> dict[str, np.ndarray]:
    """Milliseconds of each step of the way of the frames' blocks. Where the device does already
    what a report would say, the decision not to write it ends the way."""
    rows = []
    accepted = {stamp: (begun, ended) for ended, stamp, begun in noted["accept"]}
    written = np.array([at for (at,) in noted["written"]])
    done = np.sort(np.concatenate([written, [at for (at,) in noted["unchanged"]]]))
    for entry, play, hand, stamp in zip(entered, played, handed, sent, strict=True):
        if stamp not in accepted:
            continue  # a newer one came first
        taken, encoded = accepted[stamp]
        ending = np.searchsorted(done, encoded)
        if ending == len(done):
            continue
        end, before = done[ending], np.searchsorted(written, encoded) - 1
        # The wait until the device may be written to again is its own.
        wait = (
            min(max(written[before] + interval - encoded, 0.0), end - encoded)
            if before >= 0
            else 0.0
        )
        rows.append([play - entry, hand - play, taken - hand, encoded - taken, end - encoded - wait,
                     end - entry, end - entry - wait])  # fmt: skip
    return dict(zip(STAGES, 1000 * np.array(rows).T, strict=True))


def outputs_interval(device: str) -> float:
    """Seconds between two reports over USB."""
    return profile(device).interval("usb")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--devices", nargs="*", choices=DEVICES, default=DEVICES)
    options = parser.parse_args()
    print(
        f"{options.bodies} bodies simulate, {options.frames} frames, ms as median / 99th percentile"
    )
    print(
        f"{'device':12} {'bodies are':>12} {'ahead':>6}"
        + "".join(f"{name:>16}" for name in ("frame", *STAGES))
    )
    for device in options.devices:
        for haptic in (False, True):
            found = measure(options.bodies, haptic, device, options.frames)
            ahead = f"{found.pop('ahead')[0]:5.0f}%"
            cells = [
                f"{np.median(found[name]):6.2f} / {np.percentile(found[name], 99):6.2f}"
                for name in found
            ]
            print(
                f"{device:12} {'haptic' if haptic else 'not haptic':>12} {ahead}"
                + "".join(f"{cell:>16}" for cell in cells),
                flush=True,
            )
    print(f"goal: beyond at most {MEDIAN_GOAL:g} / {WORST_GOAL:g}")
    assert threading.active_count() == 1, "every thread has ended"


if __name__ == "__main__":
    main()
