"""The settings of tracing, from a scene's properties."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from operator import attrgetter
from typing import Any

from bpy.types import Scene

from ...core.contacts.settings import ContactSettings
from ...core.scene.choices import Mode, Strategy
from ...core.scene.rules import ImpactEnergy
from ...core.scene.values import Settings
from ..blender.single_precision import shortest
from .imported import Imported, exact, imported_scene
from .rules import TEMPLATES

_HAPTICS = attrgetter(
    *("mode", "strategy", "max_connections", "threshold", "epsilon", "localise", "contact_tolerance", "minimum_energy", "maximum_energy"),
    *("impact_energy", "refractory_time", "patch_points", "impacts", "impact_signal", "imported"),
)


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
        threshold=exact(haptics, "threshold", imported.numbers),
        epsilon=exact(haptics, "epsilon", imported.numbers),
        localise=exact(haptics, "localise", imported.numbers),
        **({} if imported.tolerance is None else {"tolerance": imported.tolerance}),
    )


def read_contact_settings(scene: Scene, tables: Mapping[str, Any]) -> ContactSettings:
    """The settings of contacts and impacts of a scene with these tables, see `rules.read_tables`."""
    haptics, imported = scene.haptics, _imported(scene)
    x, y, z = (shortest(g) for g in scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)
    settings = ContactSettings(
        tolerance=exact(haptics, "contact_tolerance", imported.numbers),
        least_energy=exact(haptics, "minimum_energy", imported.numbers),
        full_energy=max(exact(haptics, "maximum_energy", imported.numbers), 1e-3),
        energy=ImpactEnergy(haptics.impact_energy),
        refractory=exact(haptics, "refractory_time", imported.numbers),
        patch_points=haptics.patch_points,
        gravity=(x, y, z),
        time_scale=max(shortest(scene.rigidbody_world.time_scale), 1e-3) if scene.rigidbody_world is not None else 1.0,
        impacts=haptics.impacts,
        templates=TEMPLATES[haptics.impact_signal],
        **tables,
    )
    return settings if imported.slack is None else replace(settings, slack=imported.slack)


def _imported(scene: Scene) -> Imported:
    try:
        return imported_scene(scene.haptics.imported)
    except ValueError:  # the reader reports it
        return Imported()
