"""A designer's formula in a panel, with its fault and a mark below the place."""

from __future__ import annotations

from typing import Any

import blf
from bpy.types import UILayout

from ...core.scene import functions
from ..blender.words import show
from ..translations.sentences import sentence
from .drawing import draw_held
from .texts import draw_lines, font_size, ui_scale


def draw_parameters(layout: UILayout, group: Any, on_contact: bool = False) -> None:
    """Draw the parameters of the function that is chosen in ``group``; a formula takes the whole
    width and shows its fault. ``on_contact``: it is a function of contacts."""
    if group.function == "expression":
        row = layout.row()
        row.use_property_split = False
        row.prop(group, "expression", text="")
        draw_finding(
            layout, group.expression, functions.check_expression(group.expression, on_contact)
        )
        return
    draw_held(layout, group, functions.TRANSMISSIONS[group.function])


def draw_finding(
    layout: UILayout, source: str, finding: functions.Finding | None
) -> functions.Finding | None:
    """Draw and return the fault of a formula, if there is one."""
    if finding is None:
        return None
    box = layout.box()
    column = box.column(align=True)
    column.scale_y = 0.8
    column.alert = not finding.usable
    if finding.column is not None:
        shown, place = functions.excerpt(source, finding.column)
        show(column, shown)
        show(column, " " * spaces_under(shown, place) + "^")
    draw_lines(column, sentence(finding.message), "INFO" if finding.usable else "ERROR")
    return finding


def spaces_under(shown: str, place: int) -> int:
    """Number of spaces as wide as the text up to the middle of the character at ``place``, in the
    proportional font of panels."""
    blf.size(0, font_size() * ui_scale())
    space = (_width("x" + " " * _MANY + "x") - _width("xx")) / _MANY
    middle = (_width(shown[:place]) + _width(shown[: place + 1]) - _width("^")) / 2
    return max(round(middle / space), 0) if space > 0 else place


_MANY = 40  # many at once, because widths are whole pixels


def _width(text: str) -> float:
    """Width of a text including trailing spaces, which `blf` ignores."""
    return blf.dimensions(0, text + "|")[0] - blf.dimensions(0, "|")[0]
