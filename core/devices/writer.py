"""Writing to devices in this process: one thread per device takes the newest block, keeps the
device's report interval and silences the device at the end.

Nothing here blocks the caller: ``send`` puts a block into a mailbox of size one, in which the
latest replaces the previous. `guard.DeviceOutput` does this in the guard process, so that a device
falls silent whatever ends the program.
"""

from __future__ import annotations

import threading
import time
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .actuation import checked_block
from .connection import DeviceError, DeviceInUse, HidModule, Opened, hid_module, open_device
from .families.family import AnyFamily
from .pacing import WATCHDOG, Pacing, pacing_of
from .profiles import Adjustment, Profile, check_adjustment
from .report import Report
from .status import UNREACHED, ThreadedOutput

SAMPLE_RATE = 8000
RESCAN = 1.5
"""Seconds between two searches for a missing device."""
REOPEN = 0.1
"""Seconds after which a device is tried again that another output of this process is about to
close."""
_CLOSES_WITHIN = 10
"""Attempts to reopen a device after which it is in use for longer, which is then said."""

# hidapi reports a vanished device only by failing writes; a single failure can be a radio
# disturbance.
_FAILURES_TO_CLOSE = 3

_Mail = tuple[FloatArray, float]
"""A block or the samples ahead, and when it was sent."""


class DeviceWriter(ThreadedOutput):
    """One device that is fed with blocks of samples, one row per actuator of its profile."""

    def __init__(
        self,
        profile: Profile,
        *,
        rate: int = SAMPLE_RATE,
        serial: str = "",
        adjustment: Adjustment | None = None,
        hid: HidModule | None = None,
    ) -> None:
        """rate: samples per second of the blocks. serial: selects one of several equal devices.
        adjustment: the user's settings. hid: replacement for cython-hidapi.

        Raises ValueError for a rate out of range, or a calibration of an unknown actuator.
        """
        if not 100 <= rate <= 192_000:
            raise ValueError(f"rate {rate} is not in 100..192000")
        super().__init__(profile.name)
        self.profile = profile
        self._rate, self._serial = rate, serial
        self._hid = hid
        self._adjustment = Adjustment()
        self._wake = threading.Condition()
        # Guarded by _wake:
        self._mail: _Mail | None = None
        self._expected: _Mail | None = None
        self._silence = False
        self._rest = False
        self._stopping = False
        # Written by the thread alone:
        self._wrote = self._lead = 0.0
        self._refusals = 0
        self._may_vibrate = False
        self.adjust(adjustment or Adjustment())

    def adjust(self, adjustment: Adjustment) -> None:
        check_adjustment(adjustment, self.profile.actuators)
        self._adjustment = adjustment

    def start(self) -> None:
        _running.add(self)
        super().start()

    def send(self, block: ArrayLike, sent: float | None = None) -> float:
        checked = checked_block(np.asarray(block), len(self.profile.actuators))
        sent = time.perf_counter() if sent is None else sent
        with self._wake:
            self._dropped += self._mail is not None
            self._mail = checked, sent
            self._expected = None
            self._wake.notify()
        return sent

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        checked = checked_block(np.asarray(ahead), len(self.profile.actuators))
        with self._wake:
            self._expected = checked, sent
            self._wake.notify()

    def silence(self) -> None:
        self._drop(_silence=True)

    def rest(self) -> None:
        self._drop(_rest=True)

    def request_stop(self) -> None:
        self._drop(_stopping=True)

    def _drop(self, **wanted: bool) -> None:
        """Discard everything sent so far, and notify the thread."""
        with self._wake:
            self._mail = self._expected = None
            for name, value in wanted.items():
                setattr(self, name, value)
            self._wake.notify()

    def _lag(self, delay: float) -> float:
        return delay + self._lead + self._adjustment.delay + self.profile.latency

    # From here on: the thread.

    def _run(self) -> None:
        try:
            hid = self._hid or hid_module()
            while not self._stopping:
                opened = self._open(hid)
                if opened is not None:
                    self._play(opened)
            if self._may_vibrate:
                raise DeviceError(
                    f"{self._message or f'{self.profile.title} did not take the last zero'}: "
                    f"{UNREACHED}"
                )
            self._state = "stopped"
        except DeviceError as error:
            self._state = "failed"
            self._message = str(error)
        except Exception as error:
            self._state = "failed"
            self._message = f"{type(error).__name__}: {error}"
        finally:
            _running.discard(self)

    def _open(self, hid: HidModule) -> Opened | None:
        """The device, or None after waiting for a while because it can't be opened."""
        try:
            # Opening holds the GIL. On old kernels it waits for a blocked write to another device.
            if any(output.status.writing_for > 0.1 for output in tuple(_running)):
                raise DeviceError("waiting: a write to another device is blocked")
            opened = open_device(hid, self.profile.family, self._serial)
        except DeviceInUse as error:
            self._refusals += 1
            if self._refusals > _CLOSES_WITHIN:
                self._message = str(error)
            self._pause(REOPEN)
            return None
        except OSError as error:
            self._message = str(error)
            self._pause(RESCAN)
            return None
        self._message, self._refusals = "", 0
        return opened

    def _play(self, opened: Opened) -> None:
        """Drive the device until a stop or its disconnection. Always leaves it silent and
        closed."""
        pacing: Pacing | None = None
        try:
            pacing = self._prepare(opened)
            self._lead = pacing.lead
            self._state, self._may_vibrate = "open", True
            while self._follow(opened, pacing) == "rest":
                if not self._end(opened, pacing, farewell=False):
                    self._lose()
                    break
                self._sleep()
                self._may_vibrate = True
                pacing.restart()
        except OSError as error:
            self._message = str(error)
            self._pause(RESCAN)
        finally:
            try:
                if pacing is not None and self._state == "open":
                    self._end(opened, pacing, farewell=True)
            finally:
                opened.close()

    def _prepare(self, opened: Opened) -> Pacing:
        """Set up the device for its family. Raises OSError if it cannot be driven."""
        family: AnyFamily = self.profile.family
        before = self._written
        if family.prepare is not None:
            family = (
                family.prepare(opened.hid, opened.interface, partial(self._write, opened)) or family
            )
        transport = opened.interface.transport
        return pacing_of(
            self.profile, family, transport, self._rate, self._adjustment, self._written - before
        )

    def _pause(self, seconds: float) -> None:
        """Wait until the next search for the device, or until a stop."""
        with self._wake:
            self._wake.wait_for(lambda: self._stopping, seconds)

    def _sleep(self) -> None:
        """Wait until a block arrives, or until a stop."""
        with self._wake:
            self._silence = self._rest = False
            self._wake.wait_for(lambda: self._mail is not None or self._stopping)

    def _follow(self, opened: Opened, pacing: Pacing) -> Literal["stop", "rest", "lost"]:
        """Write reports when they are due, until a stop, a rest, or the loss of the device."""
        failures = 0
        adjustment: Adjustment | None = None
        unmeasured: float | None = None
        while not self._stopping:
            with self._wake:
                mail, self._mail = self._mail, None
                expected, self._expected = self._expected, None
                silence, self._silence = self._silence, False
                rest, self._rest = self._rest, False
            if rest and mail is None:
                return "rest"
            if adjustment is not self._adjustment:
                adjustment = self._adjustment
                pacing.adjust(adjustment)
            if silence or rest:
                pacing.silence()
            # A block that waited for the device to be opened is too old to be played.
            if mail is not None and time.perf_counter() - mail[1] < WATCHDOG:
                pacing.accept(*mail)
                unmeasured = mail[1]
            if expected is not None:
                pacing.expect(*expected)
            report = pacing.next_report(time.perf_counter())
            if report is None:
                self._wait(pacing)
                continue
            if self._write(opened, report):
                pacing.written(self._wrote)
                failures = 0
                if unmeasured is not None:
                    self._delays.append(time.perf_counter() - unmeasured)
                    unmeasured = None
                continue
            pacing.failed()
            failures += 1
            if failures == _FAILURES_TO_CLOSE:
                self._lose()
                return "lost"
        return "stop"

    def _wait(self, pacing: Pacing) -> None:
        """Wait until a report is due, a block arrives, or a stop."""
        with self._wake:
            if (
                self._mail is None
                and self._expected is None
                and not (self._silence or self._rest or self._stopping)
            ):
                now = time.perf_counter()
                due = pacing.wake(now)
                self._wake.wait(None if due is None else max(due - now, 0.0))

    def _write(self, opened: Opened, report: Report) -> bool:
        """Write a report; returns whether the device accepted it. hidapi returns -1 for failure and
        blocks as long as the system does."""
        self._writing_since = time.perf_counter()
        try:
            send = opened.hid.send_feature_report if report.feature else opened.hid.write
            done = send(report.data) >= 0
            reason = "" if done else opened.hid.error()
        except (OSError, ValueError) as error:
            done = False
            reason = str(error)
        finally:
            self._writing_since = None
            self._wrote = time.perf_counter()
        if done:
            self._written += 1
        else:
            self._failed += 1
            self._message = (
                f"{self.profile.title}: write failed: {reason or 'the device does not answer'}"
            )
        return done

    def _lose(self) -> None:
        """Mark the device as lost, to search for it again."""
        self._state = "searching"
        self._losses += 1

    def _end(self, opened: Opened, pacing: Pacing, *, farewell: bool) -> bool:
        """Write zero and release at the device's pace, the second even if the first fails. Returns
        whether both arrived."""
        taken = [
            self._write_repeatedly(opened, report, pacing.interval)
            for report in pacing.ending(farewell)
        ]
        self._may_vibrate = not all(taken)
        return not self._may_vibrate

    def _write_repeatedly(self, opened: Opened, report: Report, interval: float) -> bool:
        """Write a report, up to `_FAILURES_TO_CLOSE` times if that fails. Returns whether it was
        written."""
        for _ in range(_FAILURES_TO_CLOSE):
            time.sleep(max(self._wrote + interval - time.perf_counter(), 0.0))
            if self._write(opened, report):
                return True
        return False


_running: set[DeviceWriter] = set()
