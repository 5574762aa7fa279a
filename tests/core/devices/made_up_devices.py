"""Devices that Debian's umockdev makes up for the real ``hidraw`` module, whose nodes keep the
bytes."""

from dataclasses import dataclass, field
from pathlib import Path

GAMEPAD = bytes.fromhex("05010905a101c0")
KEYBOARD = bytes.fromhex("05010906a101c0")
VENDOR = bytes.fromhex("0600ff0901a101c0")


@dataclass
class Fake:
    """A HID device. bus: 3 USB, 5 Bluetooth. number: USB interface. features: feature reports the
    device answers. keeps: the node keeps what is written, in order; otherwise it is a terminal,
    which blocks when its buffer is full.
    """

    bus: int
    vendor: int
    product: int
    name: str
    number: int = -1
    serial: str = ""
    descriptor: bytes = GAMEPAD
    features: list[str] = field(default_factory=list)
    keeps: bool = True


DUALSENSE_USB = Fake(3, 0x054C, 0x0CE6, "DualSense Wireless Controller", number=3)
DUALSENSE_BT = Fake(5, 0x054C, 0x0CE6, "DualSense Wireless Controller", serial="a0:ab:51:00:00:01")
SWITCH_PRO_BT = Fake(5, 0x057E, 0x2009, "Pro Controller", serial="a0:ab:51:00:00:02")
SWITCH_PRO_USB = Fake(3, 0x057E, 0x2009, "Pro Controller", number=0)
XBOX_BT = Fake(5, 0x045E, 0x0B13, "Xbox Wireless Controller", serial="a0:ab:51:00:00:03")
STADIA_USB = Fake(3, 0x18D1, 0x9400, "Stadia Controller", number=0)
# 65 bytes of feature report are taken, whatever they are.
DECK = Fake(
    3,
    0x28DE,
    0x1205,
    "Steam Deck Controller",
    number=2,
    descriptor=VENDOR,
    features=["HIDIOCSFEATURE 65 " + "00" * 65],
)
STRANGER = Fake(3, 0x1234, 0xABCD, "Somebody's gamepad", number=0)


def describe(folder, fakes):
    """The files umockdev wants: sysfs and nodes in one, ioctls in one per node."""
    lines, ioctls = [], []
    for i, fake in enumerate(fakes):
        hid = f"{fake.bus:04X}:{fake.vendor:04X}:{fake.product:04X}.{i + 1:04X}"
        if fake.bus == 3:
            parent = f"/devices/pci0000:00/usb1/1-{i + 1}/1-{i + 1}:1.{fake.number}"
            lines += [f"P: {Path(parent).parent}", "E: SUBSYSTEM=usb", "E: DEVTYPE=usb_device"]
            lines += [
                f"A: idVendor={fake.vendor:04x}",
                f"A: idProduct={fake.product:04x}",
                "A: bcdDevice=0100",
            ]
            lines += [
                f"A: manufacturer={fake.name.split()[0]}",
                f"A: product={fake.name}",
                f"A: serial={fake.serial}",
                "",
            ]
            lines += [
                f"P: {parent}",
                "E: SUBSYSTEM=usb",
                "E: DEVTYPE=usb_interface",
                f"A: bInterfaceNumber={fake.number:02x}",
                "",
            ]
        else:
            parent = "/devices/virtual/misc/uhid"
        lines += [
            f"P: {parent}/{hid}",
            "E: SUBSYSTEM=hid",
            f"E: HID_ID={fake.bus:04X}:{fake.vendor:08X}:{fake.product:08X}",
        ]
        lines += [f"E: HID_NAME={fake.name}", "E: HID_PHYS=fake", f"E: HID_UNIQ={fake.serial}"]
        lines += [f"H: report_descriptor={fake.descriptor.hex()}", ""]
        # A node with content is a plain file.
        lines += [
            f"P: {parent}/{hid}/hidraw/hidraw{i}",
            f"N: hidraw{i}" + "=00" * fake.keeps,
            f"L: device=../../../{hid}",
        ]
        lines += [
            f"E: DEVNAME=/dev/hidraw{i}",
            "E: SUBSYSTEM=hidraw",
            "E: MAJOR=240",
            f"E: MINOR={i}",
            "",
        ]
        size = len(fake.descriptor).to_bytes(4, "little")
        answers = [f"@DEV /dev/hidraw{i}", f"HIDIOCGRDESCSIZE 0 {size.hex()}"]
        answers += [
            f"HIDIOCGRDESC 0 {(size + fake.descriptor.ljust(4096, bytes(1))).hex()}",
            *fake.features,
        ]
        file = folder / f"{i}.ioctl"
        file.write_text("\n".join(answers) + "\n")
        ioctls += ["-i", f"/dev/hidraw{i}={file}"]
    (folder / "devices.umockdev").write_text("\n".join(lines))
    return ["-d", str(folder / "devices.umockdev"), *ioctls]
