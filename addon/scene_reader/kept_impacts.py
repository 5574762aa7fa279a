"""Impacts of a frame stored in a .blend, so that the file opens with its last result."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...core.contacts.impacts import Impact
from ...core.events.impacts import ActiveImpact
from ...core.events.one_shots import Shot
from ...core.events.stored import FrameEvents
from ...core.formats.io.schema import load_schema
from ...core.formats.io.strict_json import parse_json
from ...core.forms import JsonObject

_MOST_CHARACTERS = 2**16
"""Largest size of the text; more impacts are not stored."""


def text_of_impacts(frame: int, kept: FrameEvents, motion: str) -> str:
    """The text for `impacts_from_text` with the impacts of a frame, "" if there are none or too
    many; ``motion``: checksum of their causes."""
    impacts = [
        {
            **asdict(item.impact),
            "objects": [item.source.object, item.source.second_object],
            "local": [place.tolist() for place in item.local],
            "poses": poses.reshape(2, 12).tolist(),
        }
        for item, poses in zip(kept.impacts, kept.poses, strict=False)  # others are of what slides
    ]
    shots = {"shots": list(map(asdict, kept.shots))} if kept.shots else {}
    form = {"frame": frame, "start": kept.start, "motion": motion, "impacts": impacts, **shots}
    text = json.dumps(form, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text if (impacts or shots) and len(text) <= _MOST_CHARACTERS else ""


def impacts_from_text(
    text: str, frame: int, names: Sequence[str], motion: str
) -> FrameEvents | None:
    """The stored impacts of a frame; None if there are none, or if anything has changed since. The
    text may be untrusted: an invalid one counts as none."""
    form = _form(text)
    if form is None:
        return None
    row = {name: number for number, name in enumerate(names)}
    if (form["frame"], form["motion"]) != (frame, motion) or not all(
        name in row for item in form["impacts"] for name in item["objects"]
    ):
        return None
    sounding = tuple(_sounding(item, row) for item in form["impacts"])
    poses = np.array([item["poses"] for item in form["impacts"]], dtype=np.float64).reshape(
        -1, 2, 3, 4
    )
    shots = tuple(Shot(**item) for item in form.get("shots", ()))
    return FrameEvents(float(form["start"]), sounding, poses, shots) if sounding or shots else None


def _form(text: str) -> JsonObject | None:
    """The document that the text stores, None if it is invalid."""
    import fastjsonschema

    if not 0 < len(text) <= _MOST_CHARACTERS:
        return None
    try:
        document: JsonObject = parse_json(text.encode("utf-8", "surrogatepass"), "impacts")
        _validator()(document)
    except (ValueError, fastjsonschema.JsonSchemaValueException):
        return None
    return document


@cache
def _validator() -> Callable[[Any], Any]:
    import fastjsonschema

    schema = json.loads(Path(__file__).with_name("impacts.schema.json").read_text("utf-8"))
    handlers = {
        "https": lambda uri: load_schema(uri.rpartition("/")[2].removesuffix(".schema.json"))
    }
    validate: Callable[[Any], Any] = fastjsonschema.compile(schema, handlers, use_default=False)
    return validate


def _with_floats(value: Any) -> Any:
    """A JSON value with floats for integers and tuples for lists, at any depth."""
    if isinstance(value, list):
        return tuple(map(_with_floats, value))
    return float(value) if type(value) is int else value


def _sounding(item: JsonObject, row: dict[str, int]) -> ActiveImpact:
    first, second = item["objects"]
    values = {
        key: _with_floats(item[key])
        for key in ("time", "positions", "normal", "energy", "amplitude", "estimated")
    }
    on_first, on_second = (np.array(place, dtype=np.float64) for place in item["local"])
    return ActiveImpact.of(
        Impact((row[first], row[second]), **values), (first, second), (on_first, on_second)
    )
