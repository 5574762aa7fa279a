"""Lists of the tables of rules of a scene."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, UILayout, UIList

from ..blender.words import show, ui_text
from ..properties.rules import SIDE_ITEMS
from ..session import sessions
from .texts import draw_sentence

_ICONS = {kind: icon for kind, _, _, icon, _ in SIDE_ITEMS}
_FIELDS = {"OBJECT": "objects", "MATERIAL": "items"}


class HAPTIC_UL_rules(UIList):
    """The rules of a table, each with its two sides."""

    def draw_item(  # type: ignore[override]  # the filter flags, which Blender passes last, may be left out
        self,
        context: Context,
        layout: UILayout,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
        index: int = 0,
    ) -> None:
        row = layout.row(align=True)
        for kind, name in ((item.first_kind, item.first), (item.second_kind, item.second)):
            show(row, ui_text("Anything") if kind == "ANY" else name, _ICONS[kind])
        table = data.path_from_id().rpartition(".")[2]
        if _problems(context, table, index):
            row.label(icon="ERROR")


def draw_table(layout: UILayout, context: Context, table: str) -> Any:
    """Draw a table of the scene and the two sides of its active rule. Returns that rule, None if
    there is none."""
    rows = getattr(context.scene.haptics, table)
    row = layout.row()
    row.template_list("HAPTIC_UL_rules", table, rows, "items", rows, "active", rows=3)
    side = row.column(align=True)
    side.operator("haptic.add_rule", text="", icon="ADD").table = table
    if not 0 <= rows.active < len(rows.items):
        return None
    side.operator("haptic.remove_rule", text="", icon="REMOVE").table = table
    for problem in _problems(context, table, rows.active):
        draw_sentence(layout, problem, "ERROR")
    rule = rows.items[rows.active]
    for end, kind in (("first", rule.first_kind), ("second", rule.second_kind)):
        column = layout.column(align=True)
        column.prop(rule, f"{end}_kind")
        if kind != "ANY":
            owner = context.scene if kind == "OBJECT" else context.scene.haptics.materials
            column.prop_search(
                rule,
                end,
                owner,
                _FIELDS[kind],
                text="",
                translate=False,
                icon=_ICONS[kind],
                results_are_suggestions=True,
            )
    return rule


def _problems(context: Context, table: str, index: int) -> list[str]:
    """The faults of a row."""
    return [
        problem.message
        for problem in sessions.shown_problems(context.scene)
        if problem.rule == (table, index)
    ]
