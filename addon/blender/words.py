"""Texts in the language of Blender's interface, with values in their gaps."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface, pgettext_rpt
from bpy.types import UILayout


def report_text(words: str, *values: object) -> str:
    """A report or the message of an error."""
    translated = pgettext_rpt(words)
    return translated.format(*values) if values else translated


def ui_text(words: str, *values: object) -> str:
    """A text of the interface."""
    translated = pgettext_iface(words)
    return translated.format(*values) if values else translated


class TranslatedError(ValueError):
    """An error with a translated message: ``words``, with ``values`` in place of each {}."""

    def __init__(self, words: str, *values: object) -> None:
        super().__init__(report_text(words, *values))


def show(layout: UILayout, text: str, icon: str = "NONE") -> None:
    """Draw a name, or a text that is already in the language of the interface."""
    layout.label(text=text, icon=icon, translate=False)


def show_pair(layout: UILayout, name: str, value: str, share: float = 0.6) -> None:
    """Draw a name in its ``share`` of the width, and its value at the right; see `show`."""
    split = layout.split(factor=share)
    show(split, name)
    row = split.row()
    row.alignment = "RIGHT"
    show(row, value)
