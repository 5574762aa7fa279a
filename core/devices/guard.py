"""The program's side of the guard: starts the process that drives the devices, sends it orders, and
reads the statuses of the outputs.

Nothing here blocks the caller: an order is written as far as the pipe accepts it, and a thread
writes the rest; another thread reads the statuses. An order that is not written yet is replaced by
a newer one of the same method. The guard ends with the last output. A guard that does not answer is
killed, and a new one silences the devices.
"""

from __future__ import annotations

import atexit
import itertools
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from .actuation import checked_block
from .guard_process import ANSWER, HEARTBEAT, packed, started_threads
from .liveness import is_ready
from .mapping import ActuatedDevice
from .profiles import Adjustment, Profile, check_adjustment
from .sound_card import SoundCardWriter
from .status import UNREACHED, Output, Status, stop_together
from .writer import DeviceWriter

_PACKAGE = __package__.removesuffix(".core.devices")
# Importing the package would import Blender's modules: an empty module of its name, with its folder
# as the path, takes its place. Where the user may do that, the guard takes precedence over other
# programs from its first import on.
_BOOT = """
import importlib, json, os, sys, types
try:
    os.nice(-5)
except (AttributeError, OSError):
    pass
paths, package, folder, program = json.loads(sys.argv[1])
sys.path[:] = paths
names = package.split(".")
for count in range(1, len(names) + 1):
    module = types.ModuleType(".".join(names[:count]))
    module.__path__ = [folder] if count == len(names) else []
    sys.modules[module.__name__] = module
importlib.import_module(package + ".core.devices.guard_process").main(program)
"""
# Windows ends a tree of processes by following their parents: the guard's parent, which starts it
# with its own pipes, has ended by then.
_LAUNCH = (
    "import subprocess, sys; subprocess.Popen(sys.argv[2:], stdin=0, stdout=1, "
    "creationflags=int(sys.argv[1]))"
)
_EXIT_SECONDS = 1.0
_FULL = 0.002  # seconds after which a full pipe is tried again
# Seconds without an answer after which the guard is killed, while a device is open and otherwise:
# starting it and searching take long.
_ANSWERS_WITHIN, _STARTS_WITHIN = 0.5, 10.0
# More seconds for one that waits for a processor, for which a new one would wait, too.
_BUSY = 1.0
# Earlier orders that an order makes obsolete, besides those of the same method.
_OBSOLETE = {
    "send": ("expect",),
    **dict.fromkeys(("silence", "rest", "request_stop"), ("send", "expect")),
}


def start_process(by_launcher: bool = sys.platform == "win32") -> subprocess.Popen[bytes]:
    """Start the guard with the Python that runs this program (Blender's own, inside Blender).
    Raises OSError.

    by_launcher: it is the child of a process that ends at once. On Windows it leaves the job of the
    program if that permits it.
    """
    paths = [str(Path(path).absolute()) for path in sys.path if path]
    what = json.dumps([paths, _PACKAGE, str(Path(__file__).parents[2]), os.getpid()])
    run = [sys.executable, "-I", "-S", "-c"]
    flags = getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(
        subprocess, "ABOVE_NORMAL_PRIORITY_CLASS", 0
    )
    command = [*run, _LAUNCH, str(flags), *run, _BOOT, what] if by_launcher else [*run, _BOOT, what]

    def start(flags: int) -> subprocess.Popen[bytes]:
        pipe = subprocess.PIPE
        return subprocess.Popen(
            command, stdin=pipe, stdout=pipe, start_new_session=True, creationflags=flags
        )

    try:
        return start(flags | getattr(subprocess, "CREATE_BREAKAWAY_FROM_JOB", 0))
    except PermissionError:
        return start(flags)


class Guard:
    """A guard process, the orders to be written to it, and the last status of each output."""

    def __init__(self, output: DeviceOutput, name: str) -> None:
        """Start the process for an output, as in `open`. Raises OSError if it cannot be started."""
        self._process = _state.start()
        self._pid = self._process.pid
        self._never_blocks = _never_blocks(self._process.stdin)
        self._condition = threading.Condition()
        # Guarded by _condition:
        self._orders: dict[tuple[int, str], tuple[Any, ...]] = {}
        self._unwritten = memoryview(b"")
        self._outputs: dict[int, DeviceOutput] = {}
        self._statuses: dict[int, Status] = {}
        self._replaced: dict[int, int] = {}
        self._closing = self._lost = self._answered = False
        self._ended = threading.Event()
        self.open(output, name)  # before its first answer is read: one without outputs is its last
        self._threads = started_threads(orders=self._write, statuses=self._read, watch=self._watch)

    def open(self, output: DeviceOutput, name: str = "open") -> bool:
        """Let the guard create and start an output, or ``quieten`` its device. Returns False if the
        guard is ending."""
        with self._condition:
            if self._closing or self._ended.is_set():
                return False
            self._outputs[output.number] = output
            self._orders[output.number, name] = (output.make,)
            self._write_some()
            return True

    def outputs(self) -> list[DeviceOutput]:
        """The outputs that have not ended."""
        with self._condition:
            return [
                output
                for number, output in self._outputs.items()
                if not self._status(number).is_over
            ]

    def order(self, number: int, name: str, *arguments: Any) -> None:
        """Call a method of an output, in the order of the calls; a later call of the same method
        replaces a pending one."""
        with self._condition:
            before = self._orders.pop((number, name), None)
            if name == "send":
                self._replaced[number] = self._replaced.get(number, 0) + (before is not None)
            for obsolete in _OBSOLETE.get(name, ()):
                self._orders.pop((number, obsolete), None)
            self._orders[number, name] = arguments
            self._write_some()

    def status(self, number: int) -> Status:
        """The last status of an output."""
        with self._condition:
            status = self._status(number)
            return replace(
                status, dropped_blocks=status.dropped_blocks + self._replaced.get(number, 0)
            )

    def _status(self, number: int) -> Status:
        return self._statuses.get(number, Status())

    def wait_until_over(self, number: int, timeout: float) -> bool:
        """Wait for the end of an output, or of the guard. Returns whether the output has ended."""
        with self._condition:
            self._condition.wait_for(lambda: self._lost or self._status(number).is_over, timeout)
            return self._status(number).is_over

    def join(self, timeout: float) -> None:
        """Wait for the guard's end, which comes after that of the last output."""
        deadline = time.monotonic() + timeout
        for thread in self._threads:
            thread.join(max(deadline - time.monotonic(), 0.0))

    def _write_some(self) -> None:
        """Write orders as far as the pipe accepts them at once; the thread writes the rest. Called
        under _condition.

        The thread alone would have to wait until the caller releases the GIL.
        """
        if not self._never_blocks or self._closing or self._lost:
            self._condition.notify_all()
            return
        if not self._unwritten and self._orders:
            self._unwritten = _message(self._orders)
            self._orders = {}
        # The pipe is full; or the guard has ended, which the thread of statuses sees.
        with suppress(OSError):
            self._unwritten = self._unwritten[
                os.write(self._process.stdin.fileno(), self._unwritten) :
            ]

    def _write(self) -> None:
        """The thread that writes a heartbeat, and orders that could not be written at once."""
        pipe = self._process.stdin
        try:
            while True:
                with self._condition:
                    if self._never_blocks or not self._orders:
                        self._condition.wait(HEARTBEAT if not self._unwritten else _FULL)
                    if self._closing or self._lost:
                        return
                    if not self._unwritten:
                        self._unwritten = _message(self._orders)
                        self._orders = {}
                    if self._never_blocks:
                        self._write_some()
                        continue
                    message = self._unwritten
                    self._unwritten = memoryview(b"")
                pipe.write(message)
                pipe.flush()
        except OSError:
            pass  # the guard has ended, which the other thread sees
        finally:
            with suppress(OSError):
                pipe.close()

    def _read(self) -> None:
        """The thread that reads statuses."""
        try:
            while True:
                pid, statuses = pickle.load(self._process.stdout)
                with self._condition:
                    self._pid, self._statuses, self._answered = pid, statuses, True
                    self._closing = all(self._status(number).is_over for number in self._outputs)
                    self._condition.notify_all()
        except (EOFError, OSError, pickle.UnpicklingError):
            pass
        code = self._process.wait()
        self._process.stdout.close()
        self._ended.set()
        _state.quieten(self.outputs(), f"the process that guards the devices has ended ({code})")
        with self._condition:
            self._lost = True
            self._condition.notify_all()

    def _watch(self) -> None:
        """The thread that kills a guard that does not answer. It counts its own steps, because this
        program may have been stopped."""
        silent = 0
        while not self._ended.wait(ANSWER):
            with self._condition:
                silent = 0 if self._answered else silent + 1
                self._answered = False
                drives = any(status.state == "open" for status in self._statuses.values())
            late = silent * ANSWER - (_ANSWERS_WITHIN if drives else _STARTS_WITHIN)
            if late >= _BUSY or (late >= 0.0 and not is_ready(self._pid)):
                self._kill()

    def _kill(self) -> None:
        if self._pid == self._process.pid:
            self._process.kill()
        else:
            with suppress(OSError):  # it has just ended
                os.kill(self._pid, getattr(signal, "SIGKILL", signal.SIGTERM))


def _message(orders: Mapping[tuple[int, str], tuple[Any, ...]]) -> memoryview:
    """Orders as the guard reads them."""
    return memoryview(
        pickle.dumps(
            [(*key, arguments) for key, arguments in orders.items()], pickle.HIGHEST_PROTOCOL
        )
    )


def _never_blocks(pipe: BinaryIO) -> bool:
    """Make a pipe non-blocking for writes. Returns False if the system cannot (Windows before
    Python 3.12)."""
    try:
        os.set_blocking(pipe.fileno(), False)
    except (AttributeError, OSError):
        return False
    return True


class _RunningGuard:
    """The guard that runs, if any. start: starts a guard process."""

    def __init__(self) -> None:
        self.start: Callable[[], Any] = start_process
        self._lock = threading.Lock()
        self.guard: Guard | None = None
        self.numbers = itertools.count()

    def open(self, output: DeviceOutput, name: str = "open") -> Guard:
        """Let a guard drive one more output, or ``quieten`` its device. Raises OSError if none can
        be started."""
        with self._lock:
            if self.guard is None or not self.guard.open(output, name):
                self.guard = Guard(output, name)
            return self.guard

    def quieten(self, outputs: Iterable[DeviceOutput], reason: str) -> None:
        """Silence devices whose guard ended while it drove them, by a new guard."""
        for output in outputs:
            try:
                output.lose(self.open(output, "quieten"), reason)
            except OSError as error:
                output.lose(None, f"{reason}, and no other can be started: {error}")


_state = _RunningGuard()


class DeviceOutput(Output):
    """One device that is fed with blocks of samples, one row per actuator of its profile, and that
    the guard process drives.

    number: by which the guard knows it. make: makes its writer inside the guard; is pickled.
    """

    def __init__(
        self, profile: ActuatedDevice, adjustment: Adjustment | None = None, **options: Any
    ) -> None:
        """options: those of `DeviceWriter`, or of `SoundCardWriter`. Raises ValueError as these
        do."""
        writer: Callable[..., Output] = (
            DeviceWriter if isinstance(profile, Profile) else SoundCardWriter
        )
        self.make = partial(writer, profile, adjustment=adjustment, **options)
        self.make()
        self.profile = profile
        self.number = -1
        self._guard: Guard | None = None
        self._own = Status()
        self._lost = ""  # why its guard ended; another one then silences the device

    def start(self) -> None:
        self.number = next(_state.numbers)
        self._own = Status()
        self._lost = ""
        try:
            self._guard = _state.open(self)
        except OSError as error:
            self._own = Status(
                "failed", f"the process that guards the devices can't be started: {error}"
            )

    def wait_until_open(self, patience: float) -> None:
        """Wait until the device is open. Raises OSError with the reason if it isn't after
        ``patience`` seconds."""
        end = time.monotonic() + patience
        while (status := self.status).state == "searching" and not status.message:
            if time.monotonic() > end:
                break
            time.sleep(0.01)
        if status.state != "open":
            raise OSError(status.message or f"{self.profile.title} can't be opened")

    def lose(self, guard: Guard | None, reason: str) -> None:
        """Fail for a reason, while ``guard`` silences the device."""
        self._own = Status("failed", reason)
        self._lost, self._guard = reason, guard

    def adjust(self, adjustment: Adjustment) -> None:
        check_adjustment(adjustment, self.profile.actuators)
        self._order("adjust", adjustment)

    def send(self, block: ArrayLike, sent: float | None = None) -> float:
        checked = checked_block(np.asarray(block), len(self.profile.actuators))
        sent = time.perf_counter() if sent is None else sent
        self._order("send", packed(checked), sent)
        return sent

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        self._order(
            "expect", packed(checked_block(np.asarray(ahead), len(self.profile.actuators))), sent
        )

    def silence(self) -> None:
        self._order("silence")

    def rest(self) -> None:
        self._order("rest")

    def request_stop(self) -> None:
        self._order("request_stop")
        if self._guard is None and not self._own.is_over:
            self._own = Status("stopped")

    def stop(self, timeout: float = 1.0) -> bool:
        self.request_stop()
        deadline = time.monotonic() + timeout
        while (guard := self._guard) is not None:
            done = guard.wait_until_over(self.number, deadline - time.monotonic())
            if done or guard is self._guard:
                return done
        return not self._lost

    @property
    def status(self) -> Status:
        if self._guard is None:
            return self._own
        status = self._guard.status(self.number)
        if not self._lost:
            return status
        outcome = {
            "stopped": "another one has silenced it",
            "failed": f"another one can't silence it ({status.message}): {UNREACHED}",
        }
        found = outcome.get(status.state, "another one is silencing it")
        return Status("failed", f"{self._lost}; {found}")

    @property
    def is_silent(self) -> bool:
        """Whether its device has taken the last zero, or was never found."""
        status = self._own if self._guard is None else self._guard.status(self.number)
        return status.state == "stopped"

    def _order(self, name: str, *arguments: Any) -> None:
        if self._guard is not None and not self._lost:
            self._guard.order(self.number, name, *arguments)


def outputs() -> list[DeviceOutput]:
    """The outputs of this program that have not ended."""
    return [] if _state.guard is None else _state.guard.outputs()


@atexit.register
def stop_all(timeout: float = _EXIT_SECONDS) -> bool:
    """Stop all outputs within ``timeout`` seconds together, and the guard with them. Returns
    whether all are done."""
    deadline = time.perf_counter() + timeout
    done = stop_together(outputs(), timeout)
    if done and _state.guard is not None:
        _state.guard.join(max(deadline - time.perf_counter(), 0.0))
    return done
