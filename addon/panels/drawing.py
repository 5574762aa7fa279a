"""Base class and drawing functions shared by panels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bpy.types import Context, Object, Panel, UILayout

from ..blender.words import show, ui_text
from ..changes.redraw import SIDEBAR_TAB
from ..scene_reader.roles import haptic_carrier
from ..session import sessions
from .texts import ICON, content_width, draw_sentence, fitted, lines


class SidebarPanel(Panel):
    """A panel in the add-on's tab of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = SIDEBAR_TAB


class ScenePanel(Panel):
    """A panel in Properties > Scene > Haptics, closed at first."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "scene"
    bl_parent_id = "HAPTIC_PT_settings"
    bl_ui_units_x = 14
    bl_options: Any = {"DEFAULT_CLOSED"}


class ObjectPanel(ScenePanel):
    """A panel in Properties > Object > Haptics."""

    bl_context = "object"
    bl_parent_id = "HAPTIC_PT_object_settings"


_SHOWN_PROBLEMS = 5
_SPLIT = 320.0
"""Width of a panel's content [points] from which on labels stand beside values."""


def poll_object(cls: type[Any], context: Context) -> bool:
    """There is an active object."""
    return context.object is not None


def select_button(layout: UILayout, name: str, text: str, **look: Any) -> None:
    """Draw a button with ``text`` that selects the object ``name``."""
    layout.operator("haptic.select_object", text=text, translate=False, **look).name = name


def settings_layout(panel: Any, is_animated: bool = False) -> UILayout:
    """The layout of a panel of settings: labels to the left of values where these have room beside
    them, else in them; with keyframe buttons if ``is_animated``."""
    layout: UILayout = panel.layout
    layout.use_property_split = content_width() >= _SPLIT
    layout.use_property_decorate = is_animated
    return layout


def draw_each(layout: UILayout, owner: Any, *names: str, **look: Any) -> None:
    """Draw properties one after the other."""
    for name in names:
        layout.prop(owner, name, **look)


def draw_properties(layout: UILayout, owner: Any, *names: str) -> None:
    """Draw properties as a block, one under the other."""
    draw_each(layout.column(align=True), owner, *names)


def draw_held(
    layout: UILayout, owner: Any, cls: type, **own: Callable[[UILayout], None] | None
) -> None:
    """Draw those properties of ``owner`` that hold fields of ``cls`` and are no hidden ones, in the
    order of the fields. ``own``: functions that draw some of them in another way, or None for those
    drawn elsewhere."""
    for key, name in owner.held.get(cls, {}).items():
        draw = own.get(key)
        if draw is not None:
            draw(layout)
        elif key not in own and not owner.bl_rna.properties[name].is_hidden:
            layout.prop(owner, name)


def draw_carrier(layout: UILayout, obj: Object, verb: str) -> None:
    """Draw the haptic object of a source or listener, or a warning if there is none."""
    carrier = haptic_carrier(obj)
    if carrier is None:
        warn(layout, "Not on a haptic object:", "make it haptic or parent it to one")
    elif carrier != obj:
        show(layout, f"{ui_text(verb)} {carrier.name}", "LINKED")


def draw_more(layout: UILayout, count: int) -> None:
    """Draw how many items are not shown."""
    if count > 0:
        show(layout, ui_text("and {} more", count))


def warn(layout: UILayout, *sentences: str) -> None:
    """Draw a warning, each of its parts from a new line on."""
    column = layout.column(align=True)
    found = [line for text in sentences for line in lines(ui_text(text), content_width() - ICON)]
    for number, line in enumerate(found):
        show(column, line, "ERROR" if number == 0 else "BLANK1")


def draw_problems(layout: UILayout, context: Context) -> None:
    """Draw the problems of the scene, each with a button that selects its object."""
    problems = sessions.shown_problems(context.scene)
    if not problems:
        return
    box = layout.box()
    box.label(
        text="1 problem" if len(problems) == 1 else ui_text("{} problems", len(problems)),
        icon="ERROR",
    )
    for problem in problems[:_SHOWN_PROBLEMS]:
        column = box.column(align=True)
        if problem.object:
            select_button(
                column,
                problem.object,
                fitted(problem.object, icon=True),
                icon="RESTRICT_SELECT_OFF",
            )
        draw_sentence(column, problem.message)
