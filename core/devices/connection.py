"""Search for devices and opening of devices through hidapi, with one line for a failure."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

from ..forms import Form
from ..frozen import frozen
from .families.family import AnyFamily, HidDevice, Interface, is_gamepad
from .families.registry import families_of

UDEV_FILE = "/etc/udev/rules.d/70-haptic-tracing.rules"

# hidapi wants enumerate, open and close from one thread at a time.
_hidapi = threading.Lock()
_held: set[bytes] = set()
_INPUT_WITHIN_MS = 16


class DeviceError(OSError):
    """A device is unavailable; the text gives the reason in one line."""


class DeviceInUse(DeviceError):
    """Another output of this process has opened the device."""


def carried_module(name: str, needed_by: str) -> Any:
    """A module of a package that is part of the extension. Raises DeviceError with instructions if
    it is missing."""
    try:
        return import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        reason = (
            f"{needed_by} need the Python package {package}, which is part of the "
            "extension: install the extension from its zip"
        )
        raise DeviceError(reason) from None


class HidModule(Protocol):
    """The part of cython-hidapi's module that is used. A replacement may enumerate interfaces
    instead of dictionaries."""

    def enumerate(self) -> Iterable[Form | Interface]: ...
    def device(self) -> HidDevice: ...


def hid_module() -> HidModule:
    """cython-hidapi: on Linux its ``hidraw`` module (its ``hid`` sees no Bluetooth and takes pads
    away from games), else ``hid``.

    Raises DeviceError if it is missing, or if another package of the same name is installed
    instead.
    """
    name = "hidraw" if sys.platform.startswith("linux") else "hid"
    try:
        module: Any = import_module(name)
    except ImportError as error:
        raise DeviceError(f"the Python package hidapi can't be loaded: {error}") from None
    if not (hasattr(module, "device") and hasattr(module, "enumerate")):
        raise DeviceError(
            f"the Python module {name} is not that of the package hidapi: another package of the "
            "same name is installed"
        )
    found: HidModule = module
    return found


@frozen
class StandInModule:
    """Replacement for hidapi's module with one device, whether or not it is present. make: makes a
    `HidDevice` that is not open yet."""

    interface: Interface
    make: Callable[[], HidDevice]

    def enumerate(self) -> Iterable[Interface]:
        return [self.interface]

    def device(self) -> HidDevice:
        return self.make()


@frozen
class Connected:
    """A connected device: its possible interfaces, and the families that can drive it, the default
    first.

    families is empty for an unsupported gamepad.
    """

    interfaces: tuple[Interface, ...]
    families: tuple[AnyFamily, ...]

    @property
    def first(self) -> Interface:
        """The first interface, whose title, serial number and USB numbers stand for the device."""
        return self.interfaces[0]


def interfaces(hid: HidModule) -> tuple[Interface, ...]:
    """All HID interfaces, by path."""
    with _hidapi:
        entries = list(hid.enumerate())
    found = [entry if isinstance(entry, Interface) else Interface.of(entry) for entry in entries]
    return tuple(sorted(found, key=lambda interface: (interface.path, interface.usage)))


def connected(hid: HidModule) -> tuple[Connected, ...]:
    """The supported devices, and unsupported gamepads."""
    devices: dict[tuple[Any, ...], list[Interface]] = {}
    families: dict[tuple[Any, ...], tuple[AnyFamily, ...]] = {}
    for interface in interfaces(hid):
        matching = families_of(interface)
        if matching or is_gamepad(interface):
            # A device's interfaces share its serial number; without one, all interfaces of a family
            # with `probe_input` count as one device.
            alternative = bool(interface.serial) or any(family.probe_input for family in matching)
            place = b"" if alternative else interface.path
            key = (
                interface.vendor,
                interface.product,
                interface.serial,
                place,
                tuple(family.name for family in matching),
            )
            devices.setdefault(key, []).append(interface)
            families[key] = matching
    return tuple(Connected(tuple(group), families[key]) for key, group in devices.items())


@dataclass(slots=True)
class Opened:
    """An open device. ``close`` it from the thread that writes to it."""

    hid: HidDevice
    interface: Interface

    def close(self) -> None:
        """Close the device; it can be opened again afterwards."""
        with _hidapi:
            with suppress(OSError, ValueError):
                self.hid.close()
            _held.discard(self.interface.path)


def open_device(hid: HidModule, family: AnyFamily, serial: str = "") -> Opened:
    """Open the first device of the family that this process has not opened. serial: the one with
    this number, unless empty.

    Raises DeviceError with the reason.
    """
    # hidapi lists a path once per top-level collection.
    matching = {
        i.path: i for i in interfaces(hid) if family.matches(i) and serial in ("", i.serial)
    }
    if not matching:
        raise DeviceError(f"{family.title} is not connected")
    free = [interface for path, interface in matching.items() if path not in _held]
    if not free:
        raise DeviceInUse(f"{family.title} is already in use here")
    problem: DeviceError | None = None
    silent: Opened | None = None
    for interface in free:
        try:
            opened = _open(hid, interface)
        except DeviceError as error:
            problem = problem or error
            continue
        if len(free) == 1 or not family.probe_input or _emits_input(opened.hid):
            if silent is not None:
                silent.close()
            return opened
        if silent is None:
            silent = opened
        else:
            opened.close()
    if silent is not None:
        return silent
    raise problem or DeviceError(f"{family.title} is not connected")


def _open(hid: HidModule, interface: Interface) -> Opened:
    device = hid.device()
    with _hidapi:
        if interface.path in _held:
            raise DeviceInUse(f"{interface.title or 'device'} is already in use here")
        try:
            device.open_path(interface.path)
        except DeviceError:
            raise
        except (OSError, RuntimeError):
            raise DeviceError(open_failure(interface)) from None
        _held.add(interface.path)
    return Opened(device, interface)


def _emits_input(device: HidDevice) -> bool:
    with suppress(OSError):
        return bool(device.read(64, _INPUT_WITHIN_MS))
    return False


def udev_rule(interface: Interface) -> str:
    """The line for a udev rules file that lets the logged-in user write to the device.

    Bluetooth devices have no USB attributes; the kernel names them after bus, vendor and product in
    upper-case hexadecimal.
    """
    if interface.transport == "usb":
        match = (
            f'ATTRS{{idVendor}}=="{interface.vendor:04x}", '
            f'ATTRS{{idProduct}}=="{interface.product:04x}"'
        )
    else:
        match = f'KERNELS=="*{interface.vendor:04X}:{interface.product:04X}*"'
    return f'KERNEL=="hidraw*", {match}, MODE="0660", TAG+="uaccess"'


def missing_permission(interface: Interface) -> str | None:
    """Why this user may not open the interface (Linux), and the udev rule that lets them; None if
    they may, or if that is unknown."""
    if not sys.platform.startswith("linux"):
        return None
    name = interface.label
    path = os.fsdecode(interface.path)
    if os.access(path, os.R_OK | os.W_OK):
        return None
    if not os.access(path, os.F_OK):
        return f"{name}: {path} is gone, or a sandbox (Flatpak, Snap) hides it"
    return (
        f"{name}: no permission for {path}: put this line into {UDEV_FILE} and plug the "
        f"device in again: {udev_rule(interface)}"
    )


def open_failure(interface: Interface) -> str:
    """Why opening an interface failed, and what to do about it."""
    failure = (
        f"{interface.label} can't be opened: another program (Steam, a game, a remapper) "
        "holds it, or it was just disconnected"
    )
    return missing_permission(interface) or failure
