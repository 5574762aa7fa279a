"""A participant's way through the study: which step is next, and whether an answer fits it."""

from __future__ import annotations

import time
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
        order, self._form = plan["orders"][participant], plan["form"]
        self.participant = participant
        self._path = folder / f"{participant}.jsonl"
        self._conditions = order["conditions"]
        self.steps: list[JsonObject] = [{"step": name} for name in ("consent", "about", "start")]
        for position, condition in enumerate(self._conditions):
            about = {"condition": condition, "position": position + 1}
            for scene in order["scenes"][position]:
                self.steps += [
                    {"step": name, **about, "scene": scene} for name in ("play", "place")
                ]
            self.steps.append({"step": "rate", **about})
        self.steps += [{"step": name} for name in ("rank", "words", "end")]
        self.done = sum("answer" in step for step in read_steps(self._path))
        self._shown = time.monotonic()

    @property
    def step(self) -> JsonObject | None:
        """The next step; None after the last."""
        return self.steps[self.done] if self.done < len(self.steps) else None

    def note(self, what: str, **more: Any) -> None:
        """Write down something that is no step."""
        add_step(self._path, {"note": what, **more})

    def take(self, number: int, answer: Any) -> None:
        """Write the answer to step ``number``, if that is the next one: the values of its items, or
        rows of item, value, x and y where something was felt. Raises ValueError if it does not
        fit."""
        step = self.step
        if step is None or number != self.done:
            return
        rows = answer if step["step"] == "place" else self._rows(step["step"], answer)
        validate(rows, "people_answer", "answer")
        seconds = round(time.monotonic() - self._shown, 2)
        add_step(self._path, {**step, "answer": rows, "seconds": seconds})
        self.done += 1
        self._shown = time.monotonic()

    def _rows(self, kind: str, values: Any) -> list[JsonObject]:
        """Values with the names of their items."""
        form, conditions, scale = self._form, self._conditions, self._form["scale"]
        if kind == "rate" and not set(values) <= {*range(scale["low"], scale["high"] + 1)}:
            raise ValueError(f"{values} are not on the scale")
        if kind == "rank" and sorted(values) != [*range(1, len(conditions) + 1)]:
            raise ValueError(f"{values} are no ranks")
        items = {
            "about": form["about"],
            "words": form["words"],
            "play": ["late_ms", "missed_ms"],
            "rate": [item["text"] for item in form["items"]],
            "rank": conditions,
        }.get(kind, ())
        pairs = zip(items, values, strict=True)
        return [{"item": item, "value": value} for item, value in pairs]
