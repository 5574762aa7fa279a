"""Haptic players on this computer: bHaptics Player (vests, sleeves, gloves) and Intiface (Buttplug
protocol, version 3).

A connection replaces a HID device: `DeviceOutput` drives both with the same intervals, limits,
watchdog, zero and release.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path

from ...core.devices.connection import DeviceError, StandInModule
from ...core.devices.families.family import RESEND, RumbleFamily, any_interface
from ...core.devices.profiles import Actuator, Calibration, DriveChannel, Profile
from ...core.devices.report import Report, Tones, Transport
from ...core.formats.io.error import FormatError
from ...core.formats.io.schema import validate
from ...core.forms import Form, JsonObject
from ...core.scene.body import BODY_PARTS
from ..bhaptics.motors import DEVICES, region
from .loopback import Connection, Player, cancel, player_module

__all__ = ["SEARCHES", "cancel"]

BHAPTICS = "ws://127.0.0.1:15881/v2/feedbacks?app_id=haptic-tracing&app_name=Haptic%20Tracing"
INTIFACE = "ws://127.0.0.1:12345"

_SCHEMA = Path(__file__).with_name("intiface.schema.json")
_INTERVAL = 0.05
# Number of pings within the server's time-out, after which it stops its devices; two of them may be
# late.
_PINGS_IN_TIME = 3
_SHORTEST_PING = 10.0
_PING = json.dumps([{"Ping": {"Id": 2}}])
# Duration of a frame, after which the vest is silent if the program hangs.
_FRAME_MILLISECONDS = 100
_TAKES = (10.0, 1000.0)
_MOTORS = tuple(
    (position, index)
    for device in DEVICES.values()
    for position, places in device.items()
    for index in range(len(places))
)


def bhaptics(url: str = BHAPTICS) -> tuple[Profile, StandInModule]:
    """bHaptics Player: every motor is an actuator. Raises DeviceError if it does not run."""
    Connection(url).close()
    names = [f"{position} {index + 1}" for position, index in _MOTORS]
    family = _family(
        "bhaptics", "bHaptics Player", names, _encode_bhaptics, _release_bhaptics, refresh=0.06
    )
    places = {
        position: places for device in DEVICES.values() for position, places in device.items()
    }
    felt = [
        tuple(
            part.name
            for part in BODY_PARTS
            if part.bhaptics == position and index in region(part, places[position])
        )
        for position, index in _MOTORS
    ]
    profile = _profile(
        family,
        dict(zip(names, felt, strict=True)),
        [places[position][index] for position, index in _MOTORS],
    )
    return profile, player_module(Player(url, _no_greeting, b"turnOffAll"), family.name)


def _no_greeting(connection: Connection) -> None:
    """bHaptics Player knows the program from the address."""


def _encode_bhaptics(drive: Tones, transport: Transport, sequence: int) -> Report:
    frames: dict[str, list[dict[str, int]]] = {}
    for amplitude, (position, index) in zip(drive.amplitudes, _MOTORS, strict=True):
        frames.setdefault(position, []).append(
            {"Index": index, "Intensity": round(100 * amplitude)}
        )
    submits = [
        {
            "Type": "frame",
            "Key": f"haptic-tracing {position}",
            "Frame": {
                "Position": position,
                "DotPoints": points,
                "DurationMillis": _FRAME_MILLISECONDS,
            },
        }
        for position, points in frames.items()
    ]
    return Report(json.dumps({"Submit": submits}).encode())


def _release_bhaptics(transport: Transport, sequence: int) -> tuple[Report, ...]:
    return (Report(json.dumps({"Submit": [{"Type": "turnOffAll"}]}).encode()),)


def intiface(url: str = INTIFACE) -> tuple[tuple[Profile, StandInModule], ...]:
    """The devices of Intiface: every motor is an actuator without a body part. Raises DeviceError
    if it does not run."""
    player = Player(url, _greet, b"StopDeviceCmd")
    connection = player.open()
    try:
        listed = connection.ask({"RequestDeviceList": {"Id": 2}}, "DeviceList")
    finally:
        player.close(connection)
    return devices_of(player, listed)


def devices_of(player: Player, listed: JsonObject) -> tuple[tuple[Profile, StandInModule], ...]:
    """The devices with motors in Intiface's DeviceList. Raises DeviceError where it is
    malformed."""
    devices = _checked(listed, "DeviceList")["Devices"]
    return tuple(_intiface_device(player, device) for device in devices if _motors(device))


def _greet(connection: Connection) -> None:
    """Introduce the program, and keep the connection alive at the server's interval. Raises
    DeviceError."""
    greeting = {"RequestServerInfo": {"Id": 1, "ClientName": "Haptic Tracing", "MessageVersion": 3}}
    seconds = ping_seconds(connection.ask(greeting, "ServerInfo"))
    if seconds is not None:
        connection.ping_every(seconds, _PING)


def ping_seconds(info: JsonObject) -> float | None:
    """Seconds between two pings that Intiface's ServerInfo asks for; None for no pings. Raises
    DeviceError where it is malformed."""
    milliseconds = _checked(info, "ServerInfo").get("MaxPingTime") or 0
    return max(milliseconds, _SHORTEST_PING) / 1000 / _PINGS_IN_TIME if milliseconds else None


def _checked(content: JsonObject, kind: str) -> JsonObject:
    """A message of Intiface as ``intiface.schema.json`` defines it. Raises DeviceError with the
    place of a fault."""
    try:
        validate({kind: content}, _SCHEMA, "Intiface")
    except FormatError as error:
        raise DeviceError(str(error)) from None
    return content


def _motors(device: Form) -> list[int]:
    commands = device["DeviceMessages"].get("ScalarCmd", [])
    return [
        number
        for number, command in enumerate(commands)
        if command.get("ActuatorType") == "Vibrate"
    ]


def _intiface_device(player: Player, device: Form) -> tuple[Profile, StandInModule]:
    index = int(device["DeviceIndex"])
    motors = _motors(device)
    names = [f"motor {number + 1}" for number in range(len(motors))]
    gap = max((device.get("DeviceMessageTimingGap") or 0) / 1000, _INTERVAL)
    encode = partial(_encode_intiface, index, motors)
    release = partial(_release_intiface, index)
    family = _family(
        f"intiface {index}", device["DeviceName"], names, encode, release, interval=gap
    )
    return _profile(family, dict.fromkeys(names, ())), player_module(player, family.name)


def _encode_intiface(
    index: int, motors: Sequence[int], drive: Tones, transport: Transport, sequence: int
) -> Report:
    """The message that drives the motors of a device of Intiface.

    Args:
        index: of the device.
        motors: their indices.
        drive: an amplitude for each motor.
        transport: without an effect.
        sequence: number of the report; gives the message its id.
    """
    scalars = [
        {"Index": motor, "Scalar": round(amplitude, 3), "ActuatorType": "Vibrate"}
        for motor, amplitude in zip(motors, drive.amplitudes, strict=True)
    ]
    return Report(
        json.dumps(
            [{"ScalarCmd": {"Id": 3 + sequence, "DeviceIndex": index, "Scalars": scalars}}]
        ).encode()
    )


def _release_intiface(index: int, transport: Transport, sequence: int) -> tuple[Report, ...]:
    return (
        Report(
            json.dumps([{"StopDeviceCmd": {"Id": 3 + sequence, "DeviceIndex": index}}]).encode()
        ),
    )


def _alike(count: int, left: float, right: float) -> Tones:
    """A classic pair on motors without sides."""
    return Tones((left,) * count, (0.0,) * count)


def _family(
    name: str,
    title: str,
    channels: Sequence[str],
    encode: Callable[[Tones, Transport, int], Report],
    release: Callable[[Transport, int], tuple[Report, ...]],
    *,
    interval: float = _INTERVAL,
    refresh: float = RESEND,
) -> RumbleFamily:
    """A family of devices that a program in the network drives.

    Args:
        name: for users and files.
        title: for menus.
        channels: names of its motors.
        encode: makes the report for a drive.
        release: makes the reports that stop the device.
        interval: least seconds between two reports.
        refresh: seconds after which an unchanged drive is sent again.
    """
    return RumbleFamily(
        name=name,
        title=title,
        ids=frozenset({(0, 0)}),
        channels=tuple(channels),
        minimum_interval={"usb": interval},
        refresh_interval=refresh,
        picks=any_interface,
        release=release,
        encode=encode,
        rumble=partial(_alike, len(channels)),
    )


def _profile(
    family: RumbleFamily,
    parts: Mapping[str, tuple[str, ...]],
    positions: Iterable[tuple[float, float] | None] = itertools.repeat(None),
) -> Profile:
    """The profile of a device of unmeasured motors; ``parts``: body parts by name of the motor."""
    actuators = tuple(
        Actuator(
            name,
            places,
            "ERM",
            (30.0, 250.0),
            0.05,
            1.0,
            (DriveChannel(name, _TAKES),),
            Calibration(),
            position=position,
        )
        for (name, places), position in zip(parts.items(), positions, strict=False)
    )
    return Profile(family.name, family.title, family, True, None, 20.0, 0.7, 10.0, actuators)


SEARCHES: tuple[Callable[[], Iterable[tuple[Profile, StandInModule]]], ...] = (
    lambda: (bhaptics(),),
    intiface,
)
"""Each finds the devices of a player, or raises DeviceError."""
