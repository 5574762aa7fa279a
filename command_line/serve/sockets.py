"""The WebSocket of a server: who may connect, and what is sent to slow readers."""

from __future__ import annotations

import hmac
import json
import threading
from collections import deque
from collections.abc import Callable, Sequence
from http import HTTPStatus

from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve

from ...core.run_time import Scene
from .conversation import Answer, Conversation, Stage, text_of

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
    and, where others than this machine can connect, to be answered at all."""

    def __init__(
        self,
        scene: Scene | None,
        stage: Stage | None,
        host: str,
        token: str,
        origins: Sequence[str],
        heard: Callable[[Conversation], None],
    ) -> None:
        self._scene, self._stage, self._token, self._heard = scene, stage, token, heard
        self._origins = origins
        self.host = host
        self.is_local = host in LOCAL
        self._count = 0
        self._holder: Conversation | None = None  # who has the devices
        self._lock = threading.Lock()

    def listen(self, port: int) -> Server:
        """The server, which accepts connections once `serve_forever` is called. Raises OSError."""
        return serve(
            self._handle,
            self.host,
            port,
            max_size=LARGEST,
            process_request=self._admit,
            compression=None,
            max_queue=4,
            server_header=None,
        )

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        if request.path == "/health":
            return connection.respond(HTTPStatus.OK, "ok\n")
        for origin in request.headers.get_all("Origin"):
            if origin not in self._origins:
                return connection.respond(
                    HTTPStatus.FORBIDDEN,
                    f"the origin {origin} is not allowed: start the server with --allow-origin\n",
                )
        address, port = connection.socket.getsockname()[:2]
        named = {
            f"{name}:{port}"
            for name in (
                self.host,
                f"[{self.host}]",
                address,
                *(("localhost", "127.0.0.1") if self.is_local else ()),
            )
        }
        if self.host not in ("0.0.0.0", "::") and request.headers.get("Host") not in named:
            return connection.respond(
                HTTPStatus.FORBIDDEN,
                "this host name is not the address that the server listens on\n",
            )
        if self._count >= MOST_CONNECTIONS:
            return connection.respond(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"there are {MOST_CONNECTIONS} connections already\n",
            )
        return None

    def _handle(self, connection: ServerConnection) -> None:
        """Answer one client until it goes."""
        outbox = Outbox()
        sender = threading.Thread(
            target=_send, args=(connection, outbox), name="haptics answers", daemon=True
        )
        conversation: Conversation | None = None
        with self._lock:
            self._count += 1
        try:
            sender.start()
            for message in connection:
                if conversation is None:
                    trusted = self._is_trusted(message)
                    if not trusted and not self.is_local:
                        outbox.put(
                            [
                                {
                                    "type": "error",
                                    "where": "/token",
                                    "message": "the first message is hello with the server's token",
                                }
                            ]
                        )
                        continue
                    conversation = self._begun(trusted)
                outbox.put(conversation.answer(message))
                self._heard(conversation)
        except ConnectionClosed:
            pass  # an engine that is stopped just goes
        finally:
            outbox.close()
            with self._lock:
                self._count -= 1
                if conversation is not None and self._holder is conversation:
                    self._holder = None
                    if self._stage is not None:
                        self._stage.stop()

    def _begun(self, trusted: bool) -> Conversation:
        """The conversation with a new client; the first one that is trusted has the devices."""
        with self._lock:
            plays = trusted and self._holder is None
            conversation = Conversation(self._scene, self._stage if plays else None)
            if plays:
                self._holder = conversation
            return conversation

    def _is_trusted(self, message: str | bytes) -> bool:
        """Whether the first message of a client has the token."""
        try:
            said = json.loads(message)
        except (ValueError, RecursionError):
            return False
        token = said.get("token") if isinstance(said, dict) else None
        return isinstance(token, str) and hmac.compare_digest(token.encode(), self._token.encode())


def _send(connection: ServerConnection, outbox: Outbox) -> None:
    """The thread that sends a client its answers."""
    while (answers := outbox.take()) is not None:
        try:
            for answer in answers:
                connection.send(answer)
        except ConnectionClosed:
            return
