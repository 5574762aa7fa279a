"""Whether another process still runs: not stopped by a signal or a debugger, not crashing, not gone."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

_CRASHES = sum(1 << member.value - 1 for member in signal.Signals if member.name in ("SIGSEGV", "SIGBUS", "SIGILL", "SIGFPE", "SIGABRT"))


def is_running(process: int) -> bool:
    """Whether a process runs, by its id. True if unknown; Windows has no stopped processes."""
    if sys.platform.startswith("linux"):
        return _runs_on_linux(process)
    if sys.platform == "darwin":
        state = subprocess.run(["/bin/ps", "-o", "state=", "-p", str(process)], capture_output=True, text=True).stdout
        return state[:1] not in ("T", "Z", "")
    return True


def _runs_on_linux(process: int) -> bool:
    """An exit is detected before the process is gone and its pipes are closed, which takes long if it frees much memory: it then has no
    address space. In a crash, the main thread runs a handler with the signal blocked, or a core dump is announced."""
    try:
        lines = Path(f"/proc/{process}/status").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return False
    fields = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
    crashing = fields.get("CoreDumping") == "1" or bool(int(fields.get("SigBlk", "0"), 16) & _CRASHES)
    return fields.get("State", "R")[:1] not in "TtZX" and not crashing and "VmSize" in fields
