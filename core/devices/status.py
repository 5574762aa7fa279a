"""The status of an output, and what all outputs that a thread drives have in common."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable
from statistics import median
from typing import TYPE_CHECKING, Literal, Protocol

from numpy.typing import ArrayLike

from ..frozen import frozen

if TYPE_CHECKING:
    from .profiles import Adjustment

State = Literal["searching", "open", "stopped", "failed"]

UNREACHED = "if it still vibrates, unplug it or switch it off"
"""What to do about a device that did not take the last zero."""
_MEASURED_BLOCKS = 256


@frozen
class Status:
    """The status of an output.

    state: ``searching`` until the device is found; ``open``; ``stopped``: the device is silent, or
    was never found; ``failed`` after an error that ends the output, or if the device did not take
    the last zero. message: why it is not open, or the last error; empty if all is well. written,
    failed_writes: reports. losses: number of disconnections while it was open. dropped_blocks:
    blocks that were replaced before they were played. writing_for: seconds that the write in
    progress has been blocking, else 0. delay: median seconds from ``send`` to the report written,
    over the last blocks; None before the first. lag: delay of touch relative to the picture:
    ``delay``, a stream's buffering, the requested delay and the actuators' latency.
    """

    state: State = "searching"
    message: str = ""
    written: int = 0
    failed_writes: int = 0
    losses: int = 0
    dropped_blocks: int = 0
    writing_for: float = 0.0
    delay: float | None = None
    lag: float | None = None

    @property
    def is_over(self) -> bool:
        """Whether the output has ended, regularly or by failure."""
        return self.state in ("stopped", "failed")


class Output(Protocol):
    """What plays blocks of samples: a writer in the guard process, or a `DeviceOutput` that passes
    orders on to it. Only ``stop`` blocks.

    Blocks are arrays (actuators, n) in [-1, 1] at the rate of the output; one of another shape, or
    that is not finite, raises ValueError.
    """

    def start(self) -> None:
        """Search for the device and drive it from now on."""

    def adjust(self, adjustment: Adjustment) -> None:
        """Follow these settings from now on. Raises ValueError for a calibration of an unknown
        actuator."""

    def send(self, block: ArrayLike, sent: float | None = None) -> float:
        """Play a block, whose first sample is to be felt now; the rest of the block before is
        dropped.

        sent: when that was decided, by `time.perf_counter`; None for now. Returns that time.
        """

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        """Play the samples ``ahead`` after the block of ``sent`` if no other block arrives in
        time."""

    def silence(self) -> None:
        """Go to zero as soon as the device accepts it, and discard everything sent so far. The next
        block plays again."""

    def rest(self) -> None:
        """Write zero and the release report, but keep the device open: the next block plays
        again."""

    def request_stop(self) -> None:
        """Begin to stop, without waiting."""

    def stop(self, timeout: float = 1.0) -> bool:
        """Write zero and the release report, and close the device. Returns after at most
        ``timeout`` seconds whether that is done.

        If not, a write is blocked inside the system; zero and release follow as soon as it returns.
        """

    @property
    def status(self) -> Status:
        """The state of the output."""


class ThreadedOutput(Output, ABC):
    """The state of an output that a thread of its own drives. That thread writes it, anyone may
    read it."""

    def __init__(self, name: str) -> None:
        self._state: State = "searching"
        self._message = ""
        self._written = self._failed = self._losses = self._dropped = 0
        self._writing_since: float | None = None
        self._delays: deque[float] = deque(maxlen=_MEASURED_BLOCKS)
        self._thread = threading.Thread(target=self._run, name=f"haptics {name}", daemon=True)

    @abstractmethod
    def _run(self) -> None:
        """The work of the thread."""

    @abstractmethod
    def _lag(self, delay: float) -> float:
        """Seconds by which touch lags behind the picture for a delay of the report."""

    def start(self) -> None:
        self._thread.start()

    def stop(self, timeout: float = 1.0) -> bool:
        # The thread is a daemon: if a write is blocked, the thread does not keep the process from
        # exiting.
        self.request_stop()
        if self._thread.is_alive():
            self._thread.join(timeout)
        elif not self._thread.ident:
            self._state = "stopped"
        return not self._thread.is_alive()

    @property
    def status(self) -> Status:
        since = self._writing_since
        delays = list(self._delays)
        delay = median(delays) if delays else None
        return Status(
            state=self._state,
            message=self._message,
            written=self._written,
            failed_writes=self._failed,
            losses=self._losses,
            dropped_blocks=self._dropped,
            writing_for=0.0 if since is None else time.perf_counter() - since,
            delay=delay,
            lag=None if delay is None else self._lag(delay),
        )


def stop_together(outputs: Iterable[Output], timeout: float) -> bool:
    """Stop outputs within ``timeout`` seconds together. Returns whether all are done."""
    stopping = tuple(outputs)
    for output in stopping:
        output.request_stop()
    deadline = time.perf_counter() + timeout
    done = [output.stop(max(deadline - time.perf_counter(), 0.0)) for output in stopping]
    return all(done)
