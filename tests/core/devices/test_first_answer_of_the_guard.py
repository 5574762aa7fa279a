"""A guard may answer before the program has told it of its first device: another thread can hold
Python's lock in between."""

import time

from file_hid import file_device, reports_of
from haptic_tracing.core.devices import guard
from haptic_tracing.core.devices.profiles import profile


def test_a_device_opens_although_the_guard_may_have_answered_before(tmp_path, monkeypatch):
    told = guard.Guard.open

    def late(self, *what):
        time.sleep(2.0)
        return told(self, *what)

    monkeypatch.setattr(guard.Guard, "open", late)
    pad = profile("dualsense")
    output = guard.DeviceOutput(pad, hid=file_device(str(tmp_path / "reports"), pad.family))
    output.start()
    try:
        output.wait_until_open(20.0)
    finally:
        output.stop(20.0)
    assert output.is_silent and reports_of(tmp_path / "reports")
