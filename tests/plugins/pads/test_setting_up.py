"""What is said to a pad once, when it is opened, and what its answers change: pads that answer as
SDL's drivers expect it."""

import pytest
from answering_pad import Pad, interface, prepared
from haptic_tracing.core.devices.families.registry import families_of


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
