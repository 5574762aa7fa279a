"""The progress of one participant through the study: the next step, and the answers so far."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...core.formats.io.schema import validate
from ...core.forms import Form, JsonObject
from .record import add_step, read_steps


class Sitting:
    """One participant. What is done is what the file says, so that an interrupted sitting
    resumes."""

    def __init__(self, folder: Path, participant: str, plan: Form) -> None:
        """Raises KeyError for somebody who is not in the plan."""
        self.participant, self.steps = participant, plan["orders"][participant]
        self._path = folder / f"{participant}.jsonl"
        self.done = sum("answer" in step for step in read_steps(self._path))

    @property
    def step(self) -> JsonObject:
        """The next step; none after the last."""
        return self.steps[self.done] if self.done < len(self.steps) else {}

    def note(self, what: str) -> None:
        """Write down something that is no step."""
        add_step(self._path, {"note": what})

    def take(self, number: int, rows: Any, seconds: float) -> None:
        """Write the answer to step ``number``, if that is the next one: rows of item and value, and
        of x and y where something was felt. Raises ValueError if they are none."""
        if self.step and number == self.done:
            validate(rows, "people_answer", "answer")
            add_step(self._path, {**self.step, "answer": rows, "seconds": round(seconds, 2)})
            self.done += 1
