"""WebSocket connections to haptic players on this computer, and replacements for hidapi's module
for a player's devices.

Connects only to the loopback address, without proxies and redirects. Messages are limited in size
and time. Needs the Python package websockets.
"""

from __future__ import annotations

import json
import logging
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from importlib import import_module
from time import monotonic
from typing import Any
from urllib.parse import urlsplit

from ...core.devices.connection import DeviceError, StandInModule, carried_module
from ...core.devices.families.family import HidDevice, Interface
from ...core.formats.io.strict_json import parse_json
from ...core.forms import Form, JsonObject
from ...core.frozen import frozen

ANSWER_WITHIN = 2.0
"""Time-out of a player for opening a connection and for an answer [s]."""
LARGEST_MESSAGE = 65_536
"""Largest message in bytes; a longer one closes the connection."""
_LOOPBACK = "127.0.0.1"
_CONNECT_WITHIN, _CLOSE_WITHIN = 0.5, 0.2
_NO_LOG = logging.Logger("haptic players", logging.CRITICAL + 1)  # errors are told by the panel
# Messages that are read while an answer is waited for, or between two that are sent.
_LONGEST_TALK = 100


def websockets_client() -> Any:
    """The client of the package websockets. Raises DeviceError with instructions if it is
    missing."""
    return carried_module("websockets.sync.client", "haptic players")


_waiting: set[socket.socket] = set()
"""Sockets of connections that are being opened or wait for an answer."""


@contextmanager
def _cancellable(waiting: socket.socket) -> Iterator[None]:
    _waiting.add(waiting)
    try:
        yield
    finally:
        _waiting.discard(waiting)


def cancel() -> None:
    """Abort all connections that are being opened or wait for an answer. Thread-safe."""
    for waiting in tuple(_waiting):
        with suppress(OSError):
            waiting.shutdown(socket.SHUT_RDWR)


class Connection:
    """A WebSocket to a player on this computer. Thread-safe."""

    def __init__(self, url: str) -> None:
        """url: with the loopback address as its host. Raises DeviceError if there is no answer."""
        client = websockets_client()
        exceptions = import_module("websockets.exceptions")
        place = urlsplit(url)
        if place.scheme != "ws" or place.hostname != _LOOPBACK:
            raise DeviceError(
                f"{url.partition('?')[0]} is not on this computer: use ws://{_LOOPBACK}"
            )
        self.users, self.broken = 0, False
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._pinging: threading.Thread | None = None
        self._errors = exceptions.WebSocketException, OSError, ValueError, EOFError, LookupError
        self._resources = ExitStack()
        try:
            self._raw = self._resources.enter_context(
                socket.create_connection((_LOOPBACK, place.port or 80), _CONNECT_WITHIN)
            )
            with _cancellable(self._raw):
                # With a socket of its own the client follows no redirect.
                connecting = client.connect(
                    url,
                    sock=self._raw,
                    proxy=None,
                    compression=None,
                    open_timeout=ANSWER_WITHIN,
                    close_timeout=_CLOSE_WITHIN,
                    ping_interval=None,
                    max_size=LARGEST_MESSAGE,
                    logger=_NO_LOG,
                )
                self._socket = self._resources.enter_context(connecting)
        except self._errors as error:
            self._resources.close()
            raise DeviceError(
                f"no player answers at {url.partition('?')[0]}: {str(error).partition(chr(10))[0]}"
            ) from None

    def send(self, text: str) -> None:
        """Send a message; messages received meanwhile are dropped. Raises OSError if the connection
        is closed."""
        with self._lock:
            try:
                self._socket.send(text)
                with suppress(TimeoutError):
                    for _ in range(_LONGEST_TALK):
                        self._socket.recv(timeout=0)
            except self._errors as error:
                self.broken = True
                raise OSError(f"the player closed the connection: {error}") from None

    def ask(self, message: Form, wanted: str) -> JsonObject:
        """Send a Buttplug message and wait for the answer of the ``wanted`` kind. Raises
        DeviceError."""
        end = monotonic() + ANSWER_WITHIN
        with self._lock, _cancellable(self._raw):
            try:
                self._socket.send(json.dumps([message]))
                for _ in range(_LONGEST_TALK):
                    for kind, content in messages_of(
                        self._socket.recv(timeout=max(end - monotonic(), 0.0))
                    ):
                        if kind == "Error":
                            raise DeviceError(
                                f"Intiface: {str(content.get('ErrorMessage', 'error'))[:200]}"
                            )
                        if kind == wanted:
                            return content
            except DeviceError:
                raise
            except self._errors as error:
                raise DeviceError(f"Intiface does not answer as expected: {error}") from None
        raise DeviceError("Intiface does not answer")

    def ping_every(self, seconds: float, message: str) -> None:
        """Send ``message`` every ``seconds`` from now on, until the connection is closed."""
        self._pinging = threading.Thread(
            target=self._ping, args=(seconds, message), name="haptics ping", daemon=True
        )
        self._pinging.start()

    def _ping(self, seconds: float, message: str) -> None:
        """The thread of pings: the writer's sleeps while nothing plays."""
        with suppress(OSError):  # it is `broken` then, and the next write says so
            while not self._closing.wait(seconds):
                self.send(message)

    def close(self) -> None:
        """Close the connection."""
        self._closing.set()
        if self._pinging is not None:
            self._pinging.join(_CLOSE_WITHIN)
        with suppress(*self._errors):
            self._resources.close()


def messages_of(text: str | bytes) -> list[tuple[str, JsonObject]]:
    """The messages of a Buttplug packet, with their kinds. Raises ValueError."""
    packet = parse_json(text.encode() if isinstance(text, str) else text, "its message")
    if not isinstance(packet, list) or not all(isinstance(message, dict) for message in packet):
        raise ValueError("it is no list of messages")
    return [
        (kind, content)
        for message in packet
        for kind, content in message.items()
        if isinstance(content, dict)
    ]


@frozen
class Player:
    """Address and greeting of a player, with its connection.

    greet: introduces the program. last: part of a message that must arrive, if necessary on a new
    connection.
    """

    url: str
    greet: Callable[[Connection], None]
    last: bytes

    def open(self) -> Connection:
        """The player's connection, opened by the first device that needs it. Raises DeviceError."""
        with _lock:
            connection = _connections.get(self.url)
            if connection is None or connection.broken:
                connection = Connection(self.url)
                try:
                    self.greet(connection)
                except DeviceError:
                    connection.close()
                    raise
                _connections[self.url] = connection
            connection.users += 1
            return connection

    def close(self, connection: Connection) -> None:
        """Stop using the connection; the last device that uses it closes it."""
        with _lock:
            connection.users -= 1
            if connection.users == 0:
                connection.close()
                if _connections.get(self.url) is connection:
                    del _connections[self.url]


_lock = threading.Lock()
_connections: dict[str, Connection] = {}


def player_module(player: Player, device_name: str) -> StandInModule:
    """Replacement for hidapi's module with one device of a player, called ``device_name`` there."""
    interface = Interface(f"{player.url} {device_name}".encode(), 0, 0, "", "", 0, 0, 0, "usb")
    return StandInModule(interface, partial(_PlayerDevice, player))


class _PlayerDevice(HidDevice):
    """A device of a player."""

    def __init__(self, player: Player) -> None:
        super().__init__()
        self._player = player
        self._connection: Connection | None = None

    def open_path(self, path: bytes) -> None:
        self._connection = self._player.open()

    def take(self, data: bytes) -> None:
        if self._connection is None or (self._connection.broken and self._player.last in data):
            self.close()
            self._connection = self._player.open()
        self._connection.send(data.decode())

    def close(self) -> None:
        if self._connection is not None:
            self._player.close(self._connection)
            self._connection = None
