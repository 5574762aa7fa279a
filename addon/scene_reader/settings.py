"""How a scene is traced, from its properties."""

from __future__ import annotations

from bpy.types import Scene

from ...core.contacts.tracker import ContactSettings
from ...core.scene.values import Settings
from ..blender.single_precision import shortest
from .imported import ImportedScene, exact, imported_scene


def read_settings(scene: Scene) -> Settings:
    """The propagation settings of a scene."""
    haptics = scene.haptics
    try:
        imported = imported_scene(haptics.imported)
    except ValueError:  # the reader says it
        imported = ImportedScene()
    return Settings(
        mode=haptics.mode,
        strategy=haptics.strategy,
        max_connections=haptics.max_connections or None,
        threshold=exact(haptics, "threshold", imported.numbers),
        epsilon=exact(haptics, "epsilon", imported.numbers),
        localise=exact(haptics, "localise", imported.numbers),
        **({} if imported.tolerance is None else {"tolerance": imported.tolerance}),
    )


def read_contact_settings(scene: Scene) -> ContactSettings:
    """What counts as a contact and as an impact in a scene."""
    haptics = scene.haptics
    return ContactSettings(
        tolerance=shortest(haptics.contact_tolerance),
        least_energy=shortest(haptics.minimum_energy),
        full_energy=max(shortest(haptics.maximum_energy), 1e-3),
        energy=haptics.impact_energy,
        refractory=shortest(haptics.refractory_time),
        patch_points=haptics.patch_points,
        gravity=tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0),
        time_scale=max(scene.rigidbody_world.time_scale, 1e-3) if scene.rigidbody_world is not None else 1.0,
    )
