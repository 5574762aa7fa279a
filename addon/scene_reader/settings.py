"""The settings of tracing, from a scene's properties."""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import Any

from bpy.types import Scene

from ...core.contacts.settings import ContactSettings
from ...core.scene.choices import Mode, Strategy
from ...core.scene.rules import ImpactEnergy
from ...core.scene.values import Settings
from ..blender.single_precision import shortest
from .imported import OF_PROPAGATION, RULES, Imported, exact, imported_scene
from .rules import TEMPLATES

_CHOICES = ("mode", "strategy", "max_connections", "impact_energy", "impacts", "impact_signal", "imported")
_HAPTICS = attrgetter(*_CHOICES, *OF_PROPAGATION, *RULES)


def setting_values(scene: Scene) -> tuple[Any, ...]:
    """All values that determine the settings, except the tables."""
    time_scale = None if scene.rigidbody_world is None else scene.rigidbody_world.time_scale
    return *_HAPTICS(scene.haptics), *scene.gravity, scene.use_gravity, time_scale, scene.animation_data is None


def read_settings(scene: Scene) -> Settings:
    """The propagation settings of a scene."""
    haptics, imported = scene.haptics, _imported(scene)
    return Settings(
        mode=Mode(haptics.mode),
        strategy=Strategy(haptics.strategy),
        max_connections=haptics.max_connections or None,
        **{name: exact(haptics, name, imported.numbers) for name in OF_PROPAGATION},
        **({} if imported.tolerance is None else {"tolerance": imported.tolerance}),
    )


def read_contact_settings(scene: Scene, tables: Mapping[str, Any]) -> ContactSettings:
    """The settings of contacts and impacts of a scene with these tables, see `rules.read_tables`."""
    haptics, imported = scene.haptics, _imported(scene)
    x, y, z = (shortest(g) for g in scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)
    numbers: dict[str, Any] = {name: exact(haptics, own, imported.numbers) for own, name in RULES.items()}
    numbers["full_energy"] = max(numbers["full_energy"], 1e-3)
    if imported.slack is not None:
        numbers["slack"] = imported.slack
    return ContactSettings(
        **numbers,
        energy=ImpactEnergy(haptics.impact_energy),
        gravity=(x, y, z),
        time_scale=max(shortest(scene.rigidbody_world.time_scale), 1e-3) if scene.rigidbody_world is not None else 1.0,
        impacts=haptics.impacts,
        templates=TEMPLATES[haptics.impact_signal],
        **tables,
    )


def _imported(scene: Scene) -> Imported:
    try:
        return imported_scene(scene.haptics.imported)
    except ValueError:  # the reader reports it
        return Imported()
