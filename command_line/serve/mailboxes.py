"""What waits on its way from a client, and on its way back to it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence

from ...core.forms import JsonObject
from .conversation import Answer

_MOST_MESSAGES, _MOST_BYTES = 64, 16 * 2**20
_MOST_EVENTS = 65_536


class Inbox:
    """Messages that wait to be answered together: as many as a busy server follows in a tenth of a
    second."""

    def __init__(self) -> None:
        self._waiting: list[bytes] = []
        self._changed = threading.Condition()
        self.is_closed = False

    def put(self, message: bytes) -> None:
        """Add a message, once there is room."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_closed or self._has_room())
            self._waiting.append(message)
            self._changed.notify_all()

    def _has_room(self) -> bool:
        held = sum(map(len, self._waiting))
        return len(self._waiting) < _MOST_MESSAGES and held < _MOST_BYTES

    def take(self) -> list[bytes]:
        """All that wait, at least one; none at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_closed or self._waiting)
            taken, self._waiting = self._waiting, []
            self._changed.notify_all()
            return [] if self.is_closed else taken

    def close(self) -> None:
        """Let `take` and `put` end."""
        with self._changed:
            self.is_closed = True
            self._changed.notify_all()


class Outbox:
    """Answers on their way to a client. Of frames that follow each other and wait, the newest is
    sent, with the impacts of all; it names those that were dropped."""

    def __init__(self) -> None:
        self._waiting: deque[Sequence[Answer]] = deque()
        self._events = 0
        self._changed = threading.Condition()
        self._is_closed = False

    def put(self, answers: Sequence[Answer]) -> bool:
        """Add the answers to a message. Returns False if the client leaves too much unread."""
        with self._changed:
            frame = _frame(answers)
            if frame is not None:
                self._events += len(frame["impacts"])
                before = _frame(self._waiting[-1]) if self._waiting else None
                if before is not None:
                    self._waiting.pop()
                    _carry(before, frame)
            if answers:
                self._waiting.append(answers)
                self._events += 1
            self._changed.notify()
            return self._events <= _MOST_EVENTS

    def close(self) -> None:
        """Let `take` end."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()

    def take(self) -> Sequence[Answer]:
        """The next answers, waiting for them; none at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closed or self._waiting)
            if self._is_closed:
                return ()
            answers = self._waiting.popleft()
            if not self._waiting:
                self._events = 0
            return answers


def _frame(answers: Sequence[Answer]) -> JsonObject | None:
    """The frame among the answers to a message."""
    first = answers[0] if answers else None
    return first if isinstance(first, dict) and first["type"] == "frame" else None


def _carry(before: JsonObject, frame: JsonObject) -> None:
    """Let a ``frame`` carry the impacts of the one ``before``, which is dropped."""
    named = {key: before[key] for key in ("answers", "first_sample", "n")}
    dropped = before.get("dropped", [])
    dropped.append(named)
    frame["dropped"] = dropped
    frame["impacts"] = [*before["impacts"], *frame["impacts"]]
