"""OSC over UDP: poses in, levels and impacts out."""

from __future__ import annotations

import select
import threading
from collections.abc import Callable
from itertools import chain
from typing import Any

from pythonosc.dispatcher import Dispatcher
from pythonosc.osc_server import BlockingOSCUDPServer
from pythonosc.udp_client import SimpleUDPClient

from ...core.forms import JsonObject
from .conversation import MOST_OBJECTS, Conversation, text_of

_MOST_WAITING = 64
_LONGEST = 1024
"""Characters of a name."""


class _Server(BlockingOSCUDPServer):
    """A server that calls ``answer`` after each packet behind which no other one waits."""

    answer: Callable[[], None]

    def service_actions(self) -> None:
        """Called after each packet, and now and then."""
        if not select.select([self.socket], [], [], 0)[0]:
            self.answer()


class OscDoor:
    """Answers OSC messages on a port of this machine as they come, those of a bundle whatever its
    date. The poses since the last step belong to the next one, at most `MOST_OBJECTS`."""

    def __init__(self, conversation: Conversation, port: int) -> None:
        """Raises OSError if the port is taken."""
        self._conversation = conversation
        self._poses: dict[str, list[float]] = {}
        dispatcher = Dispatcher(strict_timing=False)  # it would wait for a bundle's date
        dispatcher.map("/haptic/pose", self._pose)
        dispatcher.map("/haptic/step", self._step, needs_reply_address=True)
        dispatcher.map("/haptic/play", self._play, needs_reply_address=True)
        dispatcher.map("/haptic/stop", self._stop, needs_reply_address=True)
        self._client: tuple[str, int] = ("", 0)
        self._texts: list[str] = []  # what this client has said since it was answered
        self.server = _Server(("127.0.0.1", port), dispatcher)
        self.server.answer = self._answer
        self._thread = threading.Thread(
            target=self.server.serve_forever, name="haptics osc", daemon=True
        )

    def start(self) -> None:
        """Begin to answer."""
        self._thread.start()

    def close(self) -> None:
        """Answer no more."""
        self.server.shutdown()
        self.server.server_close()

    def _pose(self, address: str, *values: Any) -> None:
        if values and isinstance(values[0], str) and len(self._poses) < MOST_OBJECTS:
            self._poses[values[0][:_LONGEST]] = list(values[1:9])

    def _step(self, client: tuple[str, int], address: str, *values: Any) -> None:
        poses, self._poses = self._poses, {}
        self._say(client, {"type": "step", "time": values[0] if values else None, "poses": poses})

    def _play(self, client: tuple[str, int], address: str, *values: Any) -> None:
        self._say(client, {"type": "play", "source": values[0] if values else None})

    def _stop(self, client: tuple[str, int], address: str, *values: Any) -> None:
        self._say(client, {"type": "stop"})

    def _say(self, client: tuple[str, int], message: JsonObject) -> None:
        """Note a message, which is answered to where it came from."""
        if client != self._client or len(self._texts) >= _MOST_WAITING:
            self._answer()
        self._client = client
        self._texts.append(text_of(message))

    def _answer(self) -> None:
        """Answer what was said: of steps that waited the newest."""
        if not self._texts:
            return
        texts, self._texts = self._texts, []
        to = SimpleUDPClient(*self._client[:2])
        for answer in chain.from_iterable(self._conversation.answers(texts)):
            if isinstance(answer, bytes):
                continue
            if answer["type"] == "error":
                to.send_message("/haptic/error", [answer["where"], answer["message"]])
            elif answer["type"] == "frame":
                for listener, level in answer["levels"].items():
                    numbers = [
                        -200.0 if level[key] is None else float(level[key])
                        for key in ("level", "margin")
                    ]
                    to.send_message("/haptic/level", [listener, *numbers])
                for blow in answer["impacts"]:
                    to.send_message("/haptic/impact", [*blow["objects"], float(blow["energy"])])
