"""A hidapi module with devices that are slow, fail or vanish, and keep every report."""

import threading
import time

ZERO = bytes([2, 2]) + bytes(37) + bytes([4]) + bytes(8)
"""A DualSense's zero over USB, and the report that releases it."""
RELEASE = bytes([2]) + bytes(47)


def until(condition):
    """Wait for something that has to happen, and return what it came to."""
    end = time.perf_counter() + 60.0  # a starved machine may stand still for long
    while not (came := condition()):
        assert time.perf_counter() < end, "did not happen"
        time.sleep(0.001)
    return came


def sounding(pad):
    """Whether a DualSense was driven over USB."""
    return any(report[3] or report[4] for report in pad.written)


class FakePad:
    """One connected device. Its writes block while ``gate`` is clear, and the next ``failing`` of
    them fail."""

    def __init__(
        self,
        path=b"/dev/fake0",
        vendor=0x054C,
        product=0x0CE6,
        number=3,
        serial="",
        usage=(0x01, 0x05),
        bus=1,
    ):
        self.path, self.serial = path, serial
        self.entry = {
            "path": path,
            "vendor_id": vendor,
            "product_id": product,
            "serial_number": serial,
            "product_string": "Fake pad",
            "usage_page": usage[0],
            "usage": usage[1],
            "interface_number": number,
            "bus_type": bus,
        }
        self.written = []
        self.failing = 0
        self.gate = threading.Event()
        self.gate.set()
        self.in_write = threading.Event()
        self.opened = self.closed = 0
        self.input = []
        self.writers = set()
        self.open_error = None


class FakeHid:
    """The module. ``pads`` is what is plugged in."""

    def __init__(self, *pads):
        self.pads = list(pads)
        self.enumerations = 0

    def enumerate(self, vendor_id=0, product_id=0):
        self.enumerations += 1
        return [pad.entry for pad in self.pads]

    def device(self):
        return FakeDevice(self)


class FakeDevice:
    """An open device: like hidapi's, it reports a failed write by -1 and knows nothing of other
    threads."""

    def __init__(self, hid):
        self.hid, self.pad = hid, None

    def open_path(self, path):
        for pad in self.hid.pads:
            if pad.path == path and pad.open_error is None:
                self.pad = pad
                pad.opened += 1
                return
        raise OSError("open failed")

    def write(self, data):
        pad = self.pad
        assert pad is not None, "write to a closed device"
        pad.writers.add(threading.get_ident())
        pad.in_write.set()
        assert pad.gate.wait(120), "nobody lets the write go on"
        assert self.pad is not None, "closed during a write: hidapi would crash"
        if pad not in self.hid.pads:
            return -1
        if pad.failing:
            pad.failing -= 1
            return -1
        pad.written.append(bytes(data))
        return len(data)

    def send_feature_report(self, data):
        return self.write(data)

    def get_feature_report(self, report, length):
        raise OSError("read error")

    def read(self, length, timeout_ms):
        return self.pad.input

    def error(self):
        return "No such device"

    def close(self):
        self.pad.closed += 1
        self.pad = None
