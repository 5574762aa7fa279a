"""Base class and drawing functions shared by panels."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Object, UILayout

from ..blender.documentation import page_url
from ..changes.redraw import SIDEBAR_TAB
from ..scene_reader.roles import haptic_carrier
from ..session import sessions
from .texts import draw_sentence, fitted

if TYPE_CHECKING:
    from ..view.levels import Level


class HapticsPanel:
    """Mixin: a panel in the add-on's tab of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = SIDEBAR_TAB

    def draw_header_preset(self: Any, context: Context) -> None:
        """Draw the button that opens the panel's page of the documentation."""
        module = type(self).__module__.rpartition(".")[2]
        self.layout.operator("wm.url_open", text="", icon="HELP", emboss=False).url = page_url(
            _PAGES.get(module, f"panels/{module}")
        )


class ClosedPanel(HapticsPanel):
    """Mixin: such a panel, closed at first."""

    bl_options: Any = {"DEFAULT_CLOSED"}


_SHOWN_PROBLEMS = 5
_PAGES = {
    "live_output": "devices",
    "export": "formats",
    "gltf": "formats",
    "modalities": "panels/warmth",
}
"""Documentation pages by panel module, if they differ from the module's name."""


def poll_object(cls: type[Any], context: Context) -> bool:
    """There is an active object."""
    return context.object is not None


def select_button(layout: UILayout, name: str, text: str, **look: Any) -> None:
    """Draw a button with ``text`` that selects the object ``name``."""
    layout.operator("haptic.select_object", text=text, translate=False, **look).name = name


def settings_layout(panel: Any) -> UILayout:
    """The layout of a panel of settings: labels to the left of values, without keyframe buttons."""
    layout: UILayout = panel.layout
    layout.use_property_split = True
    layout.use_property_decorate = False
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
    """Draw the properties that ``owner`` has of the fields of ``cls``, in the order of the fields:
    some by functions of their ``own``, and not those with None, which stand elsewhere."""
    for key, name in owner.held.get(cls, {}).items():
        draw = own.get(key)
        if draw is not None:
            draw(layout)
        elif key not in own:
            layout.prop(owner, name)


def draw_level(layout: UILayout, level: Level, share: float, text: str) -> None:
    """Draw a listener's name on a ``share`` of the width, which selects it, and its level as a bar
    with ``text``."""
    split = layout.split(factor=0.5)
    row = split.row()
    row.alignment = "LEFT"
    select_button(
        row,
        level.listener,
        fitted(level.listener, share, icon=True),
        icon="OUTLINER_OB_LIGHTPROBE",
        emboss=False,
    )
    split.progress(factor=level.place, text=text)


def draw_carrier(layout: UILayout, obj: Object, verb: str) -> None:
    """Draw the haptic object of a source or listener, or a warning if there is none."""
    carrier = haptic_carrier(obj)
    if carrier is None:
        warn(layout, "Not on a haptic object:", "make it haptic or parent it to one")
    elif carrier != obj:
        layout.label(text=f"{iface_(verb)} {carrier.name}", icon="LINKED", translate=False)


def draw_pair(layout: UILayout, name: str, value: str, share: float = 0.6) -> None:
    """Draw a name in its ``share`` of the width, and its value at the right."""
    split = layout.split(factor=share)
    split.label(text=name)
    row = split.row()
    row.alignment = "RIGHT"
    row.label(text=value)


def warn(layout: UILayout, *lines: str) -> None:
    """Draw a warning in several lines."""
    column = layout.column(align=True)
    for number, line in enumerate(lines):
        column.label(text=line, icon="ERROR" if number == 0 else "BLANK1")


def draw_problems(layout: UILayout, context: Context) -> None:
    """Draw the problems of the scene, each with a button that selects its object."""
    problems = sessions.shown_problems(context.scene)
    if not problems:
        return
    box = layout.box()
    box.label(
        text="1 problem" if len(problems) == 1 else iface_("{} problems").format(len(problems)),
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
