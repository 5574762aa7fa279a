"""The guard process: drives the devices on the orders of a program, and silences them when that
program stops or ends.

The program sends a list of orders at least every `HEARTBEAT` seconds; a list may be empty. The
guard answers with the statuses of the outputs every `ANSWER` seconds. A closed pipe means that the
program has ended. If a list is late, the guard queries the state of the program: if it is stopped,
crashing or gone, the devices are silenced; if it runs, it only waits for the GIL, and the samples
that it has sent ahead are played.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..arrays import FloatArray
from .control_group import own_control_group
from .liveness import liveness_of
from .status import Output, Status, stop_together

HEARTBEAT = 0.010
"""Greatest time between two lists of orders [s]."""
_LATE = 0.015
_LOOK = 0.005
ANSWER = 0.050
"""Time between two answers to lists of orders [s]."""
_STOP_SECONDS = 4.0
_QUIETEN_SECONDS = 3.0

Order = tuple[int, str, tuple[Any, ...]]
"""An output's number, the name of a method (or ``open`` or ``quieten``) and its arguments."""


class Service:
    """The outputs of a program, driven on its orders."""

    def __init__(self, orders: BinaryIO, statuses: BinaryIO, program: int) -> None:
        """orders, statuses: pipes from and to the program. program: its process id."""
        self._orders, self._statuses = orders, statuses
        self._program_runs = liveness_of(program)
        self._outputs: dict[int, Output] = {}
        self._failed: dict[int, Status] = {}
        self._quieting: list[threading.Thread] = []
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._heard = time.perf_counter()  # when orders were last read, or executed

    def run(self) -> None:
        """Execute orders until the program ends, then silence and close the devices."""
        threads = started_threads(watch=self._watch)
        answered = 0.0
        try:
            while True:
                orders: list[Order] = pickle.load(self._orders)
                self._heard = time.perf_counter()
                for number, name, arguments in orders:
                    self._obey(number, name, arguments)
                self._heard = time.perf_counter()
                if self._heard - answered >= ANSWER:
                    answered = self._heard
                    self._answer()
        except (EOFError, OSError, ValueError, pickle.UnpicklingError):
            pass  # the program has ended
        finally:
            self._end()
            for thread in threads:
                thread.join()

    def _obey(self, number: int, name: str, arguments: tuple[Any, ...]) -> None:
        if name in ("open", "quieten"):
            self._open(number, name, *arguments)
        elif number in self._outputs:
            getattr(self._outputs[number], name)(*map(_unpacked, arguments))

    def _open(self, number: int, name: str, make: Callable[[], Output]) -> None:
        try:
            output = make()
            output.start()
        except Exception as error:
            self._failed[number] = Status("failed", f"{type(error).__name__}: {error}")
            return
        with self._lock:
            self._outputs[number] = output
        if name == "quieten":
            self._quieting += started_threads(quieten=partial(self._quieten, number, output))

    def _quieten(self, number: int, output: Output) -> None:
        """Silence device ``number`` by opening it, which writes zero, and closing it again. If it
        can't be opened within `_QUIETEN_SECONDS`, its status becomes "failed"."""
        deadline = time.perf_counter() + _QUIETEN_SECONDS
        while output.status.state == "searching" and time.perf_counter() < deadline:
            time.sleep(_LOOK)
        before = output.status
        if before.state == "searching":
            self._failed[number] = Status("failed", before.message)
        output.request_stop()

    def _watch(self) -> None:
        """The thread that silences the devices while the program is stopped, again after orders
        that were still executed."""
        silenced = 0.0
        while not self._ended.wait(_LOOK):
            heard = self._heard
            if (
                heard != silenced
                and time.perf_counter() - heard > _LATE
                and not self._program_runs()
            ):
                silenced = heard
                for output in self._all():
                    output.silence()

    def _answer(self) -> None:
        """Send the id of this process and the statuses of the outputs, which also tells the program
        that the guard works."""
        statuses = {
            number: output.status for number, output in self._outputs.items()
        } | self._failed
        pickle.dump((os.getpid(), statuses), self._statuses)
        self._statuses.flush()

    def _all(self) -> list[Output]:
        with self._lock:
            return list(self._outputs.values())

    def _end(self) -> None:
        deadline = time.perf_counter() + _STOP_SECONDS
        for thread in self._quieting:
            thread.join()
        self._ended.set()
        stop_together(self._all(), max(deadline - time.perf_counter(), 0.0))


def started_threads(**works: Callable[[], None]) -> list[threading.Thread]:
    """Threads that do these works, by their names."""
    threads = [
        threading.Thread(target=work, name=f"haptics guard {name}", daemon=True)
        for name, work in works.items()
    ]
    for thread in threads:
        thread.start()
    return threads


def packed(block: FloatArray) -> tuple[int, bytes]:
    """A block (actuators, n) in transmitted form: pickling an array takes ten times as long."""
    return len(block), block.tobytes()


def _unpacked(argument: Any) -> Any:
    return (
        np.frombuffer(argument[1]).reshape(argument[0], -1)
        if isinstance(argument, tuple)
        else argument
    )


def main(program: int) -> None:
    """Run as the guard of the process ``program``; its pipes are standard input and output. Ends
    this process without exit handlers: after hidapi's own, a thread whose write was blocked until
    then would crash."""
    for name in ("SIGINT", "SIGHUP"):  # of the terminal; they are meant for the program
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    if sys.platform == "win32":  # Windows wakes threads up to 15.6 ms late
        ctypes.WinDLL("winmm").timeBeginPeriod(1)
    with suppress(OSError):  # Linux wakes threads up to 50 us late, to save power
        Path("/proc/self/timerslack_ns").write_text("1")
    statuses = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no status
    with suppress(SystemExit), own_control_group():
        Service(os.fdopen(os.dup(0), "rb"), statuses, program).run()
    with suppress(OSError):  # half an answer may be left that nobody reads
        statuses.close()
    os._exit(0)
