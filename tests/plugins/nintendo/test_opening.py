"""The interfaces of Joy-Con in the charging grip."""

from fake_hid import FakeHid, FakePad
from haptic_tracing.core.devices.connection import connected, open_device
from haptic_tracing.core.devices.families.registry import family


def test_the_grips_two_interfaces_are_two_joycons():
    left, right = (
        FakePad(f"/dev/{side}".encode(), 0x057E, 0x200E, number)
        for side, number in (("left", 1), ("right", 0))
    )
    hid = FakeHid(left, right)
    for name, path in (("joycon-left", b"/dev/left"), ("joycon-right", b"/dev/right")):
        opened = open_device(hid, family(name))
        assert opened.interface.path == path
        opened.close()
    assert {device.families[0].name for device in connected(hid)} == {"joycon-left", "joycon-right"}
