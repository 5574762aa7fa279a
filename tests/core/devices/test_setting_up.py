"""What is said to a pad once, when it is opened, and what its answers change: pads that answer as
SDL's drivers expect it."""

import pytest
from haptic_tracing.core.devices.families.family import Interface
from haptic_tracing.core.devices.families.registry import families_of, family


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


VIBRATION_CONFIRMED = bytes([0x21]) + bytes(12) + bytes([0x80, 0x48]) + bytes(49)
ACKNOWLEDGED = {bytes([0x80, command]): bytes([0x81, command]) + bytes(62) for command in (2, 3)}


@pytest.mark.parametrize("transport", ["usb", "bt"])
def test_a_switch_pad_that_answers_is_told_everything_once(transport):
    pad = Pad({**ACKNOWLEDGED, b"\x01": VIBRATION_CONFIRMED})
    assert prepared("switch-pro", pad, interface(0x057E, 0x2009, transport)) is None
    *handshake, vibration = pad.written
    assert [report[:2].hex() for report in handshake] == (
        ["8002", "8003", "8002", "8004"] if transport == "usb" else []
    )
    assert (vibration[0], vibration[10:12].hex()) == (1, "4801")
    assert {len(report) for report in pad.written} == {64 if transport == "usb" else 49}


def test_a_switch_pad_that_refuses_is_asked_again_and_then_driven_all_the_same():
    refused = bytes([0x21]) + bytes(12) + bytes([0x00, 0x48]) + bytes(49)
    pad = Pad({bytes([0x80, 2]): ACKNOWLEDGED[bytes([0x80, 2])], b"\x01": refused})
    assert prepared("switch-pro", pad, interface(0x057E, 0x2009)) is None
    assert [report[:2].hex() for report in pad.written] == [
        "8002",
        "8003",
        "8003",
        "8002",
        "8004",
        "0100",
        "0100",
    ]


@pytest.mark.parametrize(
    ("product", "pad", "rumbles"),
    [
        (0x6003, Pad(features={6: bytes([6, 1])}), True),
        (0x6003, Pad(), False),
        (0x6003, Pad(features={6: b""}), False),
        (0x202F, Pad(features={0x30: bytes([0x30, 0, 0, 1, 1])}), True),
        (0x202F, Pad(features={0x30: bytes([0x30, 0, 0, 0, 1])}), False),
        (0x202F, Pad(), True),
        (0x6012, Pad(inputs=[bytes(34)]), True),
        (0x6012, Pad(inputs=[b"", bytes(34)]), True),
        (0x6012, Pad(inputs=[bytes(12)]), False),
    ],
)
def test_an_8bitdo_pad_is_driven_only_if_it_says_that_it_rumbles(product, pad, rumbles):
    if rumbles:
        assert prepared("8bitdo", pad, interface(0x2DC8, product)) is None
    else:
        with pytest.raises(OSError, match=r"^Pad does not report that it can rumble"):
            prepared("8bitdo", pad, interface(0x2DC8, product))


@pytest.mark.parametrize(
    ("abilities", "rumbles"), [(0x01, True), (0xFF, True), (0xFE, False), (None, True)]
)
def test_an_sinput_pad_is_asked_for_its_features(abilities, rumbles):
    answers = (
        {} if abilities is None else {bytes([3, 2]): bytes([2, 2, 1, 0, abilities]) + bytes(59)}
    )
    pad = Pad(answers)
    if rumbles:
        assert prepared("sinput", pad, interface(0x2E8A, 0x10C6)) is None
    else:
        with pytest.raises(OSError, match=r"^Pad reports that it can't rumble"):
            prepared("sinput", pad, interface(0x2E8A, 0x10C6))
    assert pad.written == [bytes([3, 2]) + bytes(46)]


@pytest.mark.parametrize(
    ("vendor", "product"),
    [
        (0x2E8A, 0x10C6),
        (0x2E8A, 0x10DF),
        (0x2E8A, 0x10DD),
        (0x2E8A, 0x10E0),
        (0x2E8A, 0x10E5),
        (0x38D2, 0x1014),
    ],
)
def test_sinput_pads_are_those_that_sdl_knows(vendor, product):
    assert [found.name for found in families_of(interface(vendor, product))] == ["sinput"]
