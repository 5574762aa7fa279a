"""A device that is a file: it gets a line of JSON per report, seconds of `time.perf_counter` and
the bytes. Works on every system."""

import json
import time
from functools import partial
from pathlib import Path

from haptic_tracing.core.devices.connection import StandInModule
from haptic_tracing.core.devices.families.family import HidDevice, Interface


class FileDevice(HidDevice):
    def __init__(self, file):
        super().__init__()
        self.file = file

    def open_path(self, path):
        pass

    def take(self, data):
        with Path(self.file).open("a", encoding="ascii") as log:
            log.write(json.dumps([time.perf_counter(), bytes(data).hex()]) + "\n")

    def close(self):
        pass


def file_device(file, family):
    """hidapi's module with a USB device of the family."""
    vendor, product = min(family.ids)
    usages = (0x01, 0x05), (0xFF00, 0x01)
    places = (Interface(b"file", vendor, product, "", "Pad", *usage, 2, "usb") for usage in usages)
    return StandInModule(next(filter(family.matches, places)), partial(FileDevice, file))


def reports_of(file):
    """What was written to a device: [(seconds, bytes)]."""
    return [
        (seconds, bytes.fromhex(data))
        for seconds, data in map(json.loads, Path(file).read_text(encoding="ascii").splitlines())
    ]
