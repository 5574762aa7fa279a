"""Runs inside umockdev: the demo scene is baked, then played in time through the whole add-on to
made-up devices. Prints one JSON object.

What each device's pace is asked and told is written down with the time, and told once more to a
fresh one, with the baked blocks in place of those that were played: what it answers must be what
the device's node has kept, report by report.
"""

import json
import math
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "core" / "devices"))

import bpy
import haptic_tracing
import numpy as np
from guard_in_thread import GuardInThread
from haptic_tracing.addon.live_output import handlers, outputs, player
from haptic_tracing.addon.session import session, timeline
from haptic_tracing.core.devices import guard, writer
from haptic_tracing.core.devices.connection import hid_module
from haptic_tracing.sample_scenes import build_sample

SECONDS = 2.5


class RecordingPacing:
    """A device's pace, with everything that it was asked and told, in order."""

    def __init__(self, make):
        self.make, self.pacing, self.calls = make, make(), []
        self.interval, self.lead = self.pacing.interval, self.pacing.lead

    def __getattr__(self, name):
        method = getattr(self.pacing, name)

        def call(*arguments):
            answer = method(*arguments)
            self.calls.append((name, arguments, answer))
            return answer

        return call

    def again(self, baked):
        """The reports that a fresh pace gives, and how many of the blocks that were played were not
        the baked ones."""
        fresh, reports, different = self.make(), [], 0
        for name, arguments, _ in self.calls:
            if name == "accept":
                played, sent = arguments
                block = baked(sent)
                different += not np.array_equal(block, played)
                arguments = block, sent
            answer = getattr(fresh, name)(*arguments)
            reports += (
                answer
                if name == "ending"
                else [answer]
                if name == "next_report" and answer is not None
                else []
            )
        return [report.data.hex() for report in reports], different


class RecordingHid:
    """The real module, with a copy of the feature reports, which umockdev answers but does not
    keep."""

    def __init__(self):
        self.real, self.features = hid_module(), {}

    def enumerate(self, *arguments):
        return self.real.enumerate(*arguments)

    def device(self):
        recorder, real = self, self.real.device()

        class Device:
            path = b""

            def __getattr__(self, name):
                return getattr(real, name)

            def open_path(self, path):
                self.path = path
                real.open_path(path)

            def send_feature_report(self, data):
                kept = bytes(data).hex()
                sent = real.send_feature_report(data)
                recorder.features.setdefault(self.path, []).append(kept)
                return sent

        return Device()


def wait_until(condition, seconds=30.0):
    end = time.perf_counter() + seconds
    while not condition():
        if time.perf_counter() > end:
            raise TimeoutError("did not come true")
        time.sleep(0.005)


def main():
    recorded = {}
    real_pacing_of, hid = writer.pacing_of, RecordingHid()

    def pacing_of(profile, family, transport, rate, adjustment, sequence):
        def make():
            return real_pacing_of(profile, family, transport, rate, adjustment, sequence)

        recorded[profile.name, transport] = RecordingPacing(make)
        return recorded[profile.name, transport]

    writer.pacing_of = pacing_of
    writer.hid_module = lambda: hid
    guard._state.start = GuardInThread
    player.SLOW = math.inf  # every frame is waited for, however busy the machine is
    haptic_tracing.register()
    scene = build_sample("jackhammer_bench")
    start, count = scene.frame_start, round(SECONDS * scene.render.fps / scene.render.fps_base)

    blocks = {}
    for frame in range(start, start + count + 1):
        timeline.set_frame(scene, frame)
        blocks[frame] = session.result_of(scene).block
    result = session.result_of(scene)

    scene.frame_set(start)
    bpy.ops.haptic.find_devices()
    outputs.wait_until_found()
    keys = [found.key for found in outputs.inventory().devices if not found.device.experimental]
    for key in keys:
        bpy.ops.haptic.connect_device(device=key)
    wait_until(lambda: all(output.status.state == "open" for output in outputs.running().values()))
    scene.frame_set(start)  # felt as a grain: what follows must not depend on it
    time.sleep(0.5)
    for recorder in recorded.values():
        recorder.scrubbed = len(recorder.calls)

    frames = []
    handlers.animation_playback_pre(scene)
    began = time.perf_counter()
    for frame in range(start + 1, start + count + 1):
        time.sleep(
            max(began + (frame - start) * handlers.frame_seconds(scene) - time.perf_counter(), 0.0)
        )
        frames.append((time.perf_counter(), frame))
        scene.frame_set(frame)
    mapping = player.mapping_of(session.result_of(scene), {})
    handlers.animation_playback_post(scene)
    time.sleep(0.3)
    states = {
        key: [output.status.state, output.status.losses, output.status.failed_writes]
        for key, output in outputs.running().items()
    }
    running = dict(outputs.running())
    haptic_tracing.unregister()  # waits for a second, which on a busy machine need not be enough
    wait_until(lambda: all(output.status.is_over for output in running.values()))

    first_played = frames[0][0]
    answer = {"listeners": len(result.listeners), "states": states, "devices": {}}
    for key, output in running.items():
        transport = "bt" if "a0:ab" in key else "usb"
        recorder = recorded[output.profile.name, transport]

        def baked(sent, key=key, recorder=recorder):
            if sent < first_played:  # the grain
                return next(
                    arguments[0]
                    for name, arguments, _ in recorder.calls
                    if name == "accept" and arguments[1] == sent
                )
            frame = max(number for at, number in frames if at <= sent)
            return mapping.blocks(blocks[frame])[key]

        reports, different = recorder.again(baked)
        answer["devices"][f"{output.profile.name} {transport}"] = {
            "expected": reports,
            "captured": captured(output.profile.name, transport, hid, len(reports[0]) // 2),
            "blocks": sum(name == "accept" for name, _, _ in recorder.calls),
            "different": different,
            "delay": output.status.delay,
        }
    print(json.dumps(answer))


def captured(name, transport, hid, length):
    """The reports that a device's node has kept."""
    if name == "steam-deck":
        return next(iter(hid.features.values()))
    node = Path("/dev") / json.loads(sys.argv[1])[f"{name} {transport}"]
    data = node.read_bytes()
    assert len(data) % length == 0, (name, len(data), length)
    reports = [data[i : i + length].hex() for i in range(0, len(data), length)]
    # A Switch pad is set up before its pace begins.
    return [report for report in reports if not (name == "switch-pro" and report.startswith("01"))]


main()
