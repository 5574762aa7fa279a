"""Which of a Steam Deck's interfaces is opened."""

from fake_hid import FakeHid, FakePad
from haptic_tracing.core.devices.connection import connected, open_device
from haptic_tracing.core.devices.families.registry import family


def test_of_interfaces_alike_the_one_that_emits_input_is_opened():
    pads = [
        FakePad(f"/dev/{i}".encode(), vendor=0x28DE, product=0x1205, number=i, usage=(0xFF00, 1))
        for i in range(3)
    ]
    pads[1].input = [1, 2, 3]
    hid = FakeHid(*pads)
    assert len(connected(hid)) == 1 and len(connected(hid)[0].interfaces) == 3
    opened = open_device(hid, family("steam-deck"))
    assert opened.interface.path == b"/dev/1"
    opened.close()
    assert all(pad.opened == pad.closed for pad in pads)
