"""Schedule of a device's reports: interval, refresh, watchdog and limits. Uses no clock and no
device: time is an argument."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray
from .actuation import SampleActuation, ToneActuation
from .families.family import AnyFamily, RumbleFamily, StreamFamily
from .limits import DriveLimits, SampleLimits
from .profiles import Adjustment, Profile
from .report import Report, Tones, Transport

WATCHDOG = 0.500
"""Seconds without a fresh block after which a device is silenced. Blender's operators may delay
frames by up to that; the samples sent ahead are played meanwhile."""

_MARGIN = 0.010
"""Buffering of a stream in addition to one report [s]: a frame may be that late without a gap. A
block that is earlier by more cuts off the rest of the one before."""
_LATE = 0.050
"""A stream that is later than this [s] restarts instead of catching up."""
_SEAM = 8
"""Length of the ramp from a stream's last value to a discontinuous one, in samples."""


class Ahead:
    """Samples to be played after a block if no other block arrives in time; true while there are
    any.

    start: when the first of them is due, in seconds. begun: whether any was taken.
    """

    def __init__(
        self, samples: FloatArray | None = None, rate: int = 1, start: float = 0.0
    ) -> None:
        self.samples, self.rate, self.start, self.begun = samples, rate, start, False

    def __bool__(self) -> bool:
        return self.samples is not None and self.samples.shape[1] > 0

    def pop(self, count: int) -> FloatArray:
        """Take the first ``count`` of them, or all that there are."""
        assert self.samples is not None
        taken = self.samples[:, :count]
        self.samples = self.samples[:, count:]
        self.start += taken.shape[1] / self.rate
        self.begun = True
        return taken

    def after(self, time: float) -> Ahead:
        """The samples from ``time`` on, used until newer ones come."""
        if self.samples is None:
            return self
        skipped = max(round((time - self.start) * self.rate), 0)
        return Ahead(self.samples[:, skipped:], self.rate, max(time, self.start))


class SampleQueue:
    """Samples (channels, n) in the order in which they are due, continued by the samples sent
    ahead.

    ahead: samples of the source, (actuators, m). dry: the queue ran out at the last `take`. last:
    the last sample taken.
    """

    def __init__(
        self, channels: int, hop: int, process: Callable[[FloatArray], FloatArray]
    ) -> None:
        """process: makes samples of the queue of at most ``hop`` samples sent ahead."""
        self.samples = np.zeros((channels, 0))
        self.last = np.zeros((channels, 1))
        self.ahead = Ahead()
        self.dry = False
        self._hop, self._process = hop, process

    def __len__(self) -> int:
        return self.samples.shape[1]

    def append(self, samples: FloatArray) -> None:
        self.samples = np.concatenate([self.samples, samples], axis=1)

    def clear(self) -> None:
        """Drop everything, the samples sent ahead as well."""
        self.samples = self.samples[:, :0]
        self.ahead = Ahead()

    def fill(self, count: int) -> None:
        """Extend the queue to ``count`` samples from those sent ahead, if there are enough."""
        while self.ahead and len(self) < count:
            self.append(self._process(self.ahead.pop(self._hop)))

    def take(self, count: int) -> FloatArray:
        """The next ``count`` samples, padded with silence, without a jump at the boundary."""
        self.fill(count)
        taken = self.samples[:, :count]
        self.samples = self.samples[:, count:]
        played = np.zeros((len(taken), count))
        played[:, : taken.shape[1]] = taken
        self.dry = taken.shape[1] < count
        if self.dry:
            join(played, taken.shape[1], taken[:, -1:] if taken.shape[1] else self.last)
        self.last = played[:, -1:]
        return played


def join(samples: FloatArray, start: int, last: FloatArray) -> None:
    """Ramp the samples from ``start`` on from the value ``last``, in place."""
    seam = samples[:, start : start + _SEAM]
    seam += (last - seam) * (1.0 - (np.arange(seam.shape[1]) + 1.0) / _SEAM)


class Pacing(ABC):
    """Decides what to write next.

    interval: least seconds between two reports. lead: buffering of a block in seconds, in addition
    to the requested delay.
    """

    def __init__(
        self,
        profile: Profile,
        family: AnyFamily,
        transport: Transport,
        actuation: ToneActuation | SampleActuation,
        adjustment: Adjustment,
        sequence: int,
        command_seconds: float,
    ) -> None:
        """Begin with the reports that start the device.

        Args:
            profile: of the device.
            family: of the device.
            transport: by which it is connected.
            actuation: turns samples into the drive of the motors.
            adjustment: the user's settings.
            sequence: number of the first report.
            command_seconds: time for which a report drives the device [s].
        """
        self.interval = profile.interval(transport)
        self.lead = 0.0
        self._family, self._actuation = family, actuation
        self._transport, self._sequence = transport, sequence
        ceilings = {
            channel.name: actuator.safe_maximum
            for actuator in profile.actuators
            for channel in actuator.channels
        }
        self._limits = DriveLimits(
            np.array([ceilings.get(channel, 1.0) for channel in family.channels]),
            profile.slew,
            profile.sustained_maximum,
            profile.sustained_seconds,
            command_seconds,
        )
        self.adjust(adjustment)
        self._end = self._fresh = self._wrote = -np.inf
        self._begin()

    def _begin(self) -> None:
        self._startup: deque[Report] = deque(self._family.startup(self._transport, self._sequence))
        self._starting = False

    def adjust(self, adjustment: Adjustment) -> None:
        """Follow the user's settings from now on."""
        self._delay = adjustment.delay
        self._actuation.calibrate(adjustment.calibrations)
        self._limits.scale_ceilings(adjustment.ceiling)

    @abstractmethod
    def accept(self, block: FloatArray, sent: float) -> None:
        """Play a fresh block of (actuators, n) samples, whose first is to be felt at ``sent``."""

    def expect(self, ahead: FloatArray, sent: float) -> None:
        """Play the (actuators, m) samples after the block of ``sent`` if no other block comes in
        time."""
        if sent == self._fresh:
            self._continue(Ahead(ahead, self._actuation.rate, self._end))

    @abstractmethod
    def _continue(self, ahead: Ahead) -> None: ...

    def silence(self) -> None:
        """Discard everything that is not written yet, and go to zero."""
        self._actuation.reset()
        self._fresh = -np.inf

    @abstractmethod
    def next_report(self, now: float) -> Report | None:
        """The report to write at ``now``, or None. A report that is returned counts as written."""

    def written(self, now: float) -> None:
        """Record that the last report was written at ``now``."""
        self._wrote = now

    def failed(self) -> None:
        """Record that the last report did not arrive; a start-up begins again."""
        if self._starting:
            self._begin()

    @abstractmethod
    def wake(self, now: float) -> float | None:
        """Time of the next call unless a block arrives before; None if nothing is scheduled."""

    @abstractmethod
    def _zero(self) -> Report: ...

    def ending(self, farewell: bool) -> tuple[Report, ...]:
        """The reports that stop the device, to be written one ``interval`` apart: zero, release,
        and ``farewell`` before it is closed."""
        reports = [self._zero(), *self._family.release(self._transport, self._sequence + 1)]
        if farewell:
            reports += self._family.farewell(self._transport, self._sequence + len(reports))
        self._sequence += len(reports)
        return tuple(reports)

    def restart(self) -> None:
        """Play again on a device that was stopped; the state of the limits is kept."""
        self.silence()
        self._begin()


class RumblePacing(Pacing):
    """Pacing of a device that is commanded by amplitude.

    A command uses the largest amplitude of each channel since the last one, so that a slow device
    does not miss a short impact.
    """

    _family: RumbleFamily
    _actuation: ToneActuation

    def __init__(
        self,
        profile: Profile,
        family: RumbleFamily,
        transport: Transport,
        rate: int,
        adjustment: Adjustment,
        sequence: int,
    ) -> None:
        actuation = ToneActuation(profile, family, rate)
        super().__init__(
            profile, family, transport, actuation, adjustment, sequence, profile.interval(transport)
        )
        self._steps: deque[tuple[float, Tones]] = deque()
        self._ahead = Ahead()
        self._rest = self._current = self._family.silence()
        self._silent = self._family.encode(self._rest, self._transport, 0).data
        self._assume_unknown_state()
        self._last_step = -np.inf

    def _assume_unknown_state(self) -> None:
        """Discard the known state of the device: a program that was killed may have changed it."""
        self._known = b""
        self._zeros_left = self._family.zero_repeats

    def accept(self, block: FloatArray, sent: float) -> None:
        start = sent + self._delay
        self._steps = deque(
            (start + step.offset, step.tones) for step in self._actuation.process(block)
        )
        self._end = start + block.shape[1] / self._actuation.rate
        self._ahead = self._ahead.after(self._end)
        self._fresh = sent

    def _continue(self, ahead: Ahead) -> None:
        self._ahead = ahead

    def silence(self) -> None:
        super().silence()
        self._steps.clear()
        self._ahead = Ahead()
        self._current = self._rest

    def next_report(self, now: float) -> Report | None:
        if now < self._wrote + self.interval:
            return None
        self._starting = bool(self._startup)
        if self._starting:
            return self._count(self._startup.popleft(), now)
        if now - self._fresh > WATCHDOG + self._delay:
            self.silence()
        wanted = self._due(now)
        elapsed = min(now - self._last_step, 1e6)
        self._last_step = now
        amplitudes = self._limits.limited(np.array(wanted.amplitudes), elapsed)
        drive = (
            Tones(tuple(amplitudes.tolist()), wanted.frequencies)
            if amplitudes.any()
            else self._rest
        )
        return self._unless_known(drive, now)

    def failed(self) -> None:
        super().failed()
        self._assume_unknown_state()

    def wake(self, now: float) -> float | None:
        if (
            self._startup
            or self._steps
            or self._ahead
            or self._zeros_left
            or self._current.amplitudes != self._rest.amplitudes
        ):
            look = max(self._wrote, self._last_step) + self.interval
            if self._known != self._silent:
                return max(
                    min(look, self._wrote + self._family.refresh_interval),
                    self._wrote + self.interval,
                )
            return look
        return None

    def restart(self) -> None:
        super().restart()
        self._assume_unknown_state()

    def _zero(self) -> Report:
        return self._family.encode(self._rest, self._transport, self._sequence)

    def _due(self, now: float) -> Tones:
        """The strongest of the steps due since the last call, channel by channel; the last of them
        stays in force."""
        while self._ahead and self._ahead.start <= now:
            start = self._ahead.start
            chunk = self._ahead.pop(self._actuation.hop)
            self._steps.extend(
                (start + step.offset, step.tones) for step in self._actuation.process(chunk)
            )
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
        """The report for a drive, unless the device has that drive and needs no refresh."""
        data = self._family.encode(drive, self._transport, 0).data
        if data == self._silent:
            if self._zeros_left == 0:
                return None
            self._zeros_left -= 1
        else:
            if data == self._known and now - self._wrote < self._family.refresh_interval:
                return None
            self._zeros_left = self._family.zero_repeats
        self._known = data
        return self._count(self._family.encode(drive, self._transport, self._sequence), now)

    def _count(self, report: Report, now: float) -> Report:
        self._sequence += 1
        self._wrote = now
        return report


class StreamPacing(Pacing):
    """Pacing of a device driven by samples: each report is due when the one before it has been
    played.

    The schedule does not depend on the duration of writes.
    """

    _family: StreamFamily
    _actuation: SampleActuation

    def __init__(
        self,
        profile: Profile,
        family: StreamFamily,
        transport: Transport,
        rate: int,
        adjustment: Adjustment,
        sequence: int,
    ) -> None:
        super().__init__(
            profile,
            family,
            transport,
            SampleActuation(profile.actuators, family.channels, rate, family.rate),
            adjustment,
            sequence,
            family.period,
        )
        channels = len(family.channels)
        self.lead = family.period + _MARGIN
        self._queue = SampleQueue(channels, self._actuation.hop, self._actuation.process)
        self._samples = SampleLimits(self._limits, channels)
        self._due: float | None = None

    def accept(self, block: FloatArray, sent: float) -> None:
        queue = self._queue
        begun = queue.ahead.begun
        if begun:  # then the block waits for its turn as long as any other
            queue.fill(round(self.lead * self._family.rate))
        place = self._place(sent)
        is_cut = place < len(queue)
        queue.samples = queue.samples[:, :place]
        dry = queue.dry and not len(queue)
        seam = dry or is_cut or begun
        if seam:
            self._actuation.reset()
        samples = self._actuation.process(block)
        if seam:
            join(samples, 0, queue.samples[:, -1:] if len(queue) else queue.last)
        if dry or self._due is None:
            self._due = max(sent + self._delay + self.lead, self._due or -np.inf)
        queue.append(samples)
        self._end = sent + block.shape[1] / self._actuation.rate
        queue.ahead = queue.ahead.after(self._end)
        self._fresh = sent

    def _place(self, sent: float) -> int:
        """Index in the queue where a block begins: at its time, or at the end if that differs by
        less than a frame may be early."""
        if self._due is None:
            return len(self._queue)
        place = max(round((sent + self._delay + self.lead - self._due) * self._family.rate), 0)
        return place if len(self._queue) - place > _MARGIN * self._family.rate else len(self._queue)

    def _continue(self, ahead: Ahead) -> None:
        self._queue.ahead = ahead

    def silence(self) -> None:
        super().silence()
        self._queue.clear()
        self._queue.dry = True

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
        super().failed()
        self._queue.dry = True

    def wake(self, now: float) -> float | None:
        return self._due

    def restart(self) -> None:
        super().restart()
        self._due = None

    def _zero(self) -> Report:
        zero = np.zeros((len(self._family.channels), self._family.frames), dtype=np.int8)
        return self._family.encode(zero, self._sequence)

    def _packet(self) -> Report:
        samples = self._samples.limited(self._queue.take(self._family.frames), self._family.period)
        report = self._family.encode(np.round(127.0 * samples).astype(np.int8), self._sequence)
        self._sequence += 1
        return report


def pacing_of(
    profile: Profile,
    family: AnyFamily,
    transport: Transport,
    rate: int,
    adjustment: Adjustment,
    sequence: int = 0,
) -> Pacing:
    """Pacing of rumble commands or of a stream of samples, as the family of devices takes them.

    Args:
        profile: of the device.
        family: of the device.
        transport: by which it is connected.
        rate: samples per second of the blocks.
        adjustment: the user's settings.
        sequence: number of the first report.
    """
    if isinstance(family, RumbleFamily):
        return RumblePacing(profile, family, transport, rate, adjustment, sequence)
    return StreamPacing(profile, family, transport, rate, adjustment, sequence)
