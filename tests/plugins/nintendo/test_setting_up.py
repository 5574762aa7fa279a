"""What is said to a pad once, when it is opened, and what its answers change: pads that answer as
SDL's drivers expect it."""

import pytest
from answering_pad import Pad, interface, prepared

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
