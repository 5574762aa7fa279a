"""Pads that answer as SDL's drivers expect it."""

from haptic_tracing.core.devices.families.family import Interface
from haptic_tracing.core.devices.families.registry import family


class Pad:
    """A pad that answers. answers: an input report for each output report that begins with the
    key's bytes; features: by report id."""

    def __init__(self, answers=None, features=None, inputs=()):
        self.answers, self.features = answers or {}, features or {}
        self.written, self.inputs = [], list(inputs)

    def write(self, data):
        self.written.append(bytes(data))
        self.inputs.append(bytes([0x30]) + bytes(48))  # the sticks go on being reported in between
        self.inputs += [answer for start, answer in self.answers.items() if data.startswith(start)]
        return True

    def read(self, length, timeout_ms):
        return list(self.inputs.pop(0)) if self.inputs else []

    def get_feature_report(self, report, length):
        if report not in self.features:
            raise OSError("read error")
        return list(self.features[report])


def interface(vendor, product, transport="usb", title="Pad"):
    return Interface(b"/dev/pad", vendor, product, "", title, 0x01, 0x05, 0, transport)


def prepared(name, pad, found):
    return family(name).prepare(pad, found, lambda report: pad.write(report.data))
