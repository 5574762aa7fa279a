"""The tables of rules of a scene, from its properties."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Scene

from ...core.formats import registry
from ...core.forms import JsonObject
from ...core.scene.impact_rule import ImpactLimits, ImpactRule, ImpactTemplates
from ...core.scene.rule_table import MOST_ROWS, Rule, RuleTable, Side
from ...core.scene.texture import Texture
from ...core.scene.values import HapticObject
from ...core.signals import LONGEST, Signal
from ..blender.paths import local_path
from ..properties.declared import identifier, read_values
from .drawings import read_drawing
from .functions import read_transmission
from .problem import Problem

_ABSENT = {
    "OBJECT": "there is no haptic object '{}'",
    "MATERIAL": "nothing is made of a material '{}'",
}


def read_tables(scene: Scene, objects: Iterable[HapticObject]) -> tuple[JsonObject, list[Problem]]:
    """The tables of rules of a scene, by their names in `ContactSettings`, and the problems of
    their rows. ``objects``: the haptic objects, which rows may name."""
    known = [(item.name, item.material) for item in objects] + [
        ("", item.name) for item in scene.haptics.materials.items
    ]
    tables: JsonObject = {}
    problems = []
    for table, read in _READERS.items():
        rules: list[Rule[Any]] = []
        for index, row in enumerate(islice(getattr(scene.haptics, table).items, MOST_ROWS)):
            between, faults = _between(row, known)
            value, fault = read(row)
            problems += [
                Problem("", message, (table, index)) for message in (*faults, fault) if message
            ]
            if between is not None:
                rules.append(Rule(between, value))
        tables[table] = RuleTable(tuple(rules))
    return tables, problems


def _between(
    row: Any, known: Iterable[tuple[str, str]]
) -> tuple[tuple[Side, Side] | None, list[str]]:
    """The two sides of contacts that a row applies to, None until both are chosen, and the faults
    of sides that fit none of the ``known`` names and materials."""
    chosen = [
        side
        for side in ((row.first_kind, row.first), (row.second_kind, row.second))
        if side[0] != "ANY"
    ]
    sides = [
        Side(object=name) if kind == "OBJECT" else Side(material=name) for kind, name in chosen
    ]
    absent = [
        side
        for side, means in zip(chosen, sides, strict=True)
        if not any(means.fits(*item) for item in known)
    ]
    faults = [iface_(_ABSENT[kind]).format(name) for kind, name in absent]
    if not all(name for _, name in chosen):
        return None, [*faults, iface_("choose what this rule is for")]
    first, second = (*sides, Side(), Side())[:2]
    return (first, second), faults


def read_impact_rule(row: Any) -> tuple[ImpactRule, str]:
    """The impact rule of a row, and why its signal cannot be played, "" if it can. A rule whose
    signal cannot be played has the one by material."""
    limits = ImpactLimits(**read_values(ImpactLimits, row)) if row.full_energy else None
    template, fault = ImpactRule().template, ""
    try:
        template = ImpactRule(_template(row)).template
    except (OSError, ValueError) as error:
        fault = str(error)
    return ImpactRule(template=template, limits=limits, **read_values(ImpactRule, row)), fault


def read_texture(row: Any) -> tuple[Texture, str]:
    """The texture of a row for sliding and rolling."""
    return Texture(**read_values(Texture, row)), ""


_READERS: dict[str, Callable[[Any], tuple[Any, str]]] = {
    "impact_table": read_impact_rule,
    "transmission_table": read_transmission,
    "textures": read_texture,
}
"""By table, the function from a row to its value and its fault, "" for none."""


def _template(row: Any) -> ImpactTemplates | Signal:
    if row.template == "DRAWN":
        return replace(read_drawing(row.drawing), loops=False).to_signal()
    if row.template != "FILE":
        return next(
            template for template in ImpactTemplates if identifier(template) == row.template
        )
    if not row.filepath:
        raise ValueError(iface_("its signal is a file, but none is chosen"))
    path = local_path(row.filepath, row.id_data)
    if not path.is_file():
        raise ValueError(iface_("there is no file {}").format(path))
    state = path.stat()
    return _read(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=16)
def _read(path: Path, changed: int, size: int) -> Signal:
    """The first vibration in a file with the modification time ``changed``."""
    channels = registry.read(path).channels
    if not channels:
        raise ValueError(iface_("there is no vibration in {}").format(path.name))
    if channels[0].duration > LONGEST:
        raise ValueError(iface_("{} lasts longer than a minute").format(path.name))
    return channels[0].to_signal()
