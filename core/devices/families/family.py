"""Device families: how devices are recognised, commanded, stopped and released."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...forms import Form
from ...frozen import frozen
from ..report import Report, Tones, Transport, levels

BUS_USB = 1
BUS_BLUETOOTH = 2

_HIDAPI_KEYS = {
    "path": "path",
    "vendor": "vendor_id",
    "product": "product_id",
    "usage_page": "usage_page",
    "usage": "usage",
}

RESEND = 2.0
"""Seconds after which a steady drive is sent again, as SDL does: so that a stop by another program
lasts at most that long."""


@frozen
class Interface:
    """One entry of hidapi's ``enumerate``.

    path: for ``open_path``. number: USB interface, -1 if none. serial: may be empty; the MAC
    address over Bluetooth.
    """

    path: bytes
    vendor: int
    product: int
    serial: str
    title: str
    usage_page: int
    usage: int
    number: int
    transport: Transport

    @property
    def label(self) -> str:
        """The title, or the numbers without one."""
        return self.title or f"{self.vendor:04x}:{self.product:04x}"

    @classmethod
    def of(cls, entry: Form) -> Interface:
        """From hidapi's dictionary. If the bus is unknown, interfaces with a number are USB."""
        bus = int(entry.get("bus_type") or 0)
        number = int(entry["interface_number"])
        usb = bus == BUS_USB or (bus != BUS_BLUETOOTH and number >= 0)
        values = {name: entry[key] for name, key in _HIDAPI_KEYS.items()}
        serial = entry.get("serial_number") or ""
        title = entry.get("product_string") or ""
        return cls(
            **values, serial=serial, title=title, number=number, transport="usb" if usb else "bt"
        )


class HidDevice(ABC):
    """The part of hidapi's ``device`` that is used, for replacements that handle reports by other
    means and send no input."""

    def __init__(self) -> None:
        self._error = ""

    @abstractmethod
    def open_path(self, path: bytes) -> None: ...

    @abstractmethod
    def take(self, data: bytes) -> None:
        """Send a report. Raises OSError if it does not arrive."""

    @abstractmethod
    def close(self) -> None: ...

    def write(self, data: bytes) -> int:
        try:
            self.take(data)
        except OSError as error:
            self._error = str(error)
            return -1
        return len(data)

    send_feature_report = write

    def get_feature_report(self, report: int, length: int) -> list[int]:
        return []

    def read(self, length: int, timeout_ms: int) -> list[int]:
        return []

    def error(self) -> str:
        return self._error


def is_gamepad(interface: Interface) -> bool:
    """The top-level collection of a joystick or gamepad (generic desktop page)."""
    return interface.usage_page == 0x01 and interface.usage in (0x04, 0x05)


def any_interface(interface: Interface) -> bool:
    """Any interface, for devices that are not found by it."""
    return True


def is_vendor_defined(interface: Interface) -> bool:
    """A top-level collection on a vendor's own usage page."""
    return interface.usage_page >= 0xFF00


def nothing(transport: Transport, sequence: int) -> tuple[Report, ...]:
    """No reports: for families that need no start-up or release."""
    return ()


class Prepare(Protocol):
    """Sets up an opened device. ``write`` sends a report and returns whether the device accepted
    it.

    Returns the family to use (older firmware may need other reports), or None for the same one.
    Raises OSError with the reason if the device cannot be driven.
    """

    def __call__(
        self, device: HidDevice, interface: Interface, write: Callable[[Report], bool]
    ) -> AnyFamily | None: ...


def answer_of(
    device: HidDevice, is_answer: Callable[[bytes], bool], seconds: float = 0.1
) -> bytes | None:
    """The first input report that ``is_answer`` accepts; None if there is none in time."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        report = bytes(device.read(64, max(round(1000 * left), 1)))
        if is_answer(report):
            return report
        if not report:
            time.sleep(0.001)  # a node without a device behind it returns at once
    return None


@frozen(kw_only=True)
class Family:
    """The common fields of rumble and stream families.

    name: key in the registry and on the command line. ids: (vendor, product) numbers. channels:
    names of the values of a drive, in order. minimum_interval: least seconds from the end of one
    report to the next, by supported transport, the default first. refresh_interval: seconds after
    which an unchanged non-zero drive is sent again. picks: predicate of the interface to open.
    probe_input: of several such interfaces, open the one that emits input within 16 ms. prepare:
    sets up a device once after it was opened; called in the writer's thread. startup: reports
    before the first block and before the first one after a pause; (transport, sequence of the
    first) -> reports. release: reports after zero, at a pause and at the end. farewell: reports
    after those, at the end alone. zero_repeats: number of times that zero is sent before reports
    cease.
    """

    name: str
    title: str
    ids: frozenset[tuple[int, int]]
    minimum_interval: Mapping[Transport, float]
    channels: tuple[str, ...] = ("left", "right")
    refresh_interval: float = RESEND
    picks: Callable[[Interface], bool] = is_gamepad
    probe_input: bool = False
    prepare: Prepare | None = None
    startup: Callable[[Transport, int], tuple[Report, ...]] = nothing
    release: Callable[[Transport, int], tuple[Report, ...]] = nothing
    farewell: Callable[[Transport, int], tuple[Report, ...]] = nothing
    zero_repeats: int = 1

    @property
    def transports(self) -> tuple[Transport, ...]:
        """The supported transports, the default first."""
        return tuple(self.minimum_interval)

    def matches(self, interface: Interface) -> bool:
        """Whether this is a device of the family, on a supported transport and interface."""
        known = (interface.vendor, interface.product) in self.ids
        return known and interface.transport in self.transports and self.picks(interface)


@frozen(kw_only=True)
class RumbleFamily(Family):
    """Devices commanded by amplitude, with or without a frequency.

    encode: (drive, transport, sequence) -> report; raises ValueError for an amplitude outside [0,
    1]. rumble: the drive for a classic pair (left or low-frequency, right or high-frequency motor).
    has_tones: channels take a frequency.
    """

    encode: Callable[[Tones, Transport, int], Report]
    rumble: Callable[[float, float], Tones] = levels
    has_tones: bool = False

    def silence(self) -> Tones:
        """The drive of all channels at rest."""
        return self.rumble(0.0, 0.0)


@frozen(kw_only=True)
class StreamFamily(Family):
    """Devices driven by samples.

    rate: frames per second. frames: frames in one report.
    encode: (samples int8 of shape (channels, frames), sequence) -> report.
    """

    rate: int
    frames: int
    encode: Callable[[NDArray[np.int8], int], Report]

    @property
    def period(self) -> float:
        """Duration of one report [s]."""
        return self.frames / self.rate


AnyFamily = RumbleFamily | StreamFamily
