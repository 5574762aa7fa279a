"""The folder of a study with people: ``study.json``, the plan, written before the first
participant, and ``P01.jsonl`` and so on, a line for each step that a participant has taken."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas
from pandas import DataFrame

from ...core.formats.io.atomic import lock
from ...core.formats.io.schema import validate
from ...core.forms import Form, JsonObject

PLAN = "study.json"
_LOCK = ".lock"
_STEP = ["participant", "excluded", "step", "position", "condition", "scene"]


def read_plan(folder: Path) -> JsonObject:
    """The plan of a study. Raises ValueError if the folder holds none."""
    try:
        plan: JsonObject = json.loads((folder / PLAN).read_text("utf-8"))
    except FileNotFoundError:
        raise ValueError(f"{folder}: no study; `haptic-tracing study run` begins one") from None
    return plan


def read_steps(path: Path) -> list[JsonObject]:
    """The steps that a participant has taken, and notes, which have no answer. A line that was cut
    off while it was written is left out."""
    written = path.read_bytes() if path.exists() else b""
    return [json.loads(line) for line in written.rpartition(b"\n")[0].splitlines()]


def add_step(path: Path, step: Form) -> None:
    """Append a step or a note with its time to a record, and flush it to the disk, wholly or, where
    that raises OSError, not at all. A last line that is incomplete, as a crash leaves it, is
    overwritten."""
    line = json.dumps({**step, "at": datetime.now(UTC).isoformat()}).encode() + b"\n"
    with path.open("a+b", buffering=0) as file:
        file.seek(0)
        end = file.read().rfind(b"\n") + 1
        file.truncate(end)
        try:
            while line:  # on a full disk only a part may be written, without an error
                line = line[file.write(line) :]
            os.fsync(file.fileno())
        except OSError:
            file.truncate(end)
            raise


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Let no other process write the records of a folder. Raises ValueError if another does."""
    with (folder / _LOCK).open("ab") as file:
        if not lock(file.fileno()):
            raise ValueError(f"{folder}: another `haptic-tracing study run` is open on it")
        yield


class Sitting:
    """The progress of one participant through the study. What is done is what the file says, so
    that an interrupted sitting resumes.

    path: of the file. steps: all."""

    def __init__(self, folder: Path, participant: str, plan: Form) -> None:
        """Raises KeyError for somebody who is not in the plan."""
        self.participant, self.steps = participant, plan["orders"][participant]
        self.path = folder / f"{participant}.jsonl"

    @property
    def done(self) -> int:
        """How many steps are in the file."""
        return sum("answer" in step for step in read_steps(self.path))

    @property
    def step(self) -> JsonObject:
        """The next step; none after the last."""
        return next(iter(self.steps[self.done :]), {})

    def take(self, number: int, rows: Any, seconds: float) -> None:
        """Write the answer to step ``number``, if that is the next one: rows of item and value, and
        of x and y where something was felt. Raises ValueError if they are none, and OSError if
        they can't be written."""
        step = self.step
        if step and number == self.done:
            validate(rows, "people_answer", "answer")
            add_step(self.path, {**step, "answer": rows, "seconds": round(seconds, 2)})


def tidy(folder: Path, plan: Form) -> DataFrame:
    """All answers of a study: a row for each observation, and why its participant is excluded by
    the rules of the plan, if so."""
    taken: list[JsonObject] = []
    for participant in plan["orders"]:
        steps = [step for step in read_steps(folder / f"{participant}.jsonl") if "answer" in step]
        why = _excluded(steps, plan["form"]["exclusion"])
        taken += [{"participant": participant, "excluded": why, **step} for step in steps]
    table = pandas.json_normalize(taken, "answer", _STEP, errors="ignore")
    return table.reindex(columns=[*_STEP, "item", "value", "x", "y"])


def _excluded(steps: list[JsonObject], rules: Form) -> str:
    """Why a participant is excluded, or ""."""
    rated = [step for step in steps if step["step"] == "rate"]
    values = {row["value"] for step in rated for row in step["answer"]}
    least = rules["seconds_per_item"]
    if rules["incomplete"] and all(step["step"] != "end" for step in steps):
        return "not finished"
    if rules["same_answers"] and len(values) == 1:
        return "the same answer to every question"
    if any(step["seconds"] < least * len(step["answer"]) for step in rated):
        return f"less than {least:g} s per question"
    missed = [
        row["value"] for step in steps for row in step["answer"] if row["item"] == "missed_ms"
    ]
    if max(missed, default=0.0) > rules["missed_ms"]:
        return f"{max(missed):.0f} ms of a section were not played"
    return ""


def scores(kept: DataFrame, form: Form) -> DataFrame:
    """Each factor's mean of its items, and the rank of each condition, 1 the preferred one, as
    factor "(ranking)": (participants, (factor, condition)), of those who have finished. ``kept``:
    rows of `tidy`."""
    items = DataFrame(form["items"], columns=["factor", "text", "reversed"]).set_index("text")
    rated = kept[kept["step"] == "rate"].join(items, "item")
    ranked = kept[kept["step"] == "rank"].assign(
        factor="(ranking)", condition=lambda row: row["item"]
    )
    rows = pandas.concat([ranked, rated]).astype({"value": float})
    turned = form["scale"]["low"] + form["scale"]["high"] - rows["value"]
    rows["value"] = rows["value"].mask(rows["reversed"].eq(True), turned)
    factors = ["(ranking)", *items["factor"].unique()]
    means = rows.pivot_table("value", "participant", ["factor", "condition"])
    return means.reindex(
        columns=pandas.MultiIndex.from_product([factors, form["conditions"]])
    ).dropna()
