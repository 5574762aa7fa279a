"""Writer threads with devices that are slow, fail or vanish. Waits are on events, never on a length
of time that has to suffice."""

import os
import subprocess
import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from fake_hid import RELEASE, ZERO, FakeHid, FakePad, sounding, until
from haptic_tracing.core.devices.connection import DeviceError, hid_module, open_device
from haptic_tracing.core.devices.families.registry import family
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.profiles import Adjustment, Calibration
from haptic_tracing.core.devices.status import stop_together
from haptic_tracing.core.devices.writer import DeviceWriter

RATE = 8000


def quick(name="dualsense"):
    """A profile whose device takes reports as fast as they come, so that tests do not wait for its
    pace."""
    device = profile(name)
    pace = dict.fromkeys(device.family.transports, 1e-4)
    return replace(device, family=replace(device.family, minimum_interval=pace))


def wave(seconds=0.05, amplitude=1.0, rows=2):
    return np.tile(
        amplitude * np.sin(2 * np.pi * 200.0 * np.arange(round(seconds * RATE)) / RATE), (rows, 1)
    )


def playing(output):
    """Send until the device sounds."""

    def sends():
        output.send(wave())
        return output.status.delay is not None

    until(sends)


@pytest.fixture
def started():
    outputs = []

    def start(hid, device=None, **options):
        output = DeviceWriter(device or quick(), hid=hid, **options)
        outputs.append(output)
        output.start()
        return output

    yield start
    ended = [output.stop(5.0) for output in outputs]
    assert all(ended), "every thread"


def test_playing_and_stopping_leaves_the_device_silent_released_and_closed(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    until(lambda: pad.written == [ZERO])
    playing(output)
    until(lambda: sounding(pad))
    assert output.status.state == "open" and output.status.failed_writes == 0
    assert output.status.lag == pytest.approx(output.status.delay + 0.010)
    assert output.stop()
    assert pad.written[-2:] == [ZERO, RELEASE]
    assert (pad.opened, pad.closed) == (1, 1) and output.status.state == "stopped"
    assert len(pad.writers) == 1


def test_the_latest_block_wins_and_dropped_ones_are_counted(started):
    pad = FakePad()
    pad.gate.clear()
    output = started(FakeHid(pad))
    assert pad.in_write.wait(60)
    for amplitude in (1.0, 0.5, 0.0):
        output.send(wave(amplitude=amplitude))
    pad.gate.set()
    output.send(np.zeros((2, 80)))
    output.stop()
    assert not sounding(pad)
    assert output.status.dropped_blocks >= 2


def test_a_write_that_blocks_blocks_nobody_else_and_the_device_is_silenced_when_it_returns(started):
    stuck, free = FakePad(b"/dev/stuck", serial="stuck"), FakePad(b"/dev/free", serial="free")
    hid = FakeHid(stuck, free)
    blocked, other = started(hid, serial="stuck"), started(hid, serial="free")
    playing(blocked)
    playing(other)
    stuck.gate.clear()
    stuck.in_write.clear()
    blocked.silence()
    assert stuck.in_write.wait(60)
    for _ in range(1000):
        blocked.send(wave(0.01))
    free.written.clear()
    playing(other)
    until(lambda: sounding(free))
    until(lambda: blocked.status.writing_for > 0.0)
    assert blocked.stop(timeout=0.05) is False
    assert blocked.status.state == "open", "still inside the system"
    assert other.stop()
    assert stuck.closed == 0
    stuck.gate.set()
    assert blocked.stop(5.0) is True
    assert stuck.written[-2:] == [ZERO, RELEASE] and stuck.closed == 1


@pytest.mark.slow
def test_a_device_that_vanishes_is_searched_and_played_again_when_it_is_back(started):
    pad = FakePad()
    hid = FakeHid(pad)
    output = started(hid)
    playing(output)
    hid.pads.clear()

    def lost():
        output.send(wave(amplitude=0.3))
        output.silence()
        return output.status.losses == 1

    until(lost)
    assert output.status.failed_writes == 3
    until(lambda: output.status.message == "DualSense is not connected")
    assert output.status.state == "searching" and pad.closed == 1
    pad.written.clear()
    hid.pads.append(pad)
    until(lambda: output.status.state == "open")
    until(lambda: ZERO in pad.written)
    playing(output)
    until(lambda: sounding(pad))
    assert output.status.message == ""
    assert output.stop() and pad.written[-2:] == [ZERO, RELEASE] and pad.opened == pad.closed == 2


def test_a_failed_write_is_counted_and_repeated_and_not_fatal(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    until(lambda: pad.written == [ZERO])
    pad.failing = 2
    until(lambda: (output.send(wave()), output.status.failed_writes == 2)[-1])
    playing(output)
    until(lambda: sounding(pad))
    assert output.status.state == "open" and output.status.losses == 0 and pad.opened == 1
    assert output.status.message == "DualSense: write failed: No such device"


def test_a_zero_that_failed_is_repeated_until_it_arrives(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    playing(output)
    until(lambda: sounding(pad))
    pad.failing = 2
    output.silence()
    until(lambda: pad.written[-1] == ZERO)
    assert pad.failing == 0


def test_eight_devices_at_once_and_all_stop_together(started):
    pads = [FakePad(f"/dev/fake{i}".encode(), serial=str(i)) for i in range(8)]
    hid = FakeHid(*pads)
    outputs = [started(hid) for _ in pads]
    until(lambda: all(output.status.state == "open" for output in outputs))
    for output in outputs:
        playing(output)
    until(lambda: all(sounding(pad) for pad in pads))
    assert stop_together(outputs, 60.0)
    assert all(
        pad.written[-2:] == [ZERO, RELEASE] and pad.opened == pad.closed == 1 for pad in pads
    )
    assert len(set().union(*(pad.writers for pad in pads))) == 8


@pytest.mark.slow
def test_a_thousand_starts_and_stops_leave_nothing_behind():
    pad = FakePad()
    hid = FakeHid(pad)
    threads = threading.active_count()
    for i in range(1000):
        output = DeviceWriter(quick(), hid=hid)
        output.start()
        if i % 3 == 0:
            output.send(wave(0.01))
        if i % 5 == 0:
            until(lambda: output.status.state == "open")  # noqa: B023
        assert output.stop(60.0)
        assert pad.opened == pad.closed
    assert threading.active_count() == threads
    assert pad.written[-2:] == [ZERO, RELEASE]


def test_silence_silences_what_plays_and_blocks_play_again(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    playing(output)
    assert until(lambda: sounding(pad))
    output.silence()
    assert until(lambda: pad.written[-1] == ZERO)
    pad.written.clear()
    playing(output)
    assert until(lambda: sounding(pad))


def test_at_rest_the_device_is_silent_and_released_but_open_and_plays_again(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    for _ in range(2):
        playing(output)
        until(lambda: sounding(pad))
        output.rest()
        until(lambda: pad.written[-2:] == [ZERO, RELEASE])
        assert output.status.state == "open" and pad.closed == 0
        pad.written.clear()
        output.rest()
    time.sleep(0.05)
    assert pad.written == [], "a device at rest is left alone"
    playing(output)
    until(lambda: sounding(pad))


def test_settings_can_be_changed_while_it_plays(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    playing(output)
    until(lambda: sounding(pad))
    output.adjust(Adjustment(ceiling=0.0))
    until(lambda: (output.send(wave()), pad.written[-1] == ZERO)[-1])
    output.adjust(Adjustment({"left grip": Calibration(gain=0.0)}))
    until(lambda: (output.send(wave()), pad.written[-1][3] > 0)[-1])
    assert pad.written[-1][4] == 0


def test_the_last_zero_is_repeated_where_it_fails(started):
    for end in (DeviceWriter.rest, DeviceWriter.stop):
        pad = FakePad()
        output = started(FakeHid(pad))
        playing(output)
        assert until(lambda pad=pad: sounding(pad))
        pad.failing = 2
        end(output)
        assert until(lambda pad=pad: pad.written[-2:] == [ZERO, RELEASE])
        output.stop()


def test_the_watchdog_needs_nobody(started):
    pad = FakePad()
    output = started(FakeHid(pad))
    playing(output)
    assert until(lambda: sounding(pad))
    assert until(lambda: pad.written[-1] == ZERO)


def test_an_error_in_the_thread_still_silences_the_device(started):
    pad = FakePad()
    device = quick()
    broken = replace(
        device.family, release=lambda transport, sequence: (), encode=Once(device.family.encode)
    )
    output = started(FakeHid(pad), replace(device, family=broken))
    until(lambda: (output.send(wave()), output.status.state == "failed")[-1])
    assert output.status.message == "ZeroDivisionError: an error of the program"
    assert pad.written[-1] == ZERO and pad.closed == 1


class Once:
    """An encoder that fails the first time it is to drive something."""

    def __init__(self, encode):
        self.encode, self.failed = encode, False

    def __call__(self, drive, transport, sequence):
        if any(drive.amplitudes) and not self.failed:
            self.failed = True
            raise ZeroDivisionError("an error of the program")
        return self.encode(drive, transport, sequence)


@pytest.mark.slow
def test_a_device_held_by_another_program_is_named_and_taken_when_it_is_free(started, tmp_path):
    node = tmp_path / "hidraw0"
    node.write_bytes(b"")
    pad = FakePad(str(node).encode())
    pad.open_error = "held"
    output = started(FakeHid(pad))
    assert until(lambda: "another program" in output.status.message)
    pad.open_error = None
    assert until(lambda: output.status.state == "open")


def test_two_outputs_share_two_devices_and_a_third_is_told(started):
    hid = FakeHid(FakePad(b"/dev/a"), FakePad(b"/dev/b"))
    first, second = started(hid), started(hid)
    assert until(lambda: first.status.state == second.status.state == "open")
    third = started(hid)
    assert until(lambda: third.status.message == "DualSense is already in use here")


def test_a_module_of_the_same_name_from_another_package_is_refused(tmp_path):
    """The package ``hid`` has a class ``Device`` and no function ``device``."""
    name = "hidraw" if sys.platform.startswith("linux") else "hid"
    (tmp_path / f"{name}.py").write_text(
        "class Device: ...\ndef enumerate(vid=0, pid=0): return []\n"
    )
    program = "from haptic_tracing.core.devices.connection import hid_module\nhid_module()"
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]),
    }
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert (
        f"the Python module {name} is not that of the package hidapi"
        in done.stderr.splitlines()[-1]
    )


def test_the_real_module_is_the_one_that_sees_bluetooth():
    assert hid_module().__name__ in ("hidraw", "hid")


def test_nothing_connected_is_said_in_one_line():
    with pytest.raises(DeviceError, match=r"^DualSense is not connected$"):
        open_device(FakeHid(), family("dualsense"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rate": 0}, "rate 0"),
        ({"adjustment": {"delay": -0.1}}, "delay -0.1"),
        ({"adjustment": {"delay": 5.0}}, "delay 5.0"),
        ({"adjustment": {"ceiling": 1.5}}, "ceiling 1.5"),
        (
            {"adjustment": {"calibrations": {"left wing": Calibration()}}},
            "unknown actuator: 'left wing'",
        ),
    ],
)
def test_options_out_of_range_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        if "adjustment" in options:
            options = {"adjustment": Adjustment(**options["adjustment"])}
        DeviceWriter(profile("dualsense"), **options)


def test_a_block_of_another_shape_is_refused_by_send():
    output = DeviceWriter(profile("dualsense"), hid=FakeHid())
    with pytest.raises(ValueError, match="block has the shape"):
        output.send(np.zeros((3, 10)))


def test_stopping_what_never_started_is_fine():
    output = DeviceWriter(profile("dualsense"), hid=FakeHid())
    assert output.stop() and output.status.state == "stopped"
