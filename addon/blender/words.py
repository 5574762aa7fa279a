"""Texts in the language of Blender's interface, with values in their gaps."""

from __future__ import annotations

from bpy.app.translations import pgettext_rpt


def told(words: str, *values: object) -> str:
    """A report or the message of an error."""
    translated = pgettext_rpt(words)
    return translated.format(*values) if values else translated
