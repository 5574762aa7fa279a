"""What the guard does on Windows and macOS, with their primitives injected; the workflow runs the
systems' own."""

import os
import signal
import struct
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from haptic_tracing.core.devices import guard
from haptic_tracing.core.devices.liveness import liveness_of, runs_on_macos, runs_on_windows


@pytest.fixture
def process():
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    yield process
    process.kill()
    process.wait(20)


def test_a_process_runs_until_it_ends(process):
    """The primitives of the system that this runs on."""
    runs = liveness_of(process.pid)
    assert runs()
    process.kill()
    process.wait(20)
    assert not runs()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows stops no processes")
def test_a_stopped_process_does_not_run(process):
    runs = liveness_of(process.pid)
    for sent, is_running in ((signal.SIGSTOP, False), (signal.SIGCONT, True)):
        process.send_signal(sent)
        deadline = time.monotonic() + 30
        while runs() != is_running and time.monotonic() < deadline:
            time.sleep(0.001)
        assert runs() == is_running


class Macos:
    """libproc and kqueue, as <sys/proc_info.h> and <sys/event.h> describe them."""

    KQ_FILTER_PROC, KQ_EV_ADD, KQ_NOTE_EXIT = -5, 0x1, 0x8000_0000

    def __init__(self, pid):
        self.pid, self.state, self.exits, self.waited_for = pid, 2, [], None

    def kqueue(self):
        return self

    def kevent(self, ident, filter, flags, fflags):
        return ident, filter, flags, fflags

    def control(self, changes, events, timeout=None):
        if changes:
            (self.waited_for,) = changes
            if self.waited_for[0] != self.pid:
                raise ProcessLookupError(3, "No such process")
            return []
        return self.exits[:events]

    def proc_pidinfo(self, pid, flavor, argument, buffer, size):
        if pid != self.pid or flavor != 3:
            return 0
        # struct proc_bsdinfo: flags, status, ten numbers, names of 16 and 32 bytes, six numbers,
        # two of 64 bits.
        info = struct.pack(
            "=12I16s32s5IiQQ", 0, self.state, *range(10), b"blender", b"blender", *range(5), 0, 1, 2
        )
        buffer.raw = info
        return len(info)


def test_macos_knows_an_exit_by_kqueue_and_a_stop_by_libproc():
    system = Macos(4711)
    runs = runs_on_macos(4711, system, system)
    assert system.waited_for == (4711, system.KQ_FILTER_PROC, system.KQ_EV_ADD, system.KQ_NOTE_EXIT)
    assert runs()
    system.state = 4  # SSTOP
    assert not runs()
    system.state = 2  # SRUN
    assert runs()
    system.exits.append("exit")
    assert not runs()
    system.exits.clear()
    assert not runs(), "another process may have the id by now"


def test_macos_knows_that_a_process_is_gone():
    system = Macos(4711)
    assert not runs_on_macos(4712, system, system)()


@pytest.mark.parametrize(
    ("handle", "answers", "expected"), [(8, [0x102, 0], [True, False]), (0, [0x102], [False])]
)
def test_windows_knows_an_exit_by_a_handle(handle, answers, expected):
    """OpenProcess returns NULL for a process that is gone; WaitForSingleObject WAIT_TIMEOUT (0x102)
    or WAIT_OBJECT_0 (0)."""
    asked = []

    def open_process(access, inherits, pid):
        asked.append((access, inherits, pid))
        return handle

    system = SimpleNamespace(
        OpenProcess=open_process, WaitForSingleObject=lambda handle, timeout: answers.pop(0)
    )
    runs = runs_on_windows(4711, system)
    assert [runs() for _ in expected] == expected
    assert asked == [(0x100000, False, 4711)]


@pytest.mark.parametrize("permits", [True, False])
def test_windows_starts_the_guard_outside_of_tree_and_job(monkeypatch, permits):
    """CreateProcess refuses CREATE_BREAKAWAY_FROM_JOB where the job does not permit it."""
    flags = {
        "CREATE_NO_WINDOW": 0x0800_0000,
        "ABOVE_NORMAL_PRIORITY_CLASS": 0x8000,
        "CREATE_BREAKAWAY_FROM_JOB": 0x0100_0000,
    }
    for name, value in flags.items():
        monkeypatch.setattr(subprocess, name, value, raising=False)
    started = []

    def start(command, creationflags, **_):
        started.append((command, creationflags))
        if creationflags & 0x0100_0000 and not permits:
            raise PermissionError(13, "Access is denied")

    monkeypatch.setattr(subprocess, "Popen", start)
    guard.start_process(by_launcher=True)
    assert [given for _, given in started] == (
        [0x0900_8000] if permits else [0x0900_8000, 0x0800_8000]
    )
    command = started[-1][0]
    assert command[4].startswith("import subprocess") and command[5] == str(0x0800_8000), (
        "it starts the guard and ends"
    )
    assert command[6] == sys.executable and str(os.getpid()) in command[-1]
