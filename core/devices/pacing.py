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

WATCHDOG = 0.500
"""Seconds without a fresh block after which a device is silenced: longer than an operator of Blender keeps its frames waiting now and then,
during which what was sent ahead is played."""

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

    def expect(self, ahead: FloatArray, sent: float) -> None:
        """The (actuators, m) samples that would follow the block of ``sent``, played only if no other block comes in time."""

    def adjust(self, adjustment: Adjustment) -> None:
        """Follow the user's settings from now on."""

    def silence(self) -> None:
        """Forget everything that is not written yet, and go to zero."""

    def next_report(self, now: float) -> Report | None:
        """The report to write at ``now``, or None. What is returned counts as written."""

    def written(self, now: float) -> None:
        """The report given out last has been written, which took until ``now``."""

    def failed(self) -> None:
        """The report given out last did not arrive."""

    def wake(self, now: float) -> float | None:
        """When to ask again unless a block comes before; None if nothing will happen by itself."""

    def ending(self, farewell: bool) -> tuple[Report, ...]:
        """The reports that stop the device, to be written one ``interval`` apart: zero, release, and ``farewell`` before it is closed."""

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


class Ahead:
    """Samples that follow a block where no other block comes in time; true while there are any.

    start: when the first of them is due, in seconds. begun: some of them were taken.
    """

    __slots__ = ("begun", "rate", "samples", "start")

    def __init__(self, samples: FloatArray | None = None, rate: int = 1, start: float = 0.0) -> None:
        self.samples, self.rate, self.start, self.begun = samples, rate, start, False

    def __bool__(self) -> bool:
        return self.samples is not None and self.samples.shape[1] > 0

    def pop(self, count: int) -> FloatArray:
        """Take the first ``count`` of them, or all that there are."""
        assert self.samples is not None
        taken, self.samples = self.samples[:, :count], self.samples[:, count:]
        self.start += taken.shape[1] / self.rate
        self.begun = True
        return taken

    def after(self, time: float) -> Ahead:
        """What is left from ``time`` on: it does until newer samples come."""
        if self.samples is None:
            return self
        skipped = max(round((time - self.start) * self.rate), 0)
        return Ahead(self.samples[:, skipped:], self.rate, max(time, self.start))


class RumblePacing:
    """Pace of a device that is commanded by amplitude.

    Between two commands the largest amplitude of each channel counts, so that a slow device does not miss a short impact.
    """

    def __init__(
        self,
        profile: Profile,
        family: RumbleFamily,
        transport: Transport,
        actuation: ToneActuation,
        adjustment: Adjustment,
        sequence: int = 0,
    ) -> None:
        self._family, self._transport, self._actuation = family, transport, actuation
        self.interval, self.lead = profile.interval(transport), 0.0
        self._limits = _limits(profile, family.channels, self.interval)
        self.adjust(adjustment)
        self._startup = deque(family.startup(transport, sequence))
        self._starting = False
        self._sequence = sequence
        self._steps: deque[tuple[float, Tones]] = deque()
        self._ahead = Ahead()
        self._end = -np.inf
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
        self._end = start + block.shape[1] / self._actuation.rate
        self._ahead = self._ahead.after(self._end)
        self._fresh = sent

    def expect(self, ahead: FloatArray, sent: float) -> None:
        if sent == self._fresh:
            self._ahead = Ahead(ahead, self._actuation.rate, self._end)

    def silence(self) -> None:
        self._actuation.reset()
        self._steps.clear()
        self._ahead = Ahead()
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

    def written(self, now: float) -> None:
        self._wrote = now

    def failed(self) -> None:
        self._written = b""
        self._zeros_left = self._family.zero_repeats
        if self._starting:
            self._startup = deque(self._family.startup(self._transport, self._sequence))

    def wake(self, now: float) -> float | None:
        if self._startup or self._steps or self._ahead or self._zeros_left or self._current.amplitudes != self._rest.amplitudes:
            look = max(self._wrote, self._looked) + self.interval
            if self._written != self._silent:
                return max(min(look, self._wrote + self._family.refresh_interval), self._wrote + self.interval)
            return look
        return None

    def ending(self, farewell: bool) -> tuple[Report, ...]:
        zero = self._family.encode(self._rest, self._transport, self._sequence)
        reports = [zero, *self._family.release(self._transport, self._sequence + 1)]
        if farewell:
            reports += self._family.farewell(self._transport, self._sequence + len(reports))
        self._sequence += len(reports)
        return tuple(reports)

    def restart(self) -> None:
        self.silence()
        self._startup = deque(self._family.startup(self._transport, self._sequence))
        # Whatever happened since the release, the device is told anew.
        self._written = b""
        self._zeros_left = self._family.zero_repeats

    def _due(self, now: float) -> Tones:
        """The strongest of what was due since the last look, channel by channel; what is due last stays."""
        while self._ahead and self._ahead.start <= now:
            start = self._ahead.start
            chunk = self._ahead.pop(self._actuation.hop)
            self._steps.extend((start + step.offset, step.tones) for step in self._actuation.process(chunk))
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
            if data == self._written and now - self._wrote < self._family.refresh_interval:
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
        self,
        profile: Profile,
        family: StreamFamily,
        transport: Transport,
        actuation: SampleActuation,
        adjustment: Adjustment,
        sequence: int = 0,
    ) -> None:
        self._family, self._transport, self._actuation = family, transport, actuation
        self.interval, self.lead = profile.interval(transport), family.period + _MARGIN
        self._limits = _limits(profile, family.channels, family.period)
        self.adjust(adjustment)
        self._startup = deque(family.startup(transport, sequence))
        self._starting = False
        self._queue = np.zeros((len(family.channels), 0))
        self._end = -np.inf
        self._ahead = Ahead()
        self._samples = SampleLimits(self._limits, len(family.channels))
        self._sequence = sequence
        self._due: float | None = None
        self._seam = False
        self._last = np.zeros((len(family.channels), 1))
        self._fresh = -np.inf

    def adjust(self, adjustment: Adjustment) -> None:
        self._delay = adjustment.delay
        self._actuation.calibrate(adjustment.calibrations)
        self._limits.scale_ceilings(adjustment.ceiling)

    def accept(self, block: FloatArray, sent: float) -> None:
        if self._ahead.begun:  # then the block waits for its turn as long as any other
            self._fill(round(self.lead * self._family.rate))
        still_due = self._queue[:, : self._place(sent)]
        dry = self._seam and not still_due.shape[1]
        seam = dry or still_due.shape[1] < self._queue.shape[1] or self._ahead.begun
        if seam:
            self._actuation.reset()
        samples = self._actuation.process(block)
        if seam:
            join(samples, 0, still_due[:, -1:] if still_due.shape[1] else self._last)
        if dry or self._due is None:
            self._due = max(sent + self._delay + self.lead, self._due or -np.inf)
        self._queue = np.concatenate([still_due, samples], axis=1)
        self._end = sent + block.shape[1] / self._actuation.rate
        self._ahead = self._ahead.after(self._end)
        self._fresh = sent

    def _place(self, sent: float) -> int:
        """Where in the queue a block begins: in its time, or after what is queued where that differs by less than a frame may be early."""
        if self._due is None:
            return self._queue.shape[1]
        place = max(round((sent + self._delay + self.lead - self._due) * self._family.rate), 0)
        return place if self._queue.shape[1] - place > _MARGIN * self._family.rate else self._queue.shape[1]

    def expect(self, ahead: FloatArray, sent: float) -> None:
        if sent == self._fresh:
            self._ahead = Ahead(ahead, self._actuation.rate, self._end)

    def silence(self) -> None:
        self._actuation.reset()
        self._queue = self._queue[:, :0]
        self._ahead = Ahead()
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

    def written(self, now: float) -> None:
        """Samples are due at their own time, however long writing takes."""

    def failed(self) -> None:
        self._seam = True
        if self._starting:
            self._startup = deque(self._family.startup(self._transport, self._sequence))

    def wake(self, now: float) -> float | None:
        return self._due

    def ending(self, farewell: bool) -> tuple[Report, ...]:
        zero = np.zeros((len(self._family.channels), self._family.frames), dtype=np.int8)
        reports = [self._family.encode(zero, self._sequence), *self._family.release(self._transport, self._sequence + 1)]
        if farewell:
            reports += self._family.farewell(self._transport, self._sequence + len(reports))
        self._sequence += len(reports)
        return tuple(reports)

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
        self._fill(frames)
        taken, self._queue = self._queue[:, :frames], self._queue[:, frames:]
        dry = frames - taken.shape[1]
        played = np.zeros((taken.shape[0], frames))
        played[:, : taken.shape[1]] = taken
        if dry:
            join(played, taken.shape[1], taken[:, -1:] if taken.shape[1] else self._last)
        self._seam = dry > 0
        self._last = played[:, -1:]
        return played

    def _fill(self, frames: int) -> None:
        """Lengthen the queue to ``frames`` by what was sent ahead, as far as that goes."""
        while self._ahead and self._queue.shape[1] < frames:
            chunk = self._actuation.process(self._ahead.pop(self._actuation.hop))
            self._queue = np.concatenate([self._queue, chunk], axis=1)


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
    sequence: int = 0,
) -> Pacing:
    """The pacing that fits the family. sequence: number of the first report. Raises ValueError if the actuation is of the other kind."""
    adjustment = adjustment or Adjustment()
    if isinstance(family, RumbleFamily) and isinstance(actuation, ToneActuation):
        return RumblePacing(profile, family, transport, actuation, adjustment, sequence)
    if isinstance(family, StreamFamily) and isinstance(actuation, SampleActuation):
        return StreamPacing(profile, family, transport, actuation, adjustment, sequence)
    raise ValueError("actuation is not of the family's kind")
