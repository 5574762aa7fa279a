"""What an output is doing, as a panel shows it, and what every output can be told."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, Protocol

from numpy.typing import ArrayLike

from .mapping import ActuatedDevice
from .profiles import Adjustment

State = Literal["searching", "open", "stopped", "failed"]


@dataclass(frozen=True, slots=True)
class Status:
    """What an output is doing.

    state: ``searching`` until the device is there; ``open``; ``stopped``; ``failed`` after an error that ends the output.
    message: why it is not open, or the last error; empty if all is well.
    written, failed_writes: reports. losses: times the device went away while it was open. dropped_blocks: replaced before they were taken.
    writing_for: seconds that the write in progress has been blocking, else 0.
    delay: median seconds from ``send`` to the report written, over the last blocks; None before the first.
    lag: ``delay``, what a stream waits, the delay asked for and the actuators' latency: how long after the picture touch is felt.
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
        """Whether the output has ended, in whatever way."""
        return self.state in ("stopped", "failed")


class Output(Protocol):
    """A device that is driven. Only ``stop`` waits."""

    @property
    def profile(self) -> ActuatedDevice: ...
    @property
    def status(self) -> Status: ...
    def start(self) -> None: ...
    def adjust(self, adjustment: Adjustment) -> None: ...
    def send(self, block: ArrayLike, sent: float | None = None) -> float: ...
    def expect(self, ahead: ArrayLike, sent: float) -> None: ...
    def silence(self) -> None: ...
    def rest(self) -> None: ...
    def request_stop(self) -> None: ...
    def stop(self, timeout: float = 1.0) -> bool: ...


def stop_together(outputs: Iterable[Output], timeout: float) -> bool:
    """Stop outputs within ``timeout`` seconds together. Returns whether all are done."""
    stopping = tuple(outputs)
    for output in stopping:
        output.request_stop()
    deadline = time.perf_counter() + timeout
    done = [output.stop(max(deadline - time.perf_counter(), 0.0)) for output in stopping]
    return all(done)
