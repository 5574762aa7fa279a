"""The add-on's texts in other languages. The code and Blender's own fallback are in English; every other language is a module with MESSAGES."""

from __future__ import annotations

import bpy

# Blender looks texts of buttons for operators up in a context of their own. "Haptics" is for words that Blender translates in another sense.
_CONTEXTS = ("*", "Operator", "Haptics")
_NAME = __package__


def _dictionary() -> dict[str, dict[tuple[str, str], str]]:
    """By locale: Blender's form."""
    from . import german

    messages = {(context, text): words for text, words in german.MESSAGES.items() for context in _CONTEXTS}
    return {"de_DE": messages, "de": messages}


def register() -> None:
    bpy.app.translations.register(_NAME, _dictionary())


def unregister() -> None:
    bpy.app.translations.unregister(_NAME)
