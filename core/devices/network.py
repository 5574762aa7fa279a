"""Haptic players on this computer that are spoken to over a WebSocket: bHaptics Player (vests, sleeves, gloves) and Intiface (Buttplug
protocol, version 3).

Only the loopback address is ever connected to. What is a HID device elsewhere is a connection here: `DeviceOutput` drives both, with the
same pace, limits, watchdog, zero and release. Needs the Python package websocket-client.
"""

from __future__ import annotations

import json
import math
import select
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from .connection import DeviceError
from .families.family import HidDevice, Interface, RumbleFamily
from .profiles import Actuator, Calibration, Channel, Profile
from .report import Report, Tones, Transport

BHAPTICS = "ws://127.0.0.1:15881/v2/feedbacks?app_id=haptic-tracing&app_name=Haptic%20Tracing"
INTIFACE = "ws://127.0.0.1:12345"

_ANSWER_WITHIN = 0.5
_INTERVAL = 0.05
# A server that hears no ping for a time that it says stops its devices: so many go out in that time, of which two may be late.
_PINGS_IN_TIME = 3
_SHORTEST_PING = 10.0
_PING = json.dumps([{"Ping": {"Id": 2}}])
# A frame lasts so long by itself: a program that hangs leaves the vest silent.
_FRAME_MILLISECONDS = 100
_TAKES = (10.0, 1000.0)
# What an actuator is called; its position and dots at bHaptics (five rows of four in either half of a vest); where it is felt.
_UPPER, _LOWER = (0, 1), (2, 3, 4)
_LEFT, _RIGHT = (0, 1), (2, 3)


def _dots(rows: Iterable[int], columns: Iterable[int]) -> tuple[int, ...]:
    return tuple(4 * row + column for row in rows for column in columns)


_PLACES: tuple[tuple[str, str, tuple[int, ...], tuple[str, ...]], ...] = (
    ("head", "Head", tuple(range(6)), ("head", "ear.L", "ear.R")),
    ("chest left", "VestFront", _dots(_UPPER, _LEFT), ("chest.L",)),
    ("chest right", "VestFront", _dots(_UPPER, _RIGHT), ("chest.R",)),
    ("belly", "VestFront", _dots(_LOWER, (*_LEFT, *_RIGHT)), ("belly",)),
    ("upper back left", "VestBack", _dots(_UPPER, _LEFT), ("upper_back.L",)),
    ("upper back right", "VestBack", _dots(_UPPER, _RIGHT), ("upper_back.R",)),
    ("middle back left", "VestBack", _dots(_LOWER, _LEFT), ("middle_back.L",)),
    ("middle back right", "VestBack", _dots(_LOWER, _RIGHT), ("middle_back.R",)),
    ("forearm left", "ForearmL", tuple(range(6)), ("forearm.L",)),
    ("forearm right", "ForearmR", tuple(range(6)), ("forearm.R",)),
    ("hand left", "HandL", tuple(range(3)), ("hand.L",)),
    ("hand right", "HandR", tuple(range(3)), ("hand.R",)),
    ("foot left", "FootL", tuple(range(3)), ("foot.L",)),
    ("foot right", "FootR", tuple(range(3)), ("foot.R",)),
)


def websocket_module() -> Any:
    """websocket-client. Raises DeviceError that says how to get it."""
    try:
        return import_module("websocket")
    except ImportError:
        needed = "haptic players need the Python package websocket-client, which the extension carries: install it from its zip"
        raise DeviceError(needed) from None


class Connection:
    """A WebSocket to a player on this computer. May be used by several threads."""

    def __init__(self, url: str) -> None:
        """Raises DeviceError where nobody answers."""
        module = websocket_module()
        self.users, self.broken = 0, False
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._pinging: threading.Thread | None = None
        self._errors = (module.WebSocketException, OSError)
        try:
            self._socket = module.create_connection(url, timeout=_ANSWER_WITHIN, enable_multithread=False)
        except self._errors as error:
            raise DeviceError(f"no player answers at {url.partition('?')[0]}: {error}") from None

    def send(self, text: str) -> None:
        """Send a message; what the player says meanwhile is read and forgotten. Raises OSError where it is gone."""
        with self._lock:
            try:
                self._socket.send(text)
                while select.select([self._socket.sock], [], [], 0)[0]:
                    if self._socket.recv_data()[0] == 8:  # the opcode of closing
                        raise OSError("the player closed the connection")
            except self._errors as error:
                self.broken = True
                raise OSError(str(error)) from None

    def ask(self, message: Mapping[str, Any], wanted: str) -> dict[str, Any]:
        """Send a Buttplug message and wait for the answer of the ``wanted`` kind. Raises DeviceError."""
        with self._lock:
            try:
                self._socket.send(json.dumps([message]))
                for _ in range(100):
                    for answer in json.loads(self._socket.recv()):
                        for kind, content in answer.items():
                            if kind == "Error":
                                raise DeviceError(f"Intiface: {content.get('ErrorMessage', content)}")
                            if kind == wanted:
                                return dict(content)
            except (*self._errors, ValueError, AttributeError, TypeError) as error:
                raise DeviceError(f"Intiface does not answer as expected: {error}") from None
        raise DeviceError("Intiface does not answer")

    def ping_within(self, seconds: float) -> None:
        """From now on say a Buttplug Ping well within every ``seconds``, whatever else is sent, until the connection is closed."""
        self._pinging = threading.Thread(target=self._ping, args=(seconds / _PINGS_IN_TIME,), name="haptics ping", daemon=True)
        self._pinging.start()

    def _ping(self, seconds: float) -> None:
        """The thread of pings: the writer's sleeps while nothing plays."""
        with suppress(OSError):  # it is `broken` then, and the next write says so
            while not self._closing.wait(seconds):
                self.send(_PING)

    def close(self) -> None:
        """Close the connection."""
        self._closing.set()
        if self._pinging is not None:
            self._pinging.join(_ANSWER_WITHIN)
        self._socket.close()


@dataclass(slots=True)
class _Player:
    """One player's connection, opened by the first device that needs it and closed by the last."""

    url: str
    greet: Callable[[Connection], None]
    connection: Connection | None = None

    def open(self) -> Connection:
        with _players:
            if self.connection is None or self.connection.broken:
                connection = Connection(self.url)
                try:
                    self.greet(connection)
                except DeviceError:
                    connection.close()
                    raise
                self.connection = connection
            self.connection.users += 1
            return self.connection

    def close(self, connection: Connection) -> None:
        with _players:
            connection.users -= 1
            if connection.users == 0:
                connection.close()
                self.connection = None if self.connection is connection else self.connection


_players = threading.Lock()


class PlayerModule:
    """A player in the place of hidapi's module, with one device."""

    def __init__(self, player: _Player) -> None:
        self._player = player

    def enumerate(self, vendor_id: int = 0, product_id: int = 0) -> Iterable[Mapping[str, Any]]:
        """The one device; whether it is there shows when it is opened."""
        names = {"path": str(id(self)).encode(), "serial_number": "", "product_string": "", "bus_type": 1}
        return [{**names, "vendor_id": 0, "product_id": 0, "usage_page": 0, "usage": 0, "interface_number": 0}]

    def device(self) -> HidDevice:
        """A device that is not open yet."""
        return _PlayerDevice(self._player)


class _PlayerDevice:
    """A device of a player in the place of hidapi's."""

    def __init__(self, player: _Player) -> None:
        self._player, self._error = player, ""
        self._connection: Connection | None = None

    def open_path(self, path: bytes) -> None:
        self._connection = self._player.open()

    def write(self, data: bytes) -> int:
        assert self._connection is not None
        try:
            self._connection.send(data.decode())
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

    def close(self) -> None:
        if self._connection is not None:
            self._player.close(self._connection)
            self._connection = None


def bhaptics(url: str = BHAPTICS) -> tuple[Profile, PlayerModule]:
    """bHaptics Player: every place that it has dots for is an actuator. Raises DeviceError where it does not run."""
    Connection(url).close()

    def encode(drive: Tones, transport: Transport, sequence: int) -> Report:
        frames: dict[str, list[dict[str, int]]] = {}
        for amplitude, (_, position, dots, _) in zip(drive.amplitudes, _PLACES, strict=True):
            frames.setdefault(position, []).extend({"Index": dot, "Intensity": round(100 * amplitude)} for dot in dots)
        submits = [
            {
                "Type": "frame",
                "Key": f"haptic-tracing {position}",
                "Frame": {"Position": position, "DotPoints": points, "DurationMillis": _FRAME_MILLISECONDS},
            }
            for position, points in frames.items()
        ]
        return Report(json.dumps({"Submit": submits}).encode())

    def release(transport: Transport, sequence: int) -> tuple[Report, ...]:
        return (Report(json.dumps({"Submit": [{"Type": "turnOffAll"}]}).encode()),)

    family = _family("bhaptics", "bHaptics Player", [name for name, *_ in _PLACES], encode, release, refresh=0.06, ends=True)
    parts = {name: parts for name, _, _, parts in _PLACES}
    return _profile(family, parts), PlayerModule(_Player(url, lambda connection: None))


def intiface(url: str = INTIFACE) -> tuple[tuple[Profile, PlayerModule], ...]:
    """The devices that Intiface has: every motor is an actuator, at no body part. Raises DeviceError where it does not run."""
    player = _Player(url, _greet)
    connection = player.open()
    try:
        listed = connection.ask({"RequestDeviceList": {"Id": 2}}, "DeviceList")
    finally:
        player.close(connection)
    try:
        return tuple(_intiface_device(player, device) for device in listed["Devices"] if _motors(device))
    except (KeyError, TypeError, ValueError) as error:
        raise DeviceError(f"Intiface's list of devices can't be read: {error}") from None


def _greet(connection: Connection) -> None:
    """Introduce the program, and keep the connection alive as the server wants it. Raises DeviceError."""
    server = connection.ask({"RequestServerInfo": {"Id": 1, "ClientName": "Haptic Tracing", "MessageVersion": 3}}, "ServerInfo")
    try:
        milliseconds = float(server.get("MaxPingTime") or 0)
    except (TypeError, ValueError):
        raise DeviceError("Intiface: its MaxPingTime is no number") from None
    if 0 < milliseconds < math.inf:
        connection.ping_within(max(milliseconds, _SHORTEST_PING) / 1000)


def _motors(device: Mapping[str, Any]) -> list[int]:
    commands = device["DeviceMessages"].get("ScalarCmd", [])
    return [number for number, command in enumerate(commands) if command.get("ActuatorType") == "Vibrate"]


def _intiface_device(player: _Player, device: Mapping[str, Any]) -> tuple[Profile, PlayerModule]:
    index, motors = int(device["DeviceIndex"]), _motors(device)

    def encode(drive: Tones, transport: Transport, sequence: int) -> Report:
        scalars = [
            {"Index": motor, "Scalar": round(amplitude, 3), "ActuatorType": "Vibrate"}
            for motor, amplitude in zip(motors, drive.amplitudes, strict=True)
        ]
        return Report(json.dumps([{"ScalarCmd": {"Id": 3 + sequence, "DeviceIndex": index, "Scalars": scalars}}]).encode())

    def release(transport: Transport, sequence: int) -> tuple[Report, ...]:
        return (Report(json.dumps([{"StopDeviceCmd": {"Id": 3 + sequence, "DeviceIndex": index}}]).encode()),)

    names = [f"motor {number + 1}" for number in range(len(motors))]
    gap = max(float(device.get("DeviceMessageTimingGap") or 0.0) / 1000, _INTERVAL)
    family = _family(f"intiface {index}", str(device["DeviceName"]), names, encode, release, interval=gap)
    return _profile(family, dict.fromkeys(names, ())), PlayerModule(player)


def _anything(interface: Interface) -> bool:
    return True


def _family(
    name: str,
    title: str,
    channels: Sequence[str],
    encode: Callable[[Tones, Transport, int], Report],
    release: Callable[[Transport, int], tuple[Report, ...]],
    *,
    interval: float = _INTERVAL,
    refresh: float | None = None,
    ends: bool = False,
) -> RumbleFamily:
    count = len(channels)
    return RumbleFamily(
        name=name,
        title=title,
        ids=frozenset({(0, 0)}),
        transports=("usb",),
        channels=tuple(channels),
        minimum_interval={"usb": interval, "bt": interval},
        ends_by_itself=ends,
        after_kill="stops within 0.1 s" if ends else "goes on until Intiface notices that the connection is gone",
        refresh_interval=refresh,
        picks=_anything,
        release=release,
        encode=encode,
        rumble=lambda left, right: Tones((left,) * count, (0.0,) * count),
    )


def _profile(family: RumbleFamily, parts: Mapping[str, tuple[str, ...]]) -> Profile:
    actuators = tuple(
        Actuator(name, places, "ERM", (30.0, 250.0), 0.05, 1.0, (Channel(name, _TAKES),), Calibration()) for name, places in parts.items()
    )
    return Profile(family.name, family.title, family, True, None, 20.0, 0.7, 10.0, actuators)
