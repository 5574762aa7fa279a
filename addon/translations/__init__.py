"""The add-on's texts in other languages. The code and Blender's own fallback are in English; every other language is a module with MESSAGES
(by English text) and SENTENCES (by cause)."""

from __future__ import annotations

import bpy

from ...core.sentences import ENGLISH
from . import german

# Blender looks texts of buttons for operators up in a context of their own. "Haptics" is for words that Blender translates in another sense.
_CONTEXTS = ("*", "Operator", "Haptics")
_NAME = __package__


def dictionary() -> dict[str, dict[tuple[str, str], str]]:
    """Translations in Blender's form, by locale."""
    texts = german.MESSAGES | {ENGLISH[cause]: words for cause, words in german.SENTENCES.items()}
    messages = {(context, text): words for text, words in texts.items() for context in _CONTEXTS}
    return {"de_DE": messages, "de": messages}


def register() -> None:
    bpy.app.translations.register(_NAME, dictionary())


def unregister() -> None:
    bpy.app.translations.unregister(_NAME)
