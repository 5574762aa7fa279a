"""The WebSocket of a server: who is answered, and who plays on the devices."""

from __future__ import annotations

import hmac
import threading
from collections.abc import Callable, Sequence
from functools import partial
from http import HTTPStatus
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection

from ...core.run_time import Scene
from ...core.scene.references import PlacedError
from .conversation import Answer, Conversation, text_of
from .front import MOST_CONNECTIONS, Front, responds
from .mailboxes import Inbox, Outbox
from .stage import DeviceStage


class Door:
    """Answers connections. ``token``: what a client says for its steps to be played on the devices,
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
        self._front = Front(host, origins)
        self._holder: tuple[ServerConnection, Conversation] | str | None = holder
        self._lock = threading.Lock()

    def listen(self, port: int) -> Server:
        """The server, which accepts connections once `serve_forever` is called. Raises OSError."""
        return self._front.listen(port, self._handle, _health)

    def _handle(self, connection: ServerConnection) -> None:
        """Answer one client until it goes. Raises TimeoutError if it says nothing valid in time."""
        conversation = Conversation(self._scene, None)
        conversation.admit = partial(self._admit, connection, conversation)
        while not conversation.is_admitted:
            first = connection.recv(self._front.patience(connection), decode=False)
            for answers in conversation.answers([first]):
                _send(connection, answers)
        inbox, outbox = Inbox(), Outbox()
        threads = [
            threading.Thread(target=_send_all, args=(connection, outbox), name="haptics answers"),
            threading.Thread(
                target=self._answer, args=(connection, conversation, inbox, outbox), name="haptics"
            ),
        ]
        try:
            for thread in threads:
                thread.daemon = True
                thread.start()
            while True:
                inbox.put(connection.recv(decode=False))
        finally:
            inbox.close()
            outbox.close()
            threads[1].join()
            with self._lock:
                if isinstance(self._holder, tuple) and self._holder[0] is connection:
                    self._holder = None
                    conversation.release("the connection is closed")

    def _answer(
        self, connection: ServerConnection, conversation: Conversation, inbox: Inbox, outbox: Outbox
    ) -> None:
        """The thread that answers what a client has said."""
        while texts := inbox.take():
            for answers in conversation.answers(texts):
                if inbox.is_closed:
                    return
                if not outbox.put(answers):
                    connection.close(CloseCode.POLICY_VIOLATION, "too much is left unread")
                    return
                self._heard(conversation)

    def _admit(
        self, connection: ServerConnection, conversation: Conversation, message: Any
    ) -> DeviceStage | str | None:
        """The devices for a client with this first message: the first one that has the token gets
        them, and keeps them as long as it responds where another asks for them. Raises PlacedError
        where only clients with the token are answered, and where there is no place."""
        token = message.get("token") if isinstance(message, dict) else None
        has_token = isinstance(token, str) and hmac.compare_digest(
            token.encode("utf-8", "surrogatepass"), self._token.encode()
        )
        if not has_token and not self._front.is_local:
            raise PlacedError(("token",), "the first message is hello with the server's token")
        if not self._front.take_place(connection):
            raise PlacedError((), f"there are {MOST_CONNECTIONS} connections already")
        if not has_token or self._stage is None:
            return None
        with self._lock:
            if isinstance(self._holder, str):
                return f"the devices play for {self._holder}"
            if self._holder is not None:
                if responds(self._holder[0]):
                    return "the devices play for another client"
                self._holder[1].release("the devices play for another client")
            self._holder = connection, conversation
            return self._stage


def _health(connection: ServerConnection, request: Request) -> Response | None:
    return connection.respond(HTTPStatus.OK, "ok\n") if request.path == "/health" else None


def _send_all(connection: ServerConnection, outbox: Outbox) -> None:
    """The thread that sends a client its answers."""
    while answers := outbox.take():
        try:
            _send(connection, answers)
        except ConnectionClosed:
            return


def _send(connection: ServerConnection, answers: Sequence[Answer]) -> None:
    for answer in answers:
        connection.send(answer if isinstance(answer, bytes) else text_of(answer))
