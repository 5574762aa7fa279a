"""The settings of tracing, from a scene's properties."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from typing import Any

from bpy.types import Scene

from ...core.contacts.settings import ContactSettings
from ...core.forms import Form
from ...core.scene.impact_rule import ImpactTemplates
from ...core.scene.rule_table import RuleTable
from ...core.scene.values import HapticObject, Settings, Vector
from ..blender.single_precision import shortest
from ..blender.units import metres_per_unit
from ..properties.declared import read_values
from .joints import joints_of
from .linkage import constraints_of
from .problem import Problem
from .rules import read_tables


class SceneSettings:
    """The settings and rules of a scene, read again where they have changed. ``problems``: of the
    rules."""

    def __init__(self) -> None:
        self.settings = Settings()
        self.contact_settings = ContactSettings()
        self.problems: list[Problem] = []
        self._values: tuple[Any, ...] | None = None  # that they were read from
        self._tables: Form | None = None

    def forget_rules(self) -> None:
        """Read settings and rules again."""
        self._tables = None

    def follow(self, scene: Scene, objects: Sequence[HapticObject], solo: Set[str]) -> None:
        """Read them if they have changed. ``objects``: that rules may be about; ``solo``: roles
        with a solo object: beside a solo source nothing strikes, slides or rolls."""
        values = setting_values(scene)
        if self._tables is None:
            self._tables, self.problems = read_tables(scene, objects)
        elif values == self._values:
            return
        self.settings = read_settings(scene)
        self.contact_settings = read_contact_settings(scene, self._tables)
        if "source" in solo:
            self.contact_settings = replace(
                self.contact_settings, impacts=False, textures=RuleTable()
            )
        self._values = values


def setting_values(scene: Scene) -> tuple[Any, ...]:
    """All values that determine the settings, except the tables."""
    haptics: Any = scene.haptics
    names = (name for cls in (Settings, ContactSettings) for name in haptics.held[cls].values())
    time_scale = None if scene.rigidbody_world is None else scene.rigidbody_world.time_scale
    return (
        *(getattr(haptics, name) for name in names),
        *scene.gravity,
        scene.use_gravity,
        time_scale,
    )


def read_settings(scene: Scene) -> Settings:
    """The propagation settings of a scene."""
    return Settings(**read_values(Settings, scene.haptics))


def read_contact_settings(scene: Scene, tables: Form) -> ContactSettings:
    """The settings of contacts and impacts of a scene with these tables, see
    `rules.read_tables`."""
    values = read_values(ContactSettings, scene.haptics)
    values["templates"] = ImpactTemplates.BY_MATERIAL
    values["gravity"] = gravity_of(scene)
    values["passing"] = tuple(sorted(_passing(scene)))
    values["joints"] = joints_of(scene)
    if scene.rigidbody_world is not None:
        values["time_scale"] = max(shortest(scene.rigidbody_world.time_scale), 1e-3)
    return ContactSettings(**{**values, **tables})


def _passing(scene: Scene) -> set[tuple[str, str]]:
    """Pairs of objects, by name, that strike nothing of each other: rigid bodies that a constraint
    with *Disable Collisions* joins, which Blender lets pass through each other also where the
    constraint is not enabled, or broken; and what a bone carries, as a boot, and the skin that the
    bones move."""
    joined = {
        (joint.object1.name_full, joint.object2.name_full)
        for _, joint in constraints_of(scene)
        if joint.disable_collisions
    }
    carried = [obj for obj in scene.objects if obj.parent_type == "BONE" and obj.parent]
    moving = {obj.parent for obj in carried}
    skins = [(obj, obj.find_armature()) for obj in scene.objects if moving and obj.type == "MESH"]
    return joined | {
        (obj.name_full, skin.name_full)
        for obj in carried
        for skin, armature in skins
        if armature == obj.parent and obj != skin
    }


def gravity_of(scene: Scene) -> Vector:
    """Gravity [m/s²] as dynamic bodies feel it."""
    if not scene.use_gravity:
        return 0.0, 0.0, 0.0
    metres = metres_per_unit(scene)
    x, y, z = (float(f"{shortest(value) * metres:.7g}") for value in scene.gravity)
    return x, y, z
