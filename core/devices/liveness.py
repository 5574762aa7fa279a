"""Whether another process runs: not after its end, and where the system says so, not while it is
stopped or crashes.

Linux reads ``/proc``, macOS is asked through kqueue and libproc, Windows through a handle of the
process.
"""

from __future__ import annotations

import ctypes
import select
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

IsRunning = Callable[[], bool]

_CRASHES = sum(
    1 << member.value - 1
    for member in signal.Signals
    if member.name in ("SIGSEGV", "SIGBUS", "SIGILL", "SIGFPE", "SIGABRT")
)
_SYNCHRONIZE, _WAIT_TIMEOUT = 0x0010_0000, 0x102
# libproc's flavour PROC_PIDTBSDINFO, the size of its answer, and the states of sys/proc.h.
_PIDTBSDINFO, _BSDINFO_SIZE, _STOPPED, _ZOMBIE = 3, 136, 4, 5


def liveness_of(process: int) -> IsRunning:
    """A function that tells whether a process, by its id, runs. True on systems where that is
    unknown."""
    if sys.platform.startswith("linux"):
        return lambda: runs_on_linux(process)
    if sys.platform == "darwin":
        return runs_on_macos(process, select, ctypes.CDLL("/usr/lib/libproc.dylib"))
    if sys.platform == "win32":
        return runs_on_windows(process, ctypes.WinDLL("kernel32", use_last_error=True))
    return lambda: True


def runs_on_linux(process: int) -> bool:
    """An exit is detected before the process is gone and its pipes are closed, which takes long if
    it frees much memory: it then has no address space. In a crash, the main thread runs a handler
    with the signal blocked, or a core dump is announced."""
    try:
        lines = (
            Path(f"/proc/{process}/status")
            .read_text(encoding="ascii", errors="replace")
            .splitlines()
        )
    except OSError:
        return False
    fields = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
    crashing = fields.get("CoreDumping") == "1" or bool(
        int(fields.get("SigBlk", "0"), 16) & _CRASHES
    )
    return fields.get("State", "R")[:1] not in "TtZX" and not crashing and "VmSize" in fields


def is_ready(process: int) -> bool:
    """Whether a thread of a process runs or waits for a processor; False on other systems than
    Linux."""
    for thread in Path(f"/proc/{process}/task").glob("*/stat"):
        with suppress(OSError):  # it has just ended
            if thread.read_text(errors="replace").rpartition(")")[2].split()[0] == "R":
                return True
    return False


def runs_on_macos(process: int, select: Any, libproc: Any) -> IsRunning:
    """kqueue reports the exit of the process that has this id now, libproc whether it is stopped.

    select, libproc: the module and the library of the system.
    """
    queue = select.kqueue()
    ended = False
    try:
        queue.control(
            [select.kevent(process, select.KQ_FILTER_PROC, select.KQ_EV_ADD, select.KQ_NOTE_EXIT)],
            0,
        )
    except ProcessLookupError:
        ended = True

    def is_running() -> bool:
        nonlocal ended
        ended = ended or bool(queue.control(None, 1, 0))
        answer = ctypes.create_string_buffer(_BSDINFO_SIZE)
        if (
            ended
            or libproc.proc_pidinfo(
                process, _PIDTBSDINFO, ctypes.c_uint64(0), answer, _BSDINFO_SIZE
            )
            != _BSDINFO_SIZE
        ):
            return False
        return int.from_bytes(answer.raw[4:8], sys.byteorder) not in (_STOPPED, _ZOMBIE)

    return is_running


def runs_on_windows(process: int, kernel32: Any) -> IsRunning:
    """A handle of the process is signalled at its end; there are no stopped processes. kernel32:
    the library of the system."""
    kernel32.OpenProcess.restype = ctypes.c_void_p
    handle = kernel32.OpenProcess(_SYNCHRONIZE, False, process)
    return lambda: (
        bool(handle) and kernel32.WaitForSingleObject(ctypes.c_void_p(handle), 0) == _WAIT_TIMEOUT
    )
