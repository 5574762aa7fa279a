"""Runs inside umockdev: ``haptic-tracing play`` on a pad, with a terminal whose keys are pressed at
given seconds. In place of keys, SIGKILL or SIGSTOP reaches the guard.

Prints the exit code, the second at which each key was pressed, and the reports written to the pad,
as JSON.

Called as ``umockdev-run ... -- python play_on_a_pad.py FOLDER FILE [KEY SECONDS]...``.
"""

import json
import os
import pty
import signal
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "core" / "devices"))

from haptic_tracing.command_line import main, play
from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.profile_files import profile
from timed_hid import TimedHid, reports_of
from umockdev_scenes import children

folder, file, presses = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
log = folder / "log"
log.mkdir()


class Stage(DeviceStage):
    """The pad, whose reports are written down with their times."""

    @classmethod
    def of(cls, wanted):
        return cls({"pad": DeviceOutput(profile("xbox"), hid=TimedHid(str(log)), rate=8000)})


play.DeviceStage = Stage
keyboard, terminal = pty.openpty()
sys.stdin = os.fdopen(terminal)
pressed = []


def press():
    while not any(log.iterdir()):
        time.sleep(0.01)
    begun = time.perf_counter()
    for key, seconds in zip(presses[::2], map(float, presses[1::2]), strict=True):
        time.sleep(max(begun + seconds - time.perf_counter(), 0.0))
        pressed.append(time.perf_counter())
        if key.startswith("SIG"):
            (guard,) = children()
            os.kill(guard, signal.Signals[key])
        else:
            os.write(keyboard, key.encode())


if presses:
    threading.Thread(target=press, daemon=True).start()
code = main(["play", file])
ended = time.perf_counter()
reports = [(seconds, data.hex()) for seconds, data in reports_of(log, "hidraw0")]
print(json.dumps([code, pressed, ended, reports]), flush=True)
os._exit(0)
