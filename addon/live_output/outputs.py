"""The devices that were found and those that are driven. Plain Python: nothing of it is saved, and no thread touches Blender."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from numpy.typing import ArrayLike

from ...core.devices.mapping import ActuatedDevice
from ...core.devices.network import PlayerModule
from ...core.devices.output import Status
from ...core.devices.profiles import Adjustment, Profile


class Output(Protocol):
    """A device that is driven: `DeviceOutput` and `SoundCardOutput` are such."""

    @property
    def profile(self) -> ActuatedDevice: ...
    @property
    def status(self) -> Status: ...
    def start(self) -> None: ...
    def adjust(self, adjustment: Adjustment) -> None: ...
    def send(self, block: ArrayLike) -> None: ...
    def silence(self) -> None: ...
    def rest(self) -> None: ...
    def request_stop(self) -> None: ...
    def stop(self, timeout: float = 1.0) -> bool: ...


@dataclass(frozen=True, slots=True)
class Found:
    """A device that can be driven.

    key: its name in settings. kind: how it is connected, for people. permission: why this user may not open it, or empty; rule: the line
    for udev that would let them, if that is all. open: makes the output, not started.
    """

    key: str
    title: str
    kind: str
    device: ActuatedDevice
    permission: str
    rule: str
    open: Callable[[Adjustment], Output]


@dataclass(frozen=True, slots=True)
class Inventory:
    """What a look for devices found. strangers: gamepads that nothing here can drive. problems: one line each."""

    devices: tuple[Found, ...] = ()
    strangers: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


_inventory: Inventory | None = None
_finder: threading.Thread | None = None
_running: dict[str, Output] = {}
_titles: dict[str, Found] = {}
_version = 0


def version() -> int:
    """A number that changes with the set of driven devices."""
    return _version


def inventory() -> Inventory | None:
    """What was found last; None before the first look."""
    return _inventory


def is_finding() -> bool:
    """True while a look for devices goes on."""
    return _finder is not None and _finder.is_alive()


def find(folders: tuple[Path, ...] = (), sound_cards: bool = False, players: bool = False) -> None:
    """Look for devices, in the background: some systems take their time. ``folders``: of device profiles of the user's own."""
    global _finder
    if not is_finding():
        _finder = threading.Thread(target=_find, args=(folders, sound_cards, players), name="haptics find devices", daemon=True)
        _finder.start()


def wait_until_found(timeout: float = 5.0) -> None:
    """Wait for the look that goes on."""
    if _finder is not None:
        _finder.join(timeout)


def running() -> dict[str, Output]:
    """The driven devices by key."""
    return _running


def found(key: str) -> Found | None:
    """A found or driven device by its key."""
    if key in _titles:
        return _titles[key]
    return next((device for device in (_inventory or Inventory()).devices if device.key == key), None)


def preferred(part: str) -> str:
    """The key of the first found device whose name has ``part`` in it, of the first device where none has; "" where none was found."""
    devices = (_inventory or Inventory()).devices
    wanted = [device.key for device in devices if part.lower() in f"{device.key} {device.title}".lower()]
    return next(iter([*wanted, *(device.key for device in devices)]), "")


def connect(key: str, adjustment: Adjustment) -> None:
    """Drive a found device from now on. Raises ValueError if it is unknown."""
    global _version
    device = found(key)
    if device is None:
        raise ValueError(f"device {key!r} is not connected")
    if key not in _running:
        output = device.open(adjustment)
        output.start()
        _running[key], _titles[key] = output, device
        _version += 1


def disconnect(key: str) -> None:
    """Zero, release and close a device, without waiting for it."""
    global _version
    output = _running.pop(key, None)
    _titles.pop(key, None)
    if output is not None:
        output.request_stop()
        _version += 1


def rest() -> None:
    """All devices to zero, then release. Never blocks."""
    for output in _running.values():
        output.rest()


def silence() -> None:
    """All devices to zero. Never blocks."""
    for output in _running.values():
        output.silence()


def disconnect_all() -> None:
    """All devices to zero, released and closed, without waiting for them."""
    for key in tuple(_running):
        disconnect(key)


def stop_all(timeout: float = 1.0) -> bool:
    """The same, and wait up to ``timeout`` seconds. Returns whether all are done."""
    from ...core.devices import output

    stopping = tuple(_running.values())
    disconnect_all()
    wait_until_found(timeout)
    return output.stop_all(timeout) and all(item.stop(timeout) for item in stopping)


def forget() -> None:
    """Forget what was found."""
    global _inventory
    _inventory = None


def _find(folders: tuple[Path, ...], with_sound_cards: bool, with_players: bool) -> None:
    """The thread of a look."""
    global _inventory
    from ...core.devices.connection import connected, hid_module
    from ...core.devices.profiles import BUILT_IN, load_profiles

    profiles, problems = load_profiles((BUILT_IN, *(folder for folder in folders if folder.is_dir())))
    devices: list[Found] = []
    strangers: list[str] = []
    try:
        for device in connected(hid_module()):
            names = {family.name for family in device.families}
            matching = [profile for profile in profiles.values() if profile.family.name in names]
            devices += [_hid_device(profile, device) for profile in matching]
            if not matching:
                strangers.append(device.title or f"{device.vendor:04x}:{device.product:04x}")
    except OSError as error:
        problems = (*problems, str(error))
    if with_sound_cards:
        try:
            devices += _sound_cards()
        except OSError as error:
            problems = (*problems, str(error))
    if with_players:
        for look in (_bhaptics, _intiface):
            try:
                devices += look()
            except OSError as error:
                problems = (*problems, str(error))
    _inventory = Inventory(_with_unique_keys(devices), tuple(strangers), problems)


def _hid_device(profile: Profile, device: object) -> Found:
    from ...core.devices.connection import Connected, missing_permission, udev_rule
    from ...core.devices.output import DeviceOutput

    assert isinstance(device, Connected)
    problem, rule = "", ""
    for interface in device.interfaces:
        problem = problem or missing_permission(interface) or ""
        rule = udev_rule(interface) if udev_rule(interface) in problem else rule
    return Found(
        key=" ".join(filter(None, (profile.name, device.serial))),
        title=profile.title,
        kind={"usb": "USB", "bt": "Bluetooth"}[device.transport] + (", experimental" if profile.experimental else ""),
        device=profile,
        permission=problem,
        rule=rule,
        open=lambda adjustment: DeviceOutput(profile, serial=device.serial, adjustment=adjustment),
    )


def _sound_cards() -> list[Found]:
    from ...core.devices.sound_card import SoundCard, SoundCardOutput, sound_cards, sound_module

    def found(card: SoundCard) -> Found:
        return Found(
            key=f"sound card {card.title}",
            title=card.title,
            kind=f"sound card, {card.channels} channels",
            device=card,
            permission="",
            rule="",
            open=lambda adjustment: SoundCardOutput(card, adjustment=adjustment),
        )

    return [found(card) for card in sound_cards(sound_module())]


def _bhaptics() -> list[Found]:
    from ...core.devices.network import bhaptics

    return [_player_device(*bhaptics())]


def _intiface() -> list[Found]:
    from ...core.devices.network import intiface

    return [_player_device(profile, module) for profile, module in intiface()]


def _player_device(profile: Profile, module: PlayerModule) -> Found:
    from ...core.devices.output import DeviceOutput

    return Found(
        key=f"player {profile.title}",
        title=profile.title,
        kind="haptic player",
        device=profile,
        permission="",
        rule="",
        open=lambda adjustment: DeviceOutput(profile, adjustment=adjustment, hid=module),
    )


def _with_unique_keys(devices: list[Found]) -> tuple[Found, ...]:
    """Devices alike without a serial number are numbered."""
    from dataclasses import replace

    seen: dict[str, int] = {}
    unique = []
    for device in devices:
        seen[device.key] = number = seen.get(device.key, 0) + 1
        unique.append(device if number == 1 else replace(device, key=f"{device.key} #{number}", title=f"{device.title} {number}"))
    return tuple(unique)
