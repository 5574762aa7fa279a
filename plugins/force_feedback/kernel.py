"""The Linux kernel's force feedback, for gamepads that cannot be opened as HID devices or are not
HID devices (an Xbox pad on a cable).

The kernel's driver implements the pad's protocol; an event device takes the amplitudes of two
motors. Effects end with the process that holds the device, and each after half a second. Constants
and layouts are those of ``linux/input.h``.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from ...core.devices.connection import StandInModule
from ...core.devices.families.family import HidDevice, Interface, RumbleFamily, any_interface
from ...core.devices.report import Report, Tones, Transport, unsigned16

_SYSTEM = Path("/sys/class/input")
_RUMBLE_BIT = 0x50
_EV_FF = 0x15
_SYSTEM_BUS_BLUETOOTH = 0x0005
# struct ff_effect: type, id, direction, trigger (two), replay length and delay in ms, padding,
# strong and weak magnitude; 48 bytes where pointers have 8, as the last member of its union holds
# one.
_EFFECT = struct.Struct("@HhHHHHH2xHH")
_EFFECT_SIZE = 48 if struct.calcsize("P") == 8 else 44
_EVENT = struct.Struct("@llHHi")
_LENGTH = 500  # ms
_UPLOAD = 1 << 30 | _EFFECT_SIZE << 16 | ord("E") << 8 | 0x80  # EVIOCSFF


def event_nodes(system: Path = _SYSTEM) -> tuple[Interface, ...]:
    """The event devices that support rumble, by path; none on systems other than Linux."""
    if not sys.platform.startswith("linux") or not system.is_dir():
        return ()
    found = []
    for folder in sorted(system.glob("event*")):
        device = folder / "device"
        with suppress(OSError, ValueError):  # it may be unplugged meanwhile
            if _takes_rumble((device / "capabilities" / "ff").read_text()):
                found.append(_node(folder.name, device))
    return tuple(found)


def _takes_rumble(capabilities: str) -> bool:
    """capabilities: words of hexadecimal as long as a C long, the last holding the lowest bits."""
    bits = 8 * struct.calcsize("l")
    value = sum(
        int(word, 16) << bits * place for place, word in enumerate(reversed(capabilities.split()))
    )
    return bool(value >> _RUMBLE_BIT & 1)


def _node(name: str, device: Path) -> Interface:
    vendor, product, bus = (
        int((device / "id" / key).read_text(), 16) for key in ("vendor", "product", "bustype")
    )
    title, serial = (
        (device / key).read_text().strip() if (device / key).exists() else ""
        for key in ("name", "uniq")
    )
    transport: Transport = "bt" if bus == _SYSTEM_BUS_BLUETOOTH else "usb"
    return Interface(
        f"/dev/input/{name}".encode(), vendor, product, serial, title, 0, 0, -1, transport
    )


class ForceFeedbackModule(StandInModule):
    """Replacement for hidapi's module with one event device, while it is connected."""

    __slots__ = ()

    def __init__(self, node: Interface) -> None:
        super().__init__(replace(node, vendor=0, product=0), _EventDevice)

    def enumerate(self) -> Iterable[Interface]:
        return [self.interface] if os.access(self.interface.path, os.F_OK) else []


class _EventDevice(HidDevice):
    """An event device. A report contains the amplitudes of the strong and the weak motor."""

    def __init__(self) -> None:
        super().__init__()
        self._file = self._effect = -1

    def open_path(self, path: bytes) -> None:
        self._file = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        self._effect = -1

    def take(self, data: bytes) -> None:
        strong, weak = struct.unpack("<HH", data)
        if strong or weak:
            self._upload(strong, weak)
        if self._effect >= 0:
            os.write(
                self._file, _EVENT.pack(0, 0, _EV_FF, self._effect, 1 if strong or weak else 0)
            )

    def _upload(self, strong: int, weak: int) -> None:
        import fcntl

        effect = bytearray(
            _EFFECT.pack(_RUMBLE_BIT, self._effect, 0, 0, 0, _LENGTH, 0, strong, weak).ljust(
                _EFFECT_SIZE, b"\0"
            )
        )
        fcntl.ioctl(self._file, _UPLOAD, effect)
        self._effect = _EFFECT.unpack_from(effect)[1]

    def close(self) -> None:
        """Close the device: the kernel erases its effects."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned16, drive.amplitudes)
    return Report(struct.pack("<HH", left, right))


FORCE_FEEDBACK = RumbleFamily(
    name="force-feedback",
    title="Gamepad (kernel)",
    ids=frozenset({(0, 0)}),
    minimum_interval={"usb": 0.010, "bt": 0.050},
    refresh_interval=0.250,
    picks=any_interface,
    encode=_encode,
)
