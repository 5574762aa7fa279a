"""The add-on's texts in other languages. The code and Blender's own fallback are in English; every
other language is a JSON file with ``messages`` by English text and ``sentences`` by cause."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypedDict

import bpy

from ...core import plugins
from ...core.message import Cause

LOCALES = {"german": ("de_DE", "de")}
"""Blender's locales of each language."""

# Blender looks texts of buttons for operators up in a context of their own. "Haptics" is for words
# that Blender translates in another sense.
_CONTEXTS = ("*", "Operator", "Haptics")
_NAME = __package__


class Language(TypedDict):
    """The texts of a language."""

    messages: dict[str, str]
    sentences: dict[str, str]


def read_language(name: str) -> Language:
    """The texts of the language ``name``, those of plug-ins among them."""
    language: Language = json.loads(Path(__file__).with_name(f"{name}.json").read_text("utf-8"))
    for plugin in plugins.plugins().values():
        path = Path(plugin.__file__ or "").with_name(f"{name}.json")
        if path.is_file():
            language["messages"] |= json.loads(path.read_text("utf-8"))
    return language


def dictionary() -> dict[str, dict[tuple[str, str], str]]:
    """Translations in Blender's form, by locale."""
    found: dict[str, dict[tuple[str, str], str]] = {}
    for name, locales in LOCALES.items():
        language = read_language(name)
        texts = language["messages"] | {
            cause.value: language["sentences"][cause.name.lower()] for cause in Cause
        }
        messages = {
            (context, text): words for text, words in texts.items() for context in _CONTEXTS
        }
        found |= dict.fromkeys(locales, messages)
    return found


def register() -> None:
    bpy.app.translations.register(_NAME, dictionary())


def unregister() -> None:
    bpy.app.translations.unregister(_NAME)
