"""When which report goes out: a device's pace, its refresh, the watchdog and the limits. No clock and no device: time is an argument."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..arrays import FloatArray
from .actuation import SampleActuation, ToneActuation
from .families.family import RumbleFamily, StreamFamily
from .limits import DriveLimits, SampleLimits
from .profiles import Adjustment, Profile
from .report import Report, Tones, Transport

WATCHDOG = 0.250
"""Seconds without a fresh block after which a device is silenced."""

# A stream starts so much later than its block, besides one report, that a frame may be late without a gap; and a block that comes
# earlier than that cuts off what is left of the one before.
_MARGIN = 0.010
# A stream that is later than this starts afresh instead of catching up.
_LATE = 0.050
# Samples over which a stream goes from its last value to what follows, where that is not its continuation.
_SEAM = 8


class Pacing(Protocol):
    """Decides, at any time, what to write next."""

    interval: float
    """Least seconds between two reports."""
    lead: float
    """Seconds by which a block waits for its turn, besides the delay asked for."""

    def accept(self, block: FloatArray, sent: float) -> None:
        """A fresh block of (actuators, n) samples, whose first is to be felt at ``sent``."""

    def adjust(self, adjustment: Adjustment) -> None:
        """Follow the user's settings from now on."""

    def silence(self) -> None:
        """Forget everything that is not written yet, and go to zero."""

    def next_report(self, now: float) -> Report | None:
        """The report to write at ``now``, or None. What is returned counts as written."""

    def failed(self) -> None:
        """The report given out last did not arrive."""

    def wake(self, now: float) -> float | None:
        """When to ask again unless a block comes before; None if nothing will happen by itself."""

    def ending(self) -> tuple[Report, ...]:
        """The reports that stop the device, to be written one ``interval`` apart: zero, then release."""

    def restart(self) -> None:
        """The device was stopped and is to play again: what was driven still counts for the limits."""


def _limits(profile: Profile, channels: Sequence[str], interval: float) -> DriveLimits:
    ceilings = {channel.name: actuator.safe_maximum for actuator in profile.actuators for channel in actuator.channels}
    return DriveLimits(
        np.array([ceilings.get(channel, 1.0) for channel in channels]),
        profile.slew,
        profile.sustained_maximum,
        profile.sustained_seconds,
        interval,
    )


class RumblePacing:
    """Pace of a device that is commanded by amplitude.

    Between two commands the largest amplitude of each channel counts, so that a slow device does not miss a short impact.
    """

    def __init__(
        self, profile: Profile, family: RumbleFamily, transport: Transport, actuation: ToneActuation, adjustment: Adjustment
    ) -> None:
        self._family, self._transport, self._actuation = family, transport, actuation
        self.interval, self.lead = profile.interval(transport), 0.0
        self._limits = _limits(profile, family.channels, self.interval)
        self.adjust(adjustment)
        self._startup = deque(family.startup(transport, 0))
        self._starting = False
        self._sequence = 0
        self._steps: deque[tuple[float, Tones]] = deque()
        self._rest = family.silence()
        self._silent = family.encode(self._rest, transport, 0).data
        self._current = self._rest
        # What the device does when it is opened is not known (a program may have been killed): it starts with zero.
        self._written = b""
        self._zeros_left = family.zero_repeats
        self._fresh = -np.inf
        self._looked = -np.inf
        self._wrote = -np.inf

    def adjust(self, adjustment: Adjustment) -> None:
        self._delay = adjustment.delay
        self._actuation.calibrate(adjustment.calibrations)
        self._limits.scale_ceilings(adjustment.ceiling)

    def accept(self, block: FloatArray, sent: float) -> None:
        start = sent + self._delay
        self._steps = deque((start + step.offset, step.tones) for step in self._actuation.process(block))
        self._fresh = sent

    def silence(self) -> None:
        self._actuation.reset()
        self._steps.clear()
        self._current = self._rest
        self._fresh = -np.inf

    def next_report(self, now: float) -> Report | None:
        if now < self._wrote + self.interval:
            return None
        self._starting = bool(self._startup)
        if self._starting:
            return self._write(self._startup.popleft(), now)
        if now - self._fresh > WATCHDOG + self._delay:
            self.silence()
        wanted = self._due(now)
        elapsed = min(now - self._looked, 1e6)
        self._looked = now
        amplitudes = self._limits.limited(np.array(wanted.amplitudes), elapsed)
        drive = Tones(tuple(amplitudes.tolist()), wanted.frequencies) if amplitudes.any() else self._rest
        return self._unless_known(drive, now)

    def failed(self) -> None:
        self._written = b""
        self._zeros_left = self._family.zero_repeats
        if self._starting:
            self._startup = deque(self._family.startup(self._transport, self._sequence))

    def wake(self, now: float) -> float | None:
        if self._startup or self._steps or self._zeros_left or self._current.amplitudes != self._rest.amplitudes:
            look, refresh = max(self._wrote, self._looked) + self.interval, self._family.refresh_interval
            if refresh is not None and self._written != self._silent:
                return max(min(look, self._wrote + refresh), self._wrote + self.interval)
            return look
        return None

    def ending(self) -> tuple[Report, ...]:
        zero = self._family.encode(self._rest, self._transport, self._sequence)
        reports = (zero, *self._family.release(self._transport, self._sequence + 1))
        self._sequence += len(reports)
        return reports

    def restart(self) -> None:
        self.silence()
        self._startup = deque(self._family.startup(self._transport, self._sequence))
        # Whatever happened since the release, the device is told anew.
        self._written = b""
        self._zeros_left = self._family.zero_repeats

    def _due(self, now: float) -> Tones:
        """The strongest of what was due since the last look, channel by channel; what is due last stays."""
        due: list[Tones] = []
        while self._steps and self._steps[0][0] <= now:
            due.append(self._steps.popleft()[1])
        if not due:
            return self._current
        self._current = due[-1]
        strongest = np.argmax([tones.amplitudes for tones in due], axis=0).tolist()
        return Tones(
            tuple(due[which].amplitudes[channel] for channel, which in enumerate(strongest)),
            tuple(due[which].frequencies[channel] for channel, which in enumerate(strongest)),
        )

    def _unless_known(self, drive: Tones, now: float) -> Report | None:
        """The report for a drive, unless the device does that already and needs no reminder."""
        data = self._family.encode(drive, self._transport, 0).data
        if data == self._silent:
            if self._zeros_left == 0:
                return None
            self._zeros_left -= 1
        else:
            refresh = self._family.refresh_interval
            if data == self._written and (refresh is None or now - self._wrote < refresh):
                return None
            self._zeros_left = self._family.zero_repeats
        self._written = data
        return self._write(self._family.encode(drive, self._transport, self._sequence), now)

    def _write(self, report: Report, now: float) -> Report:
        self._sequence += 1
        self._wrote = now
        return report


class StreamPacing:
    """Pace of a device that takes samples: one report after the other, each when the one before it has been played."""

    def __init__(
        self, profile: Profile, family: StreamFamily, transport: Transport, actuation: SampleActuation, adjustment: Adjustment
    ) -> None:
        self._family, self._transport, self._actuation = family, transport, actuation
        self.interval, self.lead = profile.interval(transport), family.period + _MARGIN
        self._limits = _limits(profile, family.channels, family.period)
        self.adjust(adjustment)
        self._startup = deque(family.startup(transport, 0))
        self._starting = False
        self._queue = np.zeros((len(family.channels), 0))
        self._samples = SampleLimits(self._limits, len(family.channels))
        self._sequence = 0
        self._due: float | None = None
        self._seam = False
        self._last = np.zeros((len(family.channels), 1))
        self._fresh = -np.inf

    def adjust(self, adjustment: Adjustment) -> None:
        self._delay = adjustment.delay
        self._actuation.calibrate(adjustment.calibrations)
        self._limits.scale_ceilings(adjustment.ceiling)

    def accept(self, block: FloatArray, sent: float) -> None:
        kept = self._queue[:, : round((self.lead + _MARGIN) * self._family.rate)]
        dry = self._seam and not kept.shape[1]
        seam = dry or kept.shape[1] < self._queue.shape[1]
        if seam:
            self._actuation.reset()
        samples = self._actuation.process(block)
        if seam:
            join(samples, 0, self._last if dry else kept[:, -1:])
        if dry or self._due is None:
            self._due = max(sent + self._delay + self.lead, self._due or -np.inf)
        self._queue = np.concatenate([kept, samples], axis=1)
        self._fresh = sent

    def silence(self) -> None:
        self._actuation.reset()
        self._queue = self._queue[:, :0]
        self._seam = True
        self._fresh = -np.inf

    def next_report(self, now: float) -> Report | None:
        if self._due is None or now < self._due:
            return None
        self._starting = bool(self._startup)
        if self._starting:
            self._due = now + self.interval
            return self._startup.popleft()
        if now - self._fresh > WATCHDOG + self._delay + self.lead:
            self.silence()
            self._due = None
            return self._packet()
        self._due = (now if now - self._due > _LATE else self._due) + self._family.period
        return self._packet()

    def failed(self) -> None:
        self._seam = True
        if self._starting:
            self._startup = deque(self._family.startup(self._transport, self._sequence))

    def wake(self, now: float) -> float | None:
        return self._due

    def ending(self) -> tuple[Report, ...]:
        zero = np.zeros((len(self._family.channels), self._family.frames), dtype=np.int8)
        reports = (self._family.encode(zero, self._sequence), *self._family.release(self._transport, self._sequence + 1))
        self._sequence += len(reports)
        return reports

    def restart(self) -> None:
        self.silence()
        self._startup = deque(self._family.startup(self._transport, self._sequence))
        self._due = None

    def _packet(self) -> Report:
        samples = self._samples.limited(self._next_frames(), self._family.period)
        report = self._family.encode(np.round(127.0 * samples).astype(np.int8), self._sequence)
        self._sequence += 1
        return report

    def _next_frames(self) -> FloatArray:
        """The next frames of the queue, then silence, without a jump at seams. (channels, frames)."""
        frames = self._family.frames
        taken, self._queue = self._queue[:, :frames], self._queue[:, frames:]
        dry = frames - taken.shape[1]
        played = np.pad(taken, ((0, 0), (0, dry)))
        if dry:
            join(played, taken.shape[1], taken[:, -1:] if taken.shape[1] else self._last)
        self._seam = dry > 0
        self._last = played[:, -1:]
        return played


def join(samples: FloatArray, start: int, last: FloatArray) -> None:
    """Let the samples from ``start`` on begin at the value ``last``, in place."""
    seam = samples[:, start : start + _SEAM]
    seam += (last - seam) * (1.0 - (np.arange(seam.shape[1]) + 1.0) / _SEAM)


def pacing_of(
    profile: Profile,
    family: RumbleFamily | StreamFamily,
    transport: Transport,
    actuation: ToneActuation | SampleActuation,
    adjustment: Adjustment | None = None,
) -> Pacing:
    """The pacing that fits the family. Raises ValueError if the actuation is of the other kind."""
    adjustment = adjustment or Adjustment()
    if isinstance(family, RumbleFamily) and isinstance(actuation, ToneActuation):
        return RumblePacing(profile, family, transport, actuation, adjustment)
    if isinstance(family, StreamFamily) and isinstance(actuation, SampleActuation):
        return StreamPacing(profile, family, transport, actuation, adjustment)
    raise ValueError("actuation is not of the family's kind")
