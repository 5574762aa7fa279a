"""Looking for everything that can be driven: HID devices, sound cards and haptic players."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from .connection import Connected, connected, hid_module, missing_permission, udev_rule
from .loopback import PlayerModule
from .mapping import ActuatedDevice
from .network import bhaptics, intiface
from .output import DeviceOutput, SoundCardOutput
from .profiles import BUILT_IN, Adjustment, Profile, load_profiles
from .sound_card import SoundCard, sound_cards, sound_module
from .status import Output


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
    open: Callable[[Adjustment], Output]
    permission: str = ""
    rule: str = ""


@dataclass(frozen=True, slots=True)
class Inventory:
    """What a look for devices found. strangers: gamepads that nothing here can drive. problems: one line each."""

    devices: tuple[Found, ...] = ()
    strangers: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


def look(folders: Iterable[Path] = (), *, with_sound_cards: bool = False, with_players: bool = False) -> Inventory:
    """Look for devices. A part that fails is a problem, and the others are looked for all the same.

    folders: of device profiles of the user's own.
    """
    profiles, problems = load_profiles((BUILT_IN, *(folder for folder in folders if folder.is_dir())))
    strangers: list[str] = []
    looks: list[Callable[[], Sequence[Found]]] = [partial(_hid_devices, profiles.values(), strangers)]
    if with_sound_cards:
        looks.append(_sound_cards)
    if with_players:
        looks += [_bhaptics, _intiface]
    devices: list[Found] = []
    for search in looks:
        try:
            devices += search()
        except OSError as error:
            problems = (*problems, str(error))
    return Inventory(_with_unique_keys(devices), tuple(strangers), problems)


def _hid_devices(profiles: Iterable[Profile], strangers: list[str]) -> list[Found]:
    found: list[Found] = []
    for device in connected(hid_module()):
        names = {family.name for family in device.families}
        matching = [profile for profile in profiles if profile.family.name in names]
        found += [_hid_device(profile, device) for profile in matching]
        if not matching:
            strangers.append(device.title or f"{device.vendor:04x}:{device.product:04x}")
    return found


def _hid_device(profile: Profile, device: Connected) -> Found:
    problem, rule = "", ""
    for interface in device.interfaces:
        problem = problem or missing_permission(interface) or ""
        rule = udev_rule(interface) if udev_rule(interface) in problem else rule
    return Found(
        key=" ".join(filter(None, (profile.name, device.serial))),
        title=profile.title,
        kind={"usb": "USB", "bt": "Bluetooth"}[device.transport] + (", experimental" if profile.experimental else ""),
        device=profile,
        open=lambda adjustment: DeviceOutput(profile, serial=device.serial, adjustment=adjustment),
        permission=problem,
        rule=rule,
    )


def _sound_cards() -> list[Found]:
    return [_sound_card(card) for card in sound_cards(sound_module())]


def _sound_card(card: SoundCard) -> Found:
    return Found(
        key=f"sound card {card.title}",
        title=card.title,
        kind=f"sound card, {card.channels} channels",
        device=card,
        open=lambda adjustment: SoundCardOutput(card, adjustment=adjustment),
    )


def _bhaptics() -> list[Found]:
    return [_player_device(*bhaptics())]


def _intiface() -> list[Found]:
    return [_player_device(profile, module) for profile, module in intiface()]


def _player_device(profile: Profile, module: PlayerModule) -> Found:
    return Found(
        key=f"player {profile.title}",
        title=profile.title,
        kind="haptic player",
        device=profile,
        open=lambda adjustment: DeviceOutput(profile, adjustment=adjustment, hid=module),
    )


def _with_unique_keys(devices: list[Found]) -> tuple[Found, ...]:
    """Devices alike without a serial number are numbered."""
    seen: dict[str, int] = {}
    unique = []
    for device in devices:
        seen[device.key] = number = seen.get(device.key, 0) + 1
        unique.append(device if number == 1 else replace(device, key=f"{device.key} #{number}", title=f"{device.title} {number}"))
    return tuple(unique)
