"""The plan of a study with people, from the TOML file that a laboratory fills in."""

from __future__ import annotations

import hashlib
import json
import random
import shutil
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.formats.io.error import FormatError
from ...core.formats.io.json_text import write_json
from ...core.formats.io.schema import validate
from ...core.forms import Form, JsonObject
from .record import PLAN, read_plan

FORM = "study.toml"
_TEMPLATE = Path(__file__).with_name("template.toml")


def read_form(folder: Path) -> JsonObject:
    """The filled-in form of a study. Raises ValueError for what is missing; a folder without one
    gets the template."""
    path = folder / FORM
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(_TEMPLATE, path)
        raise ValueError(f"{path}: new; fill in the consent and the items of the questionnaire")
    try:
        form = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: not TOML: {error}") from None
    validate(form, "people_study", path)
    for name, scene in form["scenes"].items():
        if len({"sample", "blend", "tracks"} & scene.keys()) != 1:
            raise FormatError(path, f"/scenes/{name}", "has one of sample, blend and tracks")
    if form["scale"]["low"] >= form["scale"]["high"]:
        raise FormatError(path, "/scale/high", "must be above low")
    texts = [item["text"] for item in form["items"]]
    for number, text in enumerate(texts):
        if text in texts[:number]:  # answers are told apart by it
            raise FormatError(path, f"/items/{number}/text", "is there twice")
    return form


def stimuli(folder: Path, form: Form) -> dict[tuple[str, str], Path]:
    """The file of the tracks of each scene in each condition, and of the film of each scene, whose
    condition is "". What is rendered bears a digest of its settings in its name, so that other
    settings are rendered anew."""
    files = {}
    for name, scene in form["scenes"].items():
        if "film" in scene or "tracks" not in scene:
            shown = f"stimuli/{name}.{_digest(scene, form.get('film_settings'))}.webm"
            files[name, ""] = folder / scene.get("film", shown)
        stem = Path(scene.get("blend", scene.get("sample", ""))).stem
        for condition, settings in form["conditions"].items():
            baked = f"stimuli/{name}/{condition}.{_digest(scene, settings)}/{stem}.wav"
            files[name, condition] = folder / scene.get("tracks", {}).get(condition, baked)
    return files


def _digest(*settings: Any) -> str:
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:8]


def begin(
    folder: Path,
    form: Form,
    participants: int,
    listeners: Sequence[str],
    levels: Mapping[str, Mapping[str, Sequence[float]]],
) -> JsonObject:
    """The plan of the folder, written once, with an order for each of the ``participants``; later
    ones may be added, and nothing else may change.

    Args:
        folder: Of the study.
        form: As `read_form` gives it.
        participants: How many there are to be.
        listeners: Body parts of the tracks.
        levels: RMS by condition, scene and listener.

    Raises:
        ValueError: the form or a track has changed since the study began.
    """
    path = folder / PLAN
    before = read_plan(folder) if path.exists() else {"form": form, "levels": levels, "orders": {}}
    for now, then, what in (
        (form, before["form"], f"{folder / FORM}: has"),
        (levels, before["levels"], f"{folder}: the tracks have"),
    ):
        if now != then:
            raise ValueError(
                f"{what} changed since the study began; put back what was there, or begin another "
                "study in another folder"
            )
    count = max(participants, len(before["orders"]))
    plan = {
        "format": "haptic-study",
        "version": 1,
        "form": form,
        "listeners": listeners,
        "levels": levels,
        "orders": orders(form["conditions"], form["scenes"], count, form.get("seed", 0)),
    }
    write_json(path, plan)
    return plan


def orders(
    conditions: Iterable[str], scenes: Iterable[str], participants: int, seed: int
) -> dict[str, JsonObject]:
    """For each participant the order of conditions, and that of scenes within each of them. The
    first participants' are the same however many there are."""
    rows, sections = _rows(conditions, f"conditions {seed}"), _rows(scenes, f"scenes {seed}")
    found = {}
    for number in range(participants):
        row = next(rows)
        within = [next(sections) for _ in row]
        found[f"P{number + 1:02}"] = {"conditions": row, "scenes": within}
    return found


def _rows(names: Iterable[str], seed: str) -> Iterator[list[str]]:
    """The rows of one shuffled square after another."""
    generator, chosen = random.Random(seed), list(names)
    while True:
        yield from shuffled_square(chosen, generator)


def shuffled_square(names: Sequence[str], generator: random.Random) -> list[list[str]]:
    """Rows of a balanced Latin square of the names (E. J. Williams, Aust. J. Sci. Res. A 2 (1949)
    149), in random order: each name stands at each place, and follows each other one, equally
    often. An odd number of names takes twice as many rows."""
    names, count = generator.sample(names, len(names)), len(names)
    first = [(k + 1) // 2 if k % 2 else -(k // 2) for k in range(count)]
    rows = [[names[(place + shift) % count] for place in first] for shift in range(count)]
    if count % 2:
        rows += [row[::-1] for row in rows]
    return generator.sample(rows, len(rows))
