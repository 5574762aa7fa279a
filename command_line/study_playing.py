"""Tracks on devices in step with a film that a page shows."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from statistics import median
from typing import Any

from ..core.arrays import FloatArray
from .serve.stage import DeviceStage

RATE = 8000
"""Samples per second of the tracks."""
BLOCK = RATE // 50
"""Samples of a block that is sent to the devices."""
AHEAD = RATE // 5
"""Samples after the last picture, from which on devices are silent: that many are sent with each
block."""
PATIENCE = 15.0
"""Seconds in which a device that was lost is found again: longer than a guard takes to start."""
_PICTURES = 24
_JUMP = 0.08
"""Seconds of the film by which two pictures differ if it has stood still, or jumped."""
_LOOK = 0.001


class FilmPlayer:
    """Plays tracks in step with a film. The page says when each picture is shown; the zero of the
    film is the median of the last ones. Without pictures the devices fall silent.

    halted: why nothing plays; empty if all is well.
    """

    def __init__(self, stage: DeviceStage) -> None:
        self._stage = stage
        self.halted = ""
        self._lock = threading.RLock()
        self._begin({})

    def _begin(self, tracks: dict[str, FloatArray]) -> None:
        """Fall silent, and play these tracks with the next picture."""
        self._tracks = [
            (self._stage.outputs[key], samples, self._stage.outputs[key].status.losses)
            for key, samples in tracks.items()
        ]
        self._zeros: deque[float] = deque(maxlen=_PICTURES)
        self._zero = self._shown = self._late = 0.0
        self._sent = self._next = 0
        self._stage.stop()

    def load(self, tracks: dict[str, FloatArray]) -> None:
        """Play these tracks (actuators, n) of each device from the first picture on. A device whose
        touch comes late begins as much earlier."""
        with self._lock:
            self._begin({} if self.halted else tracks)
            self._check()
            if self._tracks:
                threading.Thread(
                    target=self._run, args=[self._tracks], name="haptics film", daemon=True
                ).start()

    def follow(self, film: float, shown: float) -> None:
        """A picture at ``film`` seconds of the film is shown at ``shown`` by
        `time.perf_counter`."""
        now, zero = time.perf_counter(), shown - film
        if abs(shown - now) > 1.0:
            return
        with self._lock:
            if self._zeros and abs(zero - self._zero) > _JUMP:
                self._zeros.clear()  # the film has stood still, or jumped
            if not self._zeros:
                self._next = max(round((now - zero) * RATE / BLOCK), 0) * BLOCK
            self._zeros.append(zero)
            self._zero = median(self._zeros)
            self._shown = now

    def stop(self) -> tuple[float, float]:
        """Fall silent. Returns by how many seconds sending was late at most, and how many seconds
        of the tracks were sent; without pictures none are."""
        with self._lock:
            self._check()
            found = self._late, self._sent / RATE
            self._begin({})
        return found

    def halt(self, reason: str) -> None:
        """Silence every device until `resume`."""
        self.halted = reason
        with self._lock:
            self._begin({})

    def resume(self) -> None:
        """Let devices play again, those that were lost as well."""
        self.halted = ""
        for output in self._stage.outputs.values():
            if output.status.is_over:
                output.start()
            with suppress(OSError):  # `load` says why it is not
                output.wait_until_open(PATIENCE)

    def _check(self) -> None:
        """Halt if a device that plays was lost, even if it is there again."""
        for output, _, losses in self._tracks:
            status = output.status
            if status.state != "open" or status.losses > losses:
                self.halt(f"{output.profile.title}: {status.message or 'it was disconnected'}")

    def _run(self, tracks: list[Any]) -> None:
        """The thread that sends blocks of these tracks when they are due, until others are
        loaded, or none."""
        while True:
            time.sleep(_LOOK)
            with self._lock:
                if self._tracks is not tracks:
                    return
                now, due = time.perf_counter(), self._zero + self._next / RATE
                if self._zeros and now > self._shown + AHEAD / RATE:
                    self._zeros.clear()
                    self._stage.stop()
                elif self._zeros and now >= due:
                    self._check()
                    self._send(due)
                    self._late = max(self._late, now - due)

    def _send(self, due: float) -> None:
        """Send the next block of each device, and what follows in case that the next is late."""
        played = 0
        for output, samples, _ in self._tracks:
            lead = round(RATE * getattr(output.profile, "latency", 0.0))
            rest = samples[:, self._next + lead :]
            if rest.size:
                output.send(rest[:, :BLOCK], due)
                output.expect(rest[:, BLOCK:AHEAD], due)
                played = BLOCK
        self._next += BLOCK
        self._sent += played
