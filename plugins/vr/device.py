"""The two controllers of a virtual-reality session, which take an amplitude and a frequency once
per frame of the session. No thread and no device here: the session asks for its calls.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from statistics import median

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import FloatArray
from ...core.devices.actuation import calibrated, checked_block
from ...core.devices.families.family import RumbleFamily
from ...core.devices.high_pass import HighPass
from ...core.devices.limits import DriveLimits
from ...core.devices.pacing import WATCHDOG, Ahead, SampleQueue, join
from ...core.devices.profiles import (
    Actuator,
    Adjustment,
    Calibration,
    DriveChannel,
    Profile,
    check_adjustment,
)
from ...core.devices.report import Report, Tones, Transport
from ...core.devices.status import Output, State, Status
from ...core.devices.writer import SAMPLE_RATE
from ...core.frozen import frozen

LONGEST = 0.060
"""Seconds that a call lasts at most, so that the controllers are silent soon after the last one."""
_FRAMES = 3  # that a call lasts, so that a late frame makes no gap
_OLDEST = 0.100  # seconds after which samples are over when a frame of the session comes late
_MARGIN = 0.020  # a block that is earlier by less than this waits for the rest of the one before
_FREQUENCY_WINDOW = 0.040  # seconds of samples from which the frequency is taken
_BAND = (65.0, 300.0)
_GAP = 0.001  # seconds by which a block may be late without a silence before it
_PART = 0.005  # seconds of the parts of a frame of which the strongest is a peak
_PEAK = 1.3  # if it has so many times the power of the frame


def _no_report(drive: Tones, transport: Transport, sequence: int) -> Report:
    raise ValueError("VR controllers take calls, not reports")


PROFILE = Profile(
    name="vr-controllers",
    title="VR Controllers (left, right)",
    family=RumbleFamily(
        name="vr-controllers",
        title="VR Controllers",
        ids=frozenset(),
        minimum_interval={},
        encode=_no_report,
        has_tones=True,
    ),
    experimental=False,
    minimum_interval=None,
    slew=200.0,
    sustained_maximum=0.7,
    sustained_seconds=10.0,
    actuators=tuple(
        Actuator(
            name,
            (part,),
            "LRA",
            _BAND,
            0.010,
            1.0,
            (DriveChannel(name, _BAND),),
            Calibration(),
        )
        for name, part in (("left", "hand.L"), ("right", "hand.R"))
    ),
)


@frozen
class Call:
    """What a controller does for ``seconds``, unless another call replaces it. amplitude: 0 to 1; 0
    stops it. frequency: hertz."""

    amplitude: float
    frequency: float
    seconds: float


class VrControllers(Output):
    """Blocks of samples, one row per controller, to one `Call` per controller and frame.

    A frame's call stands for the samples that were due since the frame before: with their power,
    and their frequency over 40 ms, that of the sine with the same power of first differences. A
    frame with a blow has the power of its strongest 5 ms, and the next frames have as much less:
    the peak and the energy of the blow are kept.
    """

    def __init__(
        self,
        adjustment: Adjustment | None = None,
        rate: int = SAMPLE_RATE,
        stopping: Callable[[], object] = lambda: None,
    ) -> None:
        """rate: samples per second of the blocks. stopping: called by `request_stop`, to make the
        calls that stop the controllers at once."""
        self._stopping = stopping
        self.hands = False  # whether only blocks of the session's hands are played
        self.profile = PROFILE
        self._rate = rate
        self._rows = len(PROFILE.actuators)
        self._lock = threading.RLock()
        self._state: State = "searching"
        self._high_pass = HighPass(self._rows, rate)
        self._limits = DriveLimits(
            np.array([actuator.safe_maximum for actuator in PROFILE.actuators]),
            PROFILE.slew,
            PROFILE.sustained_maximum,
            PROFILE.sustained_seconds,
            LONGEST,
        )
        self._delays: deque[float] = deque(maxlen=256)
        self._calls = self._refused = self._gaps = 0
        self._frame, self._interval = -np.inf, 0.011  # its time, and seconds between two
        self._driven = np.zeros(self._rows)  # by the last calls
        self.adjust(adjustment or Adjustment())
        self._clear()

    def _clear(self) -> None:
        self._queue = SampleQueue(self._rows, round(_GAP * self._rate), self._high_pass.process)
        self._queue.dry = True
        self._due = self._sent = -np.inf  # time of the queue's first sample, and of the last block
        self._history = np.zeros((self._rows, round(_FREQUENCY_WINDOW * self._rate)))
        # Power of a part of the last frame, or what it was given of it.
        self._strongest = np.zeros(self._rows)
        self._owed = np.zeros(self._rows)  # energy of peaks beyond that of their frames
        self._high_pass.reset()

    def start(self) -> None:
        self._state = "open"

    def adjust(self, adjustment: Adjustment) -> None:
        check_adjustment(adjustment, self.profile.actuators)
        self._adjustment = adjustment
        self._limits.scale_ceilings(adjustment.ceiling)

    def send(self, block: ArrayLike, sent: float | None = None, hands: bool = False) -> float:
        """As `Output.send`. hands: the block is of the hands that the session has."""
        checked = checked_block(np.asarray(block), self._rows)
        sent = time.perf_counter() if sent is None else sent
        if hands != self.hands:
            return sent
        with self._lock:
            queue = self._queue
            start = sent + self._adjustment.delay
            samples = self._high_pass.process(checked)
            if queue.dry and not len(queue):
                self._due = start
            place = max(round((start - self._due) * self._rate), 0)
            queue.fill(place)
            if len(queue) - place > _MARGIN * self._rate:
                queue.samples = queue.samples[:, :place]
                join(samples, 0, queue.samples[:, -1:] if place else queue.last)
            gap = place - len(queue)
            if gap > _GAP * self._rate:
                queue.append(np.zeros((self._rows, gap)))
            queue.append(samples)
            queue.ahead = Ahead()
            queue.dry = False
            self._sent = sent
        return sent

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        expected = checked_block(np.asarray(ahead), self._rows)
        with self._lock:
            if sent == self._sent:
                end = self._due + len(self._queue) / self._rate
                self._queue.ahead = Ahead(expected, self._rate, end)

    def silence(self) -> None:
        with self._lock:
            self._clear()

    def rest(self) -> None:
        self.silence()

    def request_stop(self) -> None:
        self.silence()
        self._state = "stopped"
        self._stopping()

    def stop(self, timeout: float = 1.0) -> bool:
        self.request_stop()
        return self.is_silent

    @property
    def is_silent(self) -> bool:
        """Whether the controllers were told to stop."""
        return not self._driven.any()

    @property
    def status(self) -> Status:
        delay = median(self._delays) if self._delays else None
        busy = f"touch paused {self._gaps} times, because Blender was busy for over 60 ms"
        return Status(
            state=self._state,
            message=busy if self._gaps and self._state == "open" else "",
            written=self._calls,
            failed_writes=self._refused,
            losses=self._gaps,
            delay=delay,
            lag=None
            if delay is None
            else delay + self._adjustment.delay + PROFILE.actuators[0].latency,
        )

    def answered(self, accepted: bool) -> None:
        """Count a call, and whether the session accepted it."""
        self._calls += accepted
        self._refused += not accepted

    def calls(self, now: float) -> dict[str, Call]:
        """The calls of a frame of the session, by controller; none for one that is silent and
        stays so."""
        with self._lock:
            elapsed = min(now - self._frame, 1.0) if self._frame > -np.inf else self._interval
            self._frame = now
            self._gaps += not self.is_silent and elapsed > LONGEST
            if now - self._sent > WATCHDOG + self._adjustment.delay:
                self._clear()
            self._interval = max(min(elapsed, LONGEST), 0.9 * self._interval)
            powers, frequencies = self._described(self._taken(now, elapsed), elapsed)
        wanted = [
            float(calibrated(np.sqrt(power), self._calibration(actuator)))
            for power, actuator in zip(powers.tolist(), PROFILE.actuators, strict=True)
        ]
        before = self._driven
        self._driven = self._limits.limited(np.array(wanted), elapsed)
        seconds = min(_FRAMES * self._interval, LONGEST)
        return {
            actuator.name: Call(float(self._driven[row]), float(frequencies[row]), seconds)
            for row, actuator in enumerate(PROFILE.actuators)
            if before[row] or self._driven[row]
        }

    def _calibration(self, actuator: Actuator) -> Calibration:
        return self._adjustment.calibrations.get(actuator.name, actuator.calibration)

    def _taken(self, now: float, elapsed: float) -> FloatArray:
        """The samples (controllers, n) that were due in the frame that ends now and lasted
        ``elapsed`` seconds, and before it: silence where none were due."""
        longest = max(round(elapsed * self._rate), 1)
        count = max(round(min(now - self._due, 1.0) * self._rate), 0)
        if self._due == -np.inf or count == 0:
            return np.zeros((self._rows, longest))
        self._delays.append(now - self._due)
        taken = self._queue.take(count)
        self._due += count / self._rate
        missing = longest - count
        return np.pad(taken, ((0, 0), (missing if missing > _GAP * self._rate else 0, 0)))

    def _described(self, samples: FloatArray, elapsed: float) -> tuple[FloatArray, FloatArray]:
        """Powers (of an amplitude of 1: 1) and frequencies [Hz] of the last samples of a frame that
        lasted ``elapsed`` seconds, at most `_OLDEST`."""
        count = min(samples.shape[1], max(round(min(elapsed, _OLDEST) * self._rate), 1))
        joined = np.concatenate([self._history, samples], axis=1)
        self._history = joined[:, -self._history.shape[1] :]
        recent = joined[:, -max(self._history.shape[1], count + 1) :]
        steps = np.diff(recent, axis=1)
        power = np.mean(recent[:, 1:] ** 2, axis=1)
        change = np.mean(steps**2, axis=1)
        turn = np.divide(change, power, out=np.ones(self._rows), where=power > 0)
        frequencies = self._rate / np.pi * np.arcsin(np.sqrt(np.minimum(turn / 4, 1.0)))
        # Of a sine, the square plus that of its quadrature, which follows from its step, is
        # constant.
        envelope = joined[:, -count:] ** 2 + steps[:, -count:] ** 2 / turn[:, None]
        parts = np.array_split(envelope, max(round(count / (_PART * self._rate)), 1), axis=1)
        strongest = np.max([part.mean(axis=1) for part in parts], axis=0)
        wanted = envelope.mean(axis=1)
        frame = count / self._rate
        peaks = strongest > np.maximum(_PEAK * wanted, self._strongest)
        owed = np.where(peaks | (wanted * frame < self._owed / 10), 0.0, self._owed)
        paid = np.maximum(wanted - owed / frame, wanted / 4)  # a blow has no pause
        most = 2.0 * wanted * max(frame / LONGEST, 1.0)  # the call is no longer than that
        powers = np.where(peaks, np.minimum(strongest, most), paid)
        self._owed = owed + (powers - wanted) * frame
        self._strongest = np.where(peaks, powers, strongest)
        return powers, np.clip(frequencies, *_BAND)
