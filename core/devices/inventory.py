"""Search for all supported devices: HID devices, those of other drivers, sound cards and haptic
players."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import ModuleType

from ..frozen import frozen
from ..plugins import modules
from .connection import (
    Connected,
    StandInModule,
    connected,
    hid_module,
    missing_permission,
    udev_rule,
)
from .guard import DeviceOutput
from .mapping import ActuatedDevice
from .profile_files import load_profiles
from .profiles import Adjustment, Profile
from .sound_card import sound_cards, sound_module

BUS = {"usb": "USB", "bt": "Bluetooth"}
"""Names of transports."""


@frozen
class Found:
    """A device that can be driven.

    key: its name in settings. kind: description of its connection. permission: why this user may
    not open it, or empty; rule: the udev rule that permits it, if that suffices. open: creates the
    output without starting it.
    """

    key: str
    title: str
    kind: str
    device: ActuatedDevice
    open: Callable[[Adjustment], DeviceOutput]
    permission: str = ""
    rule: str = ""


@frozen
class Inventory:
    """Result of a search for devices. strangers: unsupported gamepads. problems: one line each."""

    devices: tuple[Found, ...] = ()
    strangers: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


def look(
    folders: Iterable[Path] = (), *, with_sound_cards: bool = False, with_players: bool = False
) -> Inventory:
    """Search for devices. The failure of one kind is reported as a problem and does not affect the
    others.

    folders: those with the user's device profiles.
    """
    profiles, problems = load_profiles(folders)
    gamepads: list[Connected] = []
    looks: list[Callable[[], Sequence[Found]]] = [
        partial(_hid_devices, tuple(profiles.values()), gamepads),
        *(
            partial(_driven_otherwise, driver, tuple(profiles.values()), gamepads)
            for driver in modules("drivers")
        ),
    ]
    if with_sound_cards:
        looks.append(_sound_cards)
    if with_players:
        looks += [
            partial(_players, find) for module in modules("players") for find in module.SEARCHES
        ]
    devices: list[Found] = []
    for search in looks:
        try:
            devices += search()
        except OSError as error:
            problems = (*problems, str(error))
    driven = {device.title for device in devices}
    others = [
        device
        for device in gamepads
        if not _matching(profiles.values(), device) and device.first.title not in driven
    ]
    strangers = tuple(device.first.label for device in others)
    return Inventory(_with_unique_keys(devices), strangers, problems)


def _matching(profiles: Iterable[Profile], device: Connected) -> list[Profile]:
    names = {family.name for family in device.families}
    return [profile for profile in profiles if profile.family.name in names]


def _hid_devices(profiles: Sequence[Profile], gamepads: list[Connected]) -> list[Found]:
    """The supported HID devices. All HID gamepads are added to ``gamepads``."""
    gamepads += connected(hid_module())
    return [
        _hid_device(profile, device)
        for device in gamepads
        for profile in _matching(profiles, device)
    ]


def _driven_otherwise(
    driver: ModuleType, profiles: Sequence[Profile], gamepads: Sequence[Connected]
) -> list[Found]:
    """The devices of a driver other than hidapi; ``gamepads`` are all HID gamepads."""
    drivable = [
        device
        for device in gamepads
        if _matching(profiles, device) and not all(map(missing_permission, device.interfaces))
    ]
    found: list[Found] = driver.devices(drivable)
    return found


def _hid_device(profile: Profile, device: Connected) -> Found:
    problem, rule = "", ""
    for interface in device.interfaces:
        problem = problem or missing_permission(interface) or ""
        rule = udev_rule(interface) if udev_rule(interface) in problem else rule
    return Found(
        key=" ".join(filter(None, (profile.name, device.first.serial))),
        title=profile.title,
        kind=BUS[device.first.transport] + (", experimental" if profile.experimental else ""),
        device=profile,
        open=partial(DeviceOutput, profile, serial=device.first.serial),
        permission=problem,
        rule=rule,
    )


def _sound_cards() -> list[Found]:
    return [
        Found(
            f"sound card {card.title}",
            card.title,
            f"sound card, {card.channels} channels",
            card,
            partial(DeviceOutput, card),
        )
        for card in sound_cards(sound_module())
    ]


def cancel() -> None:
    """Abandon the running search for players. Thread-safe."""
    for module in modules("players"):
        module.cancel()


def _players(look: Callable[[], Iterable[tuple[Profile, StandInModule]]]) -> list[Found]:
    return [
        Found(
            f"player {profile.title}",
            profile.title,
            "haptic player",
            profile,
            partial(DeviceOutput, profile, hid=module),
        )
        for profile, module in look()
    ]


def _with_unique_keys(devices: list[Found]) -> tuple[Found, ...]:
    """Number equal devices without a serial number."""
    seen: dict[str, int] = {}
    unique = []
    for device in devices:
        seen[device.key] = number = seen.get(device.key, 0) + 1
        unique.append(
            device
            if number == 1
            else replace(device, key=f"{device.key} #{number}", title=f"{device.title} {number}")
        )
    return tuple(unique)
