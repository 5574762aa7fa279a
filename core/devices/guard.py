"""The program's side of the guard: starts the process that drives the devices, sends it orders, and reads the statuses of the outputs.

Nothing here blocks the caller: an order is written as far as the pipe accepts it, and a thread writes the rest; another thread reads the
statuses. An order that is not written yet is replaced by a newer one of the same method. The guard ends with the last output.
"""

from __future__ import annotations

import atexit
import itertools
import json
import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from .actuation import checked_block
from .guard_process import HEARTBEAT, packed, started_threads
from .mapping import ActuatedDevice
from .profiles import Adjustment, Profile, check_adjustment
from .sound_card import SoundCard, SoundCardWriter
from .status import Status, ThreadedOutput, stop_together
from .writer import DeviceWriter

_PACKAGE = __package__.removesuffix(".core.devices")
# Importing the package would import Blender's modules: an empty module of its name, with its folder as the path, takes its place.
_BOOT = """
import importlib, json, sys, types
paths, package, folder, program = json.loads(sys.argv[1])
sys.path[:] = paths
names = package.split(".")
for count in range(1, len(names) + 1):
    module = types.ModuleType(".".join(names[:count]))
    module.__path__ = [folder] if count == len(names) else []
    sys.modules[module.__name__] = module
importlib.import_module(package + ".core.devices.guard_process").main(program)
"""
_EXIT_SECONDS = 1.0
_FULL = 0.002  # seconds after which a full pipe is tried again
# Earlier orders that an order makes obsolete, besides those of the same method.
_OBSOLETE = {"send": ("expect",), **dict.fromkeys(("silence", "rest", "request_stop"), ("send", "expect"))}


def start_process() -> subprocess.Popen[bytes]:
    """Start the guard with the Python that runs this program (Blender's own, inside Blender). Raises OSError."""
    paths = [str(Path(path).absolute()) for path in sys.path if path]
    what = json.dumps([paths, _PACKAGE, str(Path(__file__).parents[2]), os.getpid()])
    return subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", _BOOT, what],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(subprocess, "ABOVE_NORMAL_PRIORITY_CLASS", 0),
    )


class Guard:
    """A guard process, the orders to be written to it, and the last status of each output."""

    def __init__(self) -> None:
        """Raises OSError if the process cannot be started."""
        self._process = _state.start()
        self._never_blocks = _never_blocks(self._process.stdin)
        self._condition = threading.Condition()
        # Guarded by _condition:
        self._orders: dict[tuple[int, str], tuple[Any, ...]] = {}
        self._unwritten = memoryview(b"")
        self._makers: dict[int, Callable[[], ThreadedOutput]] = {}
        self._statuses: dict[int, Status] = {}
        self._replaced: dict[int, int] = {}
        self._closing = False
        self._lost = ""
        self._threads = started_threads(orders=self._write, statuses=self._read)

    def open(self, number: int, make: Callable[[], ThreadedOutput], name: str = "open") -> bool:
        """Let the guard create and start an output. Returns False if the guard is ending."""
        with self._condition:
            if self._closing or self._lost:
                return False
            self._makers[number] = make
            self._orders[number, name] = (make,)
            self._write_some()
            return True

    def order(self, number: int, name: str, *arguments: Any) -> None:
        """Call a method of an output, in the order of the calls; a later call of the same method replaces a pending one."""
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
            status = self._statuses.get(number, Status())
            if self._lost and not status.is_over:
                return replace(status, state="failed", message=self._lost, writing_for=0.0)
            return replace(status, dropped_blocks=status.dropped_blocks + self._replaced.get(number, 0))

    def wait_until_over(self, number: int, timeout: float) -> bool:
        """Wait for the end of an output. Returns whether it has ended."""
        with self._condition:
            return self._condition.wait_for(lambda: self.status(number).is_over, timeout)

    def join(self, timeout: float) -> None:
        """Wait for the guard's end, which comes after that of the last output."""
        deadline = time.monotonic() + timeout
        for thread in self._threads:
            thread.join(max(deadline - time.monotonic(), 0.0))

    def _write_some(self) -> None:
        """Write orders as far as the pipe accepts them at once; the thread writes the rest. Called under _condition.

        The thread alone would have to wait until the caller releases the GIL.
        """
        if not self._never_blocks or self._closing or self._lost:
            self._condition.notify_all()
            return
        if not self._unwritten and self._orders:
            self._unwritten, self._orders = _message(self._orders), {}
        with suppress(OSError):  # the pipe is full; or the guard has ended, which the thread of statuses sees
            self._unwritten = self._unwritten[os.write(self._process.stdin.fileno(), self._unwritten) :]

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
                        self._unwritten, self._orders = _message(self._orders), {}
                    if self._never_blocks:
                        self._write_some()
                        continue
                    message, self._unwritten = self._unwritten, memoryview(b"")
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
                statuses = pickle.load(self._process.stdout)
                with self._condition:
                    self._statuses = statuses
                    self._closing = all(statuses.get(number, Status()).is_over for number in self._makers)
                    self._condition.notify_all()
        except (EOFError, OSError, pickle.UnpicklingError):
            pass
        code = self._process.wait()
        self._process.stdout.close()
        with self._condition:
            open_ones = [make for number, make in self._makers.items() if not self._statuses.get(number, Status()).is_over]
            if not self._closing:
                self._lost = f"the process that guards the devices has ended ({code}): disconnect and connect them again"
            self._condition.notify_all()
        if open_ones:
            _state.quieten(open_ones)


def _message(orders: Mapping[tuple[int, str], tuple[Any, ...]]) -> memoryview:
    """Orders as the guard reads them."""
    return memoryview(pickle.dumps([(*key, arguments) for key, arguments in orders.items()], pickle.HIGHEST_PROTOCOL))


def _never_blocks(pipe: BinaryIO) -> bool:
    """Make a pipe non-blocking for writes. Returns False if the system cannot (Windows before Python 3.12)."""
    try:
        os.set_blocking(pipe.fileno(), False)
    except (AttributeError, OSError):
        return False
    return True


class _State:
    """The guard that runs, if any, and the outputs of this program. start: starts a guard process."""

    def __init__(self) -> None:
        self.start: Callable[[], Any] = start_process
        self._lock = threading.Lock()
        self.guard: Guard | None = None
        self._numbers = itertools.count()
        self.outputs: set[GuardedOutput] = set()  # started and not ended

    def open(self, make: Callable[[], ThreadedOutput]) -> tuple[Guard, int]:
        """Let a guard drive one more output. Raises OSError if none can be started."""
        with self._lock:
            number = next(self._numbers)
            if self.guard is None or not self.guard.open(number, make):
                self.guard = Guard()
                self.guard.open(number, make)
            return self.guard, number

    def quieten(self, makers: list[Callable[[], ThreadedOutput]]) -> None:
        """Silence devices whose guard ended while it drove them, by a new guard."""
        try:
            guard = Guard()
        except OSError:
            return
        for number, make in enumerate(makers):
            guard.open(number, make, "quieten")


_state = _State()


class GuardedOutput:
    """An output that the guard process drives."""

    def __init__(self, profile: ActuatedDevice, make: Callable[[], ThreadedOutput]) -> None:
        """make: makes the output inside the guard; it is pickled. Raises ValueError as ``make`` does."""
        make()
        self.profile = profile
        self._make = make
        self._guard: Guard | None = None
        self._number = 0
        self._own = Status()

    def start(self) -> None:
        """Search for the device and drive it from now on."""
        try:
            self._guard, self._number = _state.open(self._make)
        except OSError as error:
            self._own = Status("failed", f"the process that guards the devices can't be started: {error}")
            return
        _state.outputs.add(self)

    def adjust(self, adjustment: Adjustment) -> None:
        """Follow these settings from now on. Never blocks. Raises ValueError for a calibration of an unknown actuator."""
        check_adjustment(adjustment, self.profile.actuators)
        self._order("adjust", adjustment)

    def send(self, block: ArrayLike, sent: float | None = None) -> float:
        """Play a block, whose first sample is to be felt now; the rest of the block before is dropped. Never blocks.

        block: (actuators, n) in [-1, 1] at the rate. sent: when that was decided, by `time.perf_counter`; None for now. Returns that time.
        Raises ValueError if the block has another shape or is not finite.
        """
        checked = checked_block(np.asarray(block), len(self.profile.actuators))
        sent = time.perf_counter() if sent is None else sent
        self._order("send", packed(checked), sent)
        return sent

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        """Play the samples ``ahead`` (actuators, n) after the block of ``sent`` if no other block arrives in time.

        Never blocks. Raises ValueError if it has another shape or is not finite.
        """
        self._order("expect", packed(checked_block(np.asarray(ahead), len(self.profile.actuators))), sent)

    def silence(self) -> None:
        """Go to zero as soon as the device accepts it, and discard everything sent so far. The next block plays again. Never blocks."""
        self._order("silence")

    def rest(self) -> None:
        """Write zero and the release report, but keep the device open: the next block plays again. Never blocks."""
        self._order("rest")

    def request_stop(self) -> None:
        """Begin to stop, without waiting. Never blocks."""
        self._order("request_stop")
        if self._guard is None and not self._own.is_over:
            self._own = Status("stopped")

    def stop(self, timeout: float = 1.0) -> bool:
        """Write zero and the release report, and close the device. Returns after at most ``timeout`` seconds whether that is done.

        If not, a write is blocked inside the system; the guard goes on with the rest as soon as it returns.
        """
        self.request_stop()
        if self._guard is None:
            return True
        done = self._guard.wait_until_over(self._number, timeout)
        if done:
            _state.outputs.discard(self)
        return done

    @property
    def status(self) -> Status:
        """The state of the output, at most 50 ms old. Never blocks."""
        return self._own if self._guard is None else self._guard.status(self._number)

    def _order(self, name: str, *arguments: Any) -> None:
        if self._guard is not None:
            self._guard.order(self._number, name, *arguments)


class DeviceOutput(GuardedOutput):
    """One device that is fed with blocks of samples, one row per actuator of its profile."""

    def __init__(self, profile: Profile, adjustment: Adjustment | None = None, **options: Any) -> None:
        """options: those of `DeviceWriter`; ``hid`` is pickled. Raises ValueError as that does."""
        super().__init__(profile, partial(DeviceWriter, profile, adjustment=adjustment, **options))


class SoundCardOutput(GuardedOutput):
    """A sound card that is fed with blocks of samples, one row per actuator; used like `DeviceOutput`."""

    def __init__(self, card: SoundCard, adjustment: Adjustment | None = None, **options: Any) -> None:
        """options: those of `SoundCardWriter`."""
        super().__init__(card, partial(SoundCardWriter, card, adjustment=adjustment, **options))


@atexit.register
def stop_all(timeout: float = _EXIT_SECONDS) -> bool:
    """Stop all outputs within ``timeout`` seconds together, and the guard with them. Returns whether all are done."""
    deadline = time.perf_counter() + timeout
    done = stop_together(_state.outputs, timeout)
    if done and _state.guard is not None:
        _state.guard.join(max(deadline - time.perf_counter(), 0.0))
    return done
