"""The real ``hidraw`` module that writes down every report and when it was written. It can be
pickled, for the guard process."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from haptic_tracing.core.devices.connection import hid_module


@dataclass(frozen=True)
class TimedHid:
    """folder: gets one file per device node, a line of JSON per report: seconds of
    `time.perf_counter`, bytes as hexadecimal."""

    folder: str

    def enumerate(self, *arguments):
        return hid_module().enumerate(*arguments)

    def device(self):
        return _TimedDevice(hid_module().device(), Path(self.folder))


class _TimedDevice:
    def __init__(self, real, folder):
        self._real, self._folder = real, folder

    def __getattr__(self, name):
        return getattr(self._real, name)

    def open_path(self, path):
        self._real.open_path(path)
        self._log = (self._folder / Path(path.decode()).name).open("a", buffering=1)

    def write(self, data):
        return self._written(data, self._real.write(data))

    def send_feature_report(self, data):
        copy = bytes(bytearray(data))  # umockdev answers into the buffer that it is given
        return self._written(copy, self._real.send_feature_report(data))

    def _written(self, data, done):
        if done >= 0:
            self._log.write(json.dumps([time.perf_counter(), bytes(data).hex()]) + "\n")
        return done


def reports_of(folder, node):
    """What was written to a node: [(seconds, bytes)]."""
    lines = (Path(folder) / node).read_text().splitlines()
    return [(seconds, bytes.fromhex(data)) for seconds, data in map(json.loads, lines)]
