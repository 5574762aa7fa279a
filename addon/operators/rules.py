"""Operators that edit the tables of rules of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bpy.types import Context

from ...core.scene.materials import texture_in
from ..blender.polling import Edit
from ..changes.revisions import SCENE, mark_changed
from ..properties.kinds import choice
from ..properties.rules import TABLES


class _OfTable:
    """Mixin: an operator on one of the tables."""

    table: choice("Table", "The table of the scene", TABLES, options={"HIDDEN"})

    def _rows(self, context: Context) -> Any:
        return getattr(context.scene.haptics, self.table)


class HAPTIC_OT_add_rule(_OfTable, Edit):
    """Add a rule for just the two selected objects; else for the material of the active object, for that object, or for anything"""

    bl_label = "Add Rule"

    def apply(self, context: Context) -> None:
        # The tab Scene of Properties has no `context.object`.
        rows = self._rows(context)
        obj = context.view_layer.objects.active
        row = rows.items.add()
        pair = sorted(item.name_full for item in context.selected_objects if item.haptics.enabled)
        if len(pair) == 2:
            row.first_kind = row.second_kind = "OBJECT"
            row.first, row.second = pair
        elif obj is not None and obj.haptics.enabled:
            material = obj.haptics.material.name
            row.first_kind, row.first = (
                ("MATERIAL", material) if material else ("OBJECT", obj.name_full)
            )
            if self.table == "textures":
                _write_texture(row, texture_in(material))
        rows.active = len(rows.items) - 1
        mark_changed((SCENE,))


class HAPTIC_OT_add_textures(Edit):
    """Add a rule with the library's texture for each material that haptic objects are made of and that has none"""

    bl_label = "Textures of Materials"

    def apply(self, context: Context) -> set[str]:
        rows = context.scene.haptics.textures
        named = {
            row.first
            for row in rows.items
            if row.first_kind == "MATERIAL" and row.second_kind == "ANY"
        }
        made_of = {
            obj.haptics.material.name for obj in context.scene.objects if obj.haptics.enabled
        } - named
        textures = {name: texture for name in sorted(made_of) if (texture := texture_in(name))}
        if not textures:
            self.tell(
                "Nothing else is made of a material with a texture; choose materials first, "
                "or add a rule"
            )
            return {"CANCELLED"}
        for name in sorted(
            textures, key=lambda name: -textures[name]["period"]
        ):  # the upper row counts: of two surfaces the coarser
            row = rows.items.add()
            row.first_kind, row.first = "MATERIAL", name
            _write_texture(row, textures[name])
        rows.active = len(rows.items) - 1
        mark_changed((SCENE,))
        return {"FINISHED"}


def _write_texture(row: Any, texture: Mapping[str, float]) -> None:
    for name, value in texture.items():
        setattr(row, name, value)


class HAPTIC_OT_remove_rule(_OfTable, Edit):
    """Remove the active rule"""

    bl_label = "Remove Rule"

    def apply(self, context: Context) -> None:
        rows = self._rows(context)
        rows.items.remove(rows.active)
        rows.active = max(0, min(rows.active, len(rows.items) - 1))
        mark_changed((SCENE,))
