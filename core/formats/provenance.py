"""What an export says of its origin: program, version, settings and the scene's digest; and the
paragraph of a paper about it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace

from .. import __version__
from ..forms import Form, JsonObject
from ..scene.values import MODES, STRATEGIES, HapticScene, Settings, Strategy
from .io.json_text import compact
from .scene.scene_json import scene_to_dict
from .tracks.listener_tracks import Tracks
from .tracks.track_export import EDITOR

FULL_ENERGY = "that of the heaviest moving body after a fall of half a metre on"


def provenance_of(scene: HapticScene | None) -> JsonObject:
    """Program and version, and of a scene its settings of propagation and its digest: the first 12
    hexadecimal digits of the SHA-256 of its JSON without spaces and extras."""
    program = {"program": EDITOR, "version": __version__}
    if scene is None:
        return program
    document = scene_to_dict(replace(scene, extras={}))
    digest = hashlib.sha256(_in_one_form(document).encode()).hexdigest()
    return {**program, **document["settings"], "scene": digest[:12]}


def _in_one_form(document: Form) -> str:
    """JSON text that is the same whether a number is written as 1 or as 1.0."""
    return compact(json.loads(compact(document), parse_int=float))


def methods(provenance: Form, scene: HapticScene, tracks: Tracks | None) -> str:
    """A paragraph on how the tracks were made, for the methods section of a paper."""
    settings, rules = scene.settings, scene.rules
    counts = ", ".join(
        f"{len(items)} {word}{'' if len(items) == 1 else 's'}"
        for items, word in (
            (scene.objects, "object"),
            (scene.sources, "source"),
            (scene.listeners, "listener"),
        )
    )
    title, meaning = MODES[settings.mode]
    text = (
        f"Vibration was rendered with {EDITOR} {provenance['version']} from a scene of {counts} "
        f"(SHA-256 {provenance['scene']}...). The mode was {settings.mode} ({title}: "
        f"{_lowered(meaning)})."
    )
    if settings.mode == "HT":
        text += f" {_propagation(settings)} Objects within {1000 * rules.tolerance:g} mm touched."
        if rules.impacts:
            limits = rules.limits
            full = f"{limits.full_energy:g} J on" if limits.full_energy else FULL_ENERGY
            text += (
                f" Collisions of {limits.least_energy:g} J or more were impacts, at full amplitude "
                f"from {full}, and at most one of a pair in {limits.refractory:g} s."
            )
    if tracks is not None:
        text += f" Each listener's signal has {tracks.duration:g} s at {tracks.sample_rate:,} Hz."
    return text


def _propagation(settings: Settings) -> str:
    name, meaning = STRATEGIES[settings.strategy]
    limits = f"ε = {settings.epsilon:g} 1/m"
    if settings.strategy is Strategy.AS_IN_THE_PAPER:
        if settings.max_connections is not None:
            limits += f", at most {settings.max_connections} connections"
        if settings.threshold:
            limits += f", paths ended below a gain of {settings.threshold:g}"
    return f"Gains were computed by the strategy {name} ({_lowered(meaning)}; {limits})."


def _lowered(text: str) -> str:
    return text[0].lower() + text[1:]
