"""When a guard that does not answer is replaced, and when it is left alone."""

import os
import subprocess
import sys
import time
from pathlib import Path

import haptic_tracing
import pytest
from file_hid import file_device, reports_of
from haptic_tracing.core.devices import guard
from haptic_tracing.core.devices.profile_files import profile


@pytest.fixture
def pad(tmp_path):
    """An output that is open."""
    device = profile("dualsense")
    output = guard.DeviceOutput(device, hid=file_device(str(tmp_path / "reports"), device.family))
    output.start()
    output.wait_until_open(20.0)
    yield output
    output.stop(20.0)


LOADED = f"""
import importlib, sys, types
package = types.ModuleType("haptic_tracing")
package.__path__ = [{str(Path(haptic_tracing.__file__).parent)!r}]
sys.modules["haptic_tracing"] = package
importlib.import_module("haptic_tracing.core.devices.guard_process")
importlib.import_module("haptic_tracing.core.devices.writer")
print(*sys.modules)
"""


def test_a_guard_is_there_soon():
    """It reads no files: schemas and what a scene holds would make half of its start."""
    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True)
    loaded = done.stdout.split()
    assert "haptic_tracing.core.devices.writer" in loaded
    assert not {"haptic_tracing.core.formats.io.schema", "haptic_tracing.core.scene.values"} & set(
        loaded
    )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="schedulers of Linux")
def test_a_guard_that_others_keep_from_the_processor_is_not_replaced(pad):
    """For 0.8 s, of which Linux leaves it a twentieth at most: a program of real-time priority has
    its processor. A new guard would have none either."""
    watched = guard._state.guard._pid
    processor = {max(os.sched_getaffinity(0))}
    for thread in Path(f"/proc/{watched}/task").iterdir():
        os.sched_setaffinity(int(thread.name), processor)
    busy = subprocess.Popen(
        [sys.executable, "-c", "import time\nend = time.time() + 0.8\nwhile time.time() < end: 0"]
    )
    try:
        os.sched_setaffinity(busy.pid, processor)
        os.sched_setscheduler(busy.pid, os.SCHED_FIFO, os.sched_param(10))
    except PermissionError:
        pytest.skip("only root has real-time priority")
    finally:
        busy.wait(20)
    time.sleep(0.3)
    assert (pad.status.state, guard._state.guard._pid) == ("open", watched)


@pytest.mark.slow
def test_a_device_opens_although_the_guard_may_have_answered_before(tmp_path, monkeypatch):
    """Before the program has told the guard of its first device: another thread can hold Python's
    lock in between."""
    told = guard.Guard.open

    def late(self, *what):
        time.sleep(2.0)
        return told(self, *what)

    monkeypatch.setattr(guard.Guard, "open", late)
    pad = profile("dualsense")
    output = guard.DeviceOutput(pad, hid=file_device(str(tmp_path / "reports"), pad.family))
    output.start()
    try:
        output.wait_until_open(20.0)
    finally:
        output.stop(20.0)
    assert output.is_silent and reports_of(tmp_path / "reports")
