"""The front of a server: who may connect, for how long without a word, and in how many places."""

from __future__ import annotations

import errno
import socket
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from typing import Any, NoReturn

from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve

LARGEST = 4 * 2**20
"""Bytes of a message."""
MOST_CONNECTIONS = 8
MOST_UNFINISHED = 16
"""Connections without a place. One more ends the oldest."""
PATIENCE = 5.0
"""Seconds from connecting to having a place."""
ANYWHERE = ("0.0.0.0", "::")
LOCAL = ("127.0.0.1", "::1", "localhost")
"""Names of this machine."""
_ANSWERS = 2.0
_PASSING = {errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM, errno.ECONNABORTED}
"""Reasons why a connection can't be accepted at the moment."""
_AGAIN = 0.05
_MOST_ENDING = 4
_BUFFER = 2**16
"""Bytes that wait in a socket: who sends more than is answered has to wait, instead of getting late
answers."""


class _Listener(socket.socket):
    """A listening socket that goes on accepting when resources are short, and keeps at most
    `MOST_UNFINISHED` connections without a place."""

    def __init__(self, fileno: int) -> None:
        super().__init__(fileno=fileno)
        self._unfinished: dict[socket.socket, float] = {}
        self._ending: list[socket.socket] = []
        self._lock = threading.Lock()

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection. Raises OSError once this socket is closed."""
        while True:
            try:
                one, address = super().accept()
            except OSError as error:
                if self.fileno() < 0 or error.errno not in _PASSING:
                    raise
                time.sleep(_AGAIN)
                continue
            with self._lock:
                for other in [each for each in self._unfinished if each.fileno() < 0]:
                    del self._unfinished[other]
                for other in [*self._unfinished][: len(self._unfinished) - MOST_UNFINISHED + 1]:
                    del self._unfinished[other]
                    with suppress(OSError):
                        other.shutdown(socket.SHUT_RDWR)
                    self._ending.append(other)
                self._unfinished[one] = time.monotonic()
            self._await_ends()
            return one, address

    def _await_ends(self) -> None:
        """Wait for a moment where too many connections that were ended are not closed yet."""
        deadline = time.monotonic() + 1.0
        while True:
            self._ending = [one for one in self._ending if one.fileno() >= 0]
            if len(self._ending) < _MOST_ENDING or time.monotonic() > deadline:
                return
            time.sleep(0.005)

    def since(self, one: socket.socket) -> float:
        """When a connection without a place began, by `time.monotonic`."""
        with self._lock:
            return self._unfinished.get(one, 0.0)

    def finish(self, one: socket.socket) -> None:
        """Take note that a connection has a place."""
        with self._lock:
            self._unfinished.pop(one, None)


class Front:
    """Who may connect to a server at ``host``. Pages may that come from itself, or from one of the
    ``origins``; where the host is one address, clients call it by its name."""

    def __init__(self, host: str, origins: Sequence[str] = ()) -> None:
        self.host, self._origins = host, set(origins)
        self.is_local = host in LOCAL
        self._names: set[str | None] = set()
        self._places: set[ServerConnection] = set()
        self._lock = threading.Lock()

    def listen(
        self,
        port: int,
        handle: Callable[[ServerConnection], None],
        page: Callable[[ServerConnection, Request], Response | None],
    ) -> Server:
        """The server, which accepts connections once `serve_forever` is called. Raises OSError.

        Args:
            port: 0 for any that is free.
            handle: answers one connection, until it is closed.
            page: the response to a request; None where it may become a WebSocket.
        """
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        listening = socket.create_server((self.host, port), family=family)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self._listener = _Listener(fileno=listening.detach())
        self._page = page
        server = serve(
            partial(self._handle, handle),
            sock=self._listener,
            max_size=LARGEST,
            process_request=self._admit,
            compression=None,
            max_queue=4,
            open_timeout=PATIENCE,
            server_header=None,
        )
        address, port = self._listener.getsockname()[:2]
        names = [self.host, f"[{self.host}]", address, *(LOCAL if self.is_local else ())]
        self._names = {f"{name}:{port}" for name in names}
        self._origins |= {f"http://{name}" for name in self._names}
        return server

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        for origin in request.headers.get_all("Origin"):
            if origin not in self._origins:
                return connection.respond(
                    HTTPStatus.FORBIDDEN, f"the origin {origin!a} may not connect\n"
                )
        if self.host not in ANYWHERE and request.headers.get("Host") not in self._names:
            return connection.respond(
                HTTPStatus.FORBIDDEN,
                "this host name is not the address that the server listens on\n",
            )
        return self._page(connection, request)

    def _handle(
        self, handle: Callable[[ServerConnection], None], connection: ServerConnection
    ) -> None:
        try:
            handle(connection)
        except (ConnectionClosed, TimeoutError):
            pass  # who is stopped just goes; who says nothing is closed
        finally:
            with self._lock:
                self._places.discard(connection)

    def patience(self, connection: ServerConnection) -> float:
        """Seconds that a connection has left to get a place."""
        return max(self._listener.since(connection.socket) + PATIENCE - time.monotonic(), 0.0)

    def take_place(self, connection: ServerConnection) -> bool:
        """Give a place to a connection, which then stays, unless there is none left."""
        with self._lock:
            if len(self._places) < MOST_CONNECTIONS:
                self._places.add(connection)
                self._listener.finish(connection.socket)
        return connection in self._places


def serve_forever(server: Server) -> NoReturn:
    """Answer until another thread or a signal ends the program. Raises OSError."""
    server.serve_forever()
    raise OSError("the server can't accept connections any more")


def responds(connection: ServerConnection) -> bool:
    """Whether a client answers a ping within 2 s."""
    answered = threading.Event()

    def ask() -> None:
        with suppress(ConnectionClosed):
            if connection.ping().wait(_ANSWERS):
                answered.set()

    # By a thread, as sending waits while the client does not read.
    threading.Thread(target=ask, name="haptics ping", daemon=True).start()
    return answered.wait(_ANSWERS)
