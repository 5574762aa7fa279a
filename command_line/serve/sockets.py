"""The WebSocket of a server: who may connect, and what is sent to slow readers."""

from __future__ import annotations

import hmac
import threading
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from http import HTTPStatus
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.sync.server import Server, ServerConnection, serve

from ...core.run_time import Scene
from ...core.scene.references import PlacedError
from .conversation import Answer, Conversation, text_of
from .stage import DeviceStage

LARGEST = 4 * 2**20
"""Bytes of a message."""
MOST_CONNECTIONS = 8
LOCAL = ("127.0.0.1", "::1", "localhost")
"""Names of this machine."""
_MOST_WAITING = 64


class Outbox:
    """Answers on their way to a client: of frames that wait only the newest is kept, of others a
    bounded number."""

    def __init__(self) -> None:
        self._waiting: deque[list[str | bytes]] = deque()
        self._frame: list[str | bytes] | None = None
        self._changed = threading.Condition()
        self._closed = False

    def put(self, answers: Sequence[Answer]) -> None:
        """Add the answers to one message."""
        sent = [answer if isinstance(answer, bytes) else text_of(answer) for answer in answers]
        is_frame = bool(answers) and isinstance(answers[0], dict) and answers[0]["type"] == "frame"
        with self._changed:
            if is_frame:
                self._frame = sent
            elif sent and len(self._waiting) < _MOST_WAITING:
                self._waiting.append(sent)
            self._changed.notify()

    def close(self) -> None:
        """Let `take` end."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def take(self) -> list[str | bytes] | None:
        """The next answers, waiting for them; None at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._waiting or self._frame is not None)
            if self._closed:
                return None
            if self._waiting:
                return self._waiting.popleft()
            frame, self._frame = self._frame, None
            return frame


class Door:
    """Accepts connections. ``token``: what a client says for its steps to be played on the devices,
    and, where others than this machine can connect, to be answered at all. ``holder``: who has the
    devices from the beginning on."""

    def __init__(
        self,
        scene: Scene | None,
        stage: DeviceStage | None,
        host: str,
        token: str,
        origins: Sequence[str],
        heard: Callable[[Conversation], None],
        holder: str | None = None,
    ) -> None:
        """Prepare; `listen` makes the server.

        Args:
            scene: that is played, None if clients bring theirs.
            stage: the devices, None without any.
            host: address at which it listens.
            token: as of the class.
            origins: of web pages that may connect.
            heard: is called with each conversation.
        """
        self._scene, self._stage, self._token, self._heard = scene, stage, token, heard
        self._origins = origins
        self.host = host
        self.is_local = host in LOCAL
        self._names: set[str] = set()  # that a client may call the server
        self._open: set[ServerConnection] = set()
        self._holder: ServerConnection | str | None = holder
        self._lock = threading.Lock()

    def listen(self, port: int) -> Server:
        """The server, which accepts connections once `serve_forever` is called. Raises OSError."""
        server = serve(
            self._handle,
            self.host,
            port,
            max_size=LARGEST,
            process_request=self._admit,
            process_response=self._keep_place,
            compression=None,
            max_queue=4,
            server_header=None,
        )
        address, port = server.socket.getsockname()[:2]
        names = [self.host, f"[{self.host}]", address]
        if self.is_local:
            names += ["localhost", "127.0.0.1"]
        self._names = {f"{name}:{port}" for name in names}
        return server

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        if request.path == "/health":
            return connection.respond(HTTPStatus.OK, "ok\n")
        for origin in request.headers.get_all("Origin"):
            if origin not in self._origins:
                return connection.respond(
                    HTTPStatus.FORBIDDEN,
                    f"the origin {origin} is not allowed: start the server with --allow-origin\n",
                )
        if self.host not in ("0.0.0.0", "::") and request.headers.get("Host") not in self._names:
            return connection.respond(
                HTTPStatus.FORBIDDEN,
                "this host name is not the address that the server listens on\n",
            )
        return None

    def _keep_place(
        self, connection: ServerConnection, request: Request, response: Response
    ) -> Response | None:
        """Count a connection that is about to be accepted, or refuse it."""
        if response.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            return None
        with self._lock:
            self._open = {one for one in self._open if one.state is not State.CLOSED}
            if len(self._open) >= MOST_CONNECTIONS:
                return connection.respond(
                    HTTPStatus.SERVICE_UNAVAILABLE,
                    f"there are {MOST_CONNECTIONS} connections already\n",
                )
            self._open.add(connection)
        return None

    def _handle(self, connection: ServerConnection) -> None:
        """Answer one client until it goes."""
        outbox = Outbox()
        sender = threading.Thread(
            target=_send, args=(connection, outbox), name="haptics answers", daemon=True
        )
        conversation = Conversation(self._scene, partial(self._stage_for, connection))
        try:
            sender.start()
            while True:
                outbox.put(conversation.answer(connection.recv(decode=False)))
                self._heard(conversation)
        except ConnectionClosed:
            pass  # an engine that is stopped just goes
        finally:
            outbox.close()
            with self._lock:
                self._open.discard(connection)
                if self._holder is connection:
                    self._holder = None
                    if self._stage is not None:
                        self._stage.stop()

    def _stage_for(self, connection: ServerConnection, message: Any) -> DeviceStage | str | None:
        """The devices for a client with this first message: the first one that has the token gets
        them, others are told. Raises PlacedError where only clients with the token are answered."""
        token = message.get("token") if isinstance(message, dict) else None
        if not isinstance(token, str) or not hmac.compare_digest(
            token.encode(), self._token.encode()
        ):
            if self.is_local:
                return None
            raise PlacedError(("token",), "the first message is hello with the server's token")
        if self._stage is None:
            return None
        with self._lock:
            if self._holder is not None:
                other = self._holder if isinstance(self._holder, str) else "another client"
                return f"the devices play for {other}"
            self._holder = connection
            return self._stage


def _send(connection: ServerConnection, outbox: Outbox) -> None:
    """The thread that sends a client its answers."""
    while (answers := outbox.take()) is not None:
        try:
            for answer in answers:
                connection.send(answer)
        except ConnectionClosed:
            return
