"""From the entry of the frame handler to the report written, while bodies simulate.

    python -m benchmarks.bench_latency [--bodies 1000] [--frames 240]

The paper's first figure plays in time, with ten listeners, while the bodies fall and settle beside it: only simulated, then haptic too.
A device that takes reports at once stands for a DualSense (a report every 10 ms at most) and a Switch Pro Controller (every 30 ms). Its
source is noise, so that nearly every block makes a report. `frame` is Blender's own with tracing. The steps of a block's way are `tracing`
(from the handler's entry), `rendering` its samples, `handing over` to the writer's thread, `encoding` what the actuators are to do, and
`writing`; `latency` is all of it and the wait until the device may be written to again, `beyond` all but that wait. `ahead` is the share
of frames whose tracing was not waited for, as it had been slow.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
import time
from types import SimpleNamespace
from typing import Any

os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="haptic-tracing-blender-"))
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.live_output import handlers, outputs, player
from haptic_tracing.addon.registration import handlers as addon_handlers
from haptic_tracing.core.devices.output import DeviceOutput
from haptic_tracing.core.devices.pacing import RumblePacing
from haptic_tracing.sample_scenes import build_sample

MEDIAN_GOAL, WORST_GOAL = 5.0, 20.0
STAGES = ("tracing", "rendering", "handing over", "encoding", "writing", "latency", "beyond")
DEVICES = {"dualsense": (0x054C, 0x0CE6, 3), "switch-pro": (0x057E, 0x2009, 0)}


class Pad:
    """hidapi's module and its one device: reports are taken at once, and their times kept."""

    def __init__(self, vendor: int, product: int, number: int) -> None:
        self.entry = {
            "path": b"/dev/null",
            "vendor_id": vendor,
            "product_id": product,
            "serial_number": "",
            "product_string": "Pad",
            "usage_page": 1,
            "usage": 5,
            "interface_number": number,
            "bus_type": 1,
        }
        self.written: list[float] = []

    def enumerate(self, *_: int) -> list[dict[str, Any]]:
        return [self.entry]

    def device(self) -> SimpleNamespace:
        return SimpleNamespace(
            open_path=lambda path: None,
            write=self.write,
            send_feature_report=self.write,
            get_feature_report=lambda report, length: [],
            read=lambda length, timeout: [],
            error=lambda: "",
            close=lambda: None,
        )

    def write(self, data: bytes) -> int:
        self.written.append(time.perf_counter())
        return len(data)


def build(bodies: int, haptic: bool) -> Any:
    """The demo, its hammer noisy, and ``bodies`` boxes that fall beside it."""
    scene = build_sample("jackhammer_bench")
    for obj in scene.objects:
        if obj.haptics.source.enabled:
            obj.haptics.source.signal = "NOISE"
        obj.haptics.listener.gain = 10.0  # the bench passes little on: so levels change from report to report
    world = scene.rigidbody_world
    world.point_cache.frame_end = 10_000
    half = 0.15
    mesh = bpy.data.meshes.new("falling")
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    side = 10
    for number in range(bodies):
        obj = bpy.data.objects.new(f"falling {number}", mesh)
        scene.collection.objects.link(obj)
        x, y, z = number % side, number // side % side, number // side**2
        obj.location = (20 + 0.45 * x + 0.05 * (z % 3), 0.45 * y, 0.5 + 0.5 * z)
        world.collection.objects.link(obj)
        obj.rigid_body.collision_shape = "BOX"
        obj.rigid_body.mass = 10.0
        obj.haptics.enabled = haptic
    floor = bpy.data.objects.new("floor of the falling", mesh)
    scene.collection.objects.link(floor)
    floor.location, floor.scale = (22, 2, -0.15), (60, 60, 1)
    world.collection.objects.link(floor)
    floor.rigid_body.type, floor.rigid_body.collision_shape = "PASSIVE", "BOX"
    floor.haptics.enabled = haptic
    return scene


def measure(bodies: int, haptic: bool, device: str, frames: int) -> dict[str, np.ndarray]:
    """Milliseconds per frame of playback in time."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    pad = Pad(*DEVICES[device])
    sys.modules["hidraw" if sys.platform.startswith("linux") else "hid"] = pad  # type: ignore[assignment]
    scene = build(bodies, haptic)
    bpy.ops.haptic.find_devices()
    outputs.wait_until_found()
    bpy.ops.haptic.connect_device(device=device)
    clock = time.perf_counter
    entered: list[float] = []
    traced: list[float] = []
    sent: list[float] = []
    taken: dict[float, tuple[float, float]] = {}
    ahead: list[float] = []
    real_handler, real_play, real_play_ahead = addon_handlers.frame_change_post, player.play, player.play_ahead
    real_send, real_accept, real_unless_known = DeviceOutput.send, RumblePacing.accept, RumblePacing._unless_known
    unchanged: list[float] = []

    def timed_handler(*arguments: Any) -> None:
        entered.append(clock())
        real_handler(*arguments)

    def timed_play(*arguments: Any) -> None:
        traced.append(clock())
        real_play(*arguments)

    def timed_play_ahead(*arguments: Any) -> bool:
        begun = clock()
        went = real_play_ahead(*arguments)
        if went:
            traced.append(begun)
            ahead.append(begun)
        return went

    def timed_send(self: DeviceOutput, block: Any) -> None:
        sent.append(clock())
        real_send(self, block)

    def timed_accept(self: RumblePacing, block: Any, when: float) -> None:
        begun = clock()
        real_accept(self, block, when)
        taken[when] = begun, clock()

    def timed_unless_known(self: RumblePacing, drive: Any, now: float) -> Any:
        report = real_unless_known(self, drive, now)
        if report is None:
            unchanged.append(clock())
        return report

    registered = bpy.app.handlers.frame_change_post
    registered[registered.index(real_handler)] = timed_handler
    player.play, player.play_ahead = timed_play, timed_play_ahead
    DeviceOutput.send, RumblePacing.accept = timed_send, timed_accept  # type: ignore[method-assign]
    RumblePacing._unless_known = timed_unless_known  # type: ignore[method-assign]
    own: list[float] = []
    try:
        scene.frame_set(scene.frame_start)
        time.sleep(0.5)
        for times in (entered, traced, sent, taken, ahead):
            times.clear()
        handlers.animation_playback_pre(scene)
        due = clock()
        for number in range(1, frames + 1):
            due = max(due + handlers.frame_seconds(scene), clock())
            began = clock()
            scene.frame_set(scene.frame_start + number)
            own.append(1000 * (clock() - began))
            # In its window Blender draws now, and its lock on Python is free.
            time.sleep(max(due - clock(), 0.012))
        handlers.animation_playback_post(scene)
    finally:
        player.play, player.play_ahead = real_play, real_play_ahead
        DeviceOutput.send, RumblePacing.accept = real_send, real_accept  # type: ignore[method-assign]
        RumblePacing._unless_known = real_unless_known  # type: ignore[method-assign]
        registered[registered.index(timed_handler)] = real_handler
        haptic_tracing.unregister()
    steps = stages(entered, traced, sent, taken, np.array(pad.written), np.array(unchanged), outputs_interval(device))
    return {"ahead": np.array([100.0 * len(ahead) / frames]), "frame": np.array(own), **steps}


def stages(
    entered: list[float],
    traced: list[float],
    sent: list[float],
    taken: dict[float, tuple[float, float]],
    written: np.ndarray,
    unchanged: np.ndarray,
    interval: float,
) -> dict[str, np.ndarray]:
    """Milliseconds of each step of the way of the frames' blocks. Where the device does already what a report would say, the decision not
    to write it (``unchanged``) ends the way."""
    rows = []
    stamps, done = np.array(sorted(taken)), np.sort(np.concatenate([written, unchanged]))
    for entry, play, handed in zip(entered, traced, sent, strict=True):
        place = np.searchsorted(stamps, handed)
        if place == len(stamps) or stamps[place] > handed + 1.0:
            continue
        accepted, encoded = taken[stamps[place]]
        ending = np.searchsorted(done, encoded)
        if ending == len(done):
            continue
        end, before = done[ending], np.searchsorted(written, encoded) - 1
        # The wait until the device may be written to again is its own.
        wait = min(max(written[before] + interval - encoded, 0.0), end - encoded) if before >= 0 else 0.0
        rows.append([play - entry, handed - play, accepted - handed, encoded - accepted, end - encoded - wait,
                     end - entry, end - entry - wait])  # fmt: skip
    return dict(zip(STAGES, 1000 * np.array(rows).T, strict=True))


def outputs_interval(device: str) -> float:
    """Seconds between two reports over USB."""
    from haptic_tracing.core.devices.profiles import profile

    return profile(device).interval("usb")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--devices", nargs="*", choices=DEVICES, default=DEVICES)
    options = parser.parse_args()
    print(f"{options.bodies} bodies simulate, {options.frames} frames, ms as median / 99th percentile")
    print(f"{'device':12} {'bodies are':>12} {'ahead':>6}" + "".join(f"{name:>16}" for name in ("frame", *STAGES)))
    for device in options.devices:
        for haptic in (False, True):
            found = measure(options.bodies, haptic, device, options.frames)
            ahead = f"{found.pop('ahead')[0]:5.0f}%"
            cells = [f"{np.median(found[name]):6.2f} / {np.percentile(found[name], 99):6.2f}" for name in found]
            print(f"{device:12} {'haptic' if haptic else 'not haptic':>12} {ahead}" + "".join(f"{cell:>16}" for cell in cells), flush=True)
    print(f"goal: beyond at most {MEDIAN_GOAL:g} / {WORST_GOAL:g}")
    assert threading.active_count() == 1, "every thread has ended"


if __name__ == "__main__":
    main()
