"""The guard with the system's own processes, pipes and timers, on Windows, macOS and Linux; the
device is a file that the test reads."""

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from bounded_program import bounded, line_of
from file_hid import reports_of
from processor_waits import Waits

HERE = Path(__file__).parent
WINDOWS, MACOS = sys.platform == "win32", sys.platform == "darwin"
SILENT_WITHIN = 0.150
REPLACED_WITHIN = 1.5
PROGRAM = """
import sys, time
from dataclasses import replace
sys.path.insert(0, {here!r})
import numpy as np
from file_hid import file_device
from haptic_tracing.core.devices import guard
from haptic_tracing.core.devices.profile_files import profile

device = replace(profile({name!r}), slew=10_000.0)
def started():
    output = guard.DeviceOutput(device, hid=file_device({file!r}, device.family))
    output.start()
    output.wait_until_open(60.0)
    return output
def play(output, seconds):
    begun = time.perf_counter()
    while (now := time.perf_counter()) < begun + seconds:
        wave = 0.5 * np.sin(2 * np.pi * 200.0 * (now - begun + np.arange(4000) / 8000))
        output.expect(np.tile(wave[320:], (2, 1)), output.send(np.tile(wave[:320], (2, 1))))
        time.sleep(0.04)
output = started()
print(output._guard._pid, flush=True)
"""

pytestmark = pytest.mark.slow


@pytest.fixture
def program(tmp_path):
    """Starts a program that plays on a device: returns it, the id of its guard, and the file of the
    device."""

    def start(rest, name="dualsense"):
        file = tmp_path / "reports"
        source = PROGRAM.format(here=str(HERE), name=name, file=str(file)) + rest
        command = [sys.executable, "-c", source]
        program = started.enter_context(bounded(command, stdout=subprocess.PIPE))
        return program, int(line_of(program)), file

    with ExitStack() as started:
        yield start


def silence_after(file, failed, seconds, guard):
    """Seconds from a failure to the zero that follows the last drive, and how many of them the
    guard can have waited for a processor; the device has to be driven until the failure, and silent
    afterwards."""
    # The guard's thread that watches the program wakes a device's thread.
    chain, waits = Waits({guard: 2}), []
    while (now := time.perf_counter() - failed) < seconds:
        waits.append((now, chain.until_now()))
        time.sleep(0.01)
    reports = [(at - failed, bool(data[3] or data[4])) for at, data in reports_of(file)]
    drives = [at for at, is_driven in reports if is_driven]
    assert drives[-1] > -0.3, "it is driven until the failure"
    silent = next(at for at, is_driven in reports if at > drives[-1] and not is_driven)
    return silent, next((waited for at, waited in waits if at >= silent), 0.0)


def end_tree(process):
    """End a process as the task manager does, with all that it has started."""
    subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], check=True, timeout=60)


ENDINGS = {"kill": lambda process: process.kill()}
if WINDOWS:
    ENDINGS["process tree"] = end_tree
else:
    ENDINGS["stop"] = lambda process: process.send_signal(signal.SIGSTOP)
    ENDINGS["crash"] = lambda process: process.send_signal(signal.SIGSEGV)


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_end_of_the_program_is_silence(program, ending):
    process, guard, file = program("play(output, 60)")
    time.sleep(0.5)
    ENDINGS[ending](process)
    took, waited = silence_after(file, time.perf_counter(), 1.0, guard)
    print(ending, round(1000 * took), "ms,", round(1000 * waited), "ms for a processor")
    assert took - waited < SILENT_WITHIN


@pytest.mark.parametrize("ending", ["kill", *([] if WINDOWS else ["stop"])])
def test_the_end_of_the_guard_is_silence_and_the_device_plays_again(program, ending):
    again = (
        "play(output, 1.5)\nwhile not output.is_silent: "
        "time.sleep(0.01)\nprint(flush=True)\nplay(started(), 0.5)\nguard.stop_all()"
    )
    process, guard, file = program(again)
    time.sleep(0.5)
    os.kill(
        guard, signal.SIGSTOP if ending == "stop" else signal.SIGTERM if WINDOWS else signal.SIGKILL
    )
    failed = time.perf_counter()
    line_of(process)
    before = len(reports_of(file))
    reports = [(at - failed, data) for at, data in reports_of(file)]
    took = next(at for at, data in reports if at > 0.0 and not (data[3] or data[4]))
    print(ending, round(1000 * took), "ms")
    assert took < REPLACED_WITHIN
    assert process.wait(60) == 0
    assert any(data[3] or data[4] for _, data in reports_of(file)[before:])


@pytest.mark.plugins
def test_a_stream_of_3_9_ms_gets_its_reports_in_time(program):
    """A timer of 15.6 ms would send four at a time, and three of four gaps would be none. What
    another program or a host holds up comes late and at once, so the median is compared."""
    process, _, file = program(
        "play(output, 2.0)\nguard.stop_all()\nprint(flush=True)", "steam-controller-pcm"
    )
    line_of(process)
    times = [at for at, data in reports_of(file) if data[0] == 0x88]
    gaps = sorted(1000 * (late - early) for early, late in itertools.pairwise(times))
    print(json.dumps({"median": gaps[len(gaps) // 2], "99 of 100": gaps[len(gaps) * 99 // 100]}))
    assert len(gaps) > 100
    assert gaps[len(gaps) // 2] == pytest.approx(3.875, abs=1.0)
