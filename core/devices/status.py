"""The status of an output, and the interface of all outputs."""

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
    """The status of an output.

    state: ``searching`` until the device is found; ``open``; ``stopped``; ``failed`` after an error that ends the output.
    message: why it is not open, or the last error; empty if all is well.
    written, failed_writes: reports. losses: number of disconnections while it was open. dropped_blocks: blocks that were replaced before
    they were played. writing_for: seconds that the write in progress has been blocking, else 0. delay: median seconds from ``send`` to the
    report written, over the last blocks; None before the first. lag: delay of touch relative to the picture: ``delay``, a stream's
    buffering, the requested delay and the actuators' latency.
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
    """The interface of an output. Only ``stop`` blocks."""

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
