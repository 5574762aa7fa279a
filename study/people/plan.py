"""The plan of a study with people, from the TOML file that a laboratory fills in."""

from __future__ import annotations

import hashlib
import json
import random
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...core.formats.io.error import FormatError
from ...core.formats.io.json_text import write_json
from ...core.formats.io.schema import validate
from ...core.forms import Form, JsonObject
from .record import PLAN, read_plan

FORM = "study.toml"
HERE = Path(__file__).parent


def read_form(folder: Path) -> JsonObject:
    """The filled-in form of a study. Raises ValueError for what is missing; a folder without one
    gets the template."""
    path = folder / FORM
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(HERE / "template.toml", path)
        raise ValueError(f"{path}: new; fill in the consent and the items of the questionnaire")
    try:
        form = tomllib.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: not TOML: {error}") from None
    validate(form, "people_study", path)
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
    listeners: list[str],
    levels: Form,
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
    plan: JsonObject = {
        "format": "haptic-study",
        "version": 2,
        "form": form,
        "listeners": listeners,
        "levels": levels,
        "orders": {},
    }
    path = folder / PLAN
    before = read_plan(folder) if path.exists() else plan
    if before != {**plan, "orders": before["orders"]}:
        raise ValueError(
            f"{folder}: {FORM} or the tracks have changed since the study began; put them back, "
            "or begin another study in another folder"
        )
    count = max(participants, len(before["orders"]))
    plan["orders"] = orders(form, count)
    write_json(path, plan)
    return plan


def orders(form: Form, participants: int) -> dict[str, list[JsonObject]]:
    """The steps of each participant, with conditions and the scenes within each of them in balanced
    orders. The first participants' are the same however many there are."""
    seed = form.get("seed", 0)
    rows = balanced_rows([*form["conditions"]], f"conditions {seed}")
    sections = balanced_rows([*form["scenes"]], f"scenes {seed}")
    found = {}
    for number in range(participants):
        order = next(rows)
        steps: list[JsonObject] = [{"step": name} for name in ("consent", "about", "start")]
        for position, condition in enumerate(order):
            ride = {"condition": condition, "position": position + 1}
            for scene in next(sections):
                steps += [{"step": name, **ride, "scene": scene} for name in ("play", "place")]
            steps.append({"step": "rate", **ride})
        steps += [{"step": "rank", "conditions": order}, {"step": "words"}, {"step": "end"}]
        found[f"P{number + 1:02}"] = steps
    return found


def balanced_rows(names: list[str], seed: str) -> Iterator[list[str]]:
    """The rows of one balanced Latin square of the names after another (E. J. Williams, Aust. J.
    Sci. Res. A 2 (1949) 149), in random order: in each square every name stands at each place, and
    follows each other one, equally often. An odd number of names takes twice as many rows."""
    generator, count = random.Random(seed), len(names)
    first = [(k + 1) // 2 if k % 2 else -(k // 2) for k in range(count)]
    while True:
        chosen = generator.sample(names, count)
        rows = [[chosen[(place + shift) % count] for place in first] for shift in range(count)]
        if count % 2:
            rows += [row[::-1] for row in rows]
        yield from generator.sample(rows, len(rows))
