"""German is complete: every text of the add-on's classes, properties and sources has its
translation, with the same gaps to fill."""

import importlib.util
import re
from pathlib import Path

import bpy
import pytest
from haptic_tracing.addon import translations
from haptic_tracing.addon.translations import sentences
from haptic_tracing.core.message import Cause, Message, Metres

_spec = importlib.util.spec_from_file_location(
    "messages_of_the_add_on", Path(__file__).parent / "messages.py"
)
messages = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(messages)

GERMAN = translations.read_language("german")
# Names of encodings and examples, which are the same in every language.
SAME = {"pcm16", "float32", "0.50  -6 dB", "-6 dB"}
# What Blender translates itself.
BLENDERS = {
    "Unique name used in the code and scripting, can be re-defined in Python sub-classes if needed",
    "Unique name used in the code and scripting",
}


def test_every_text_is_translated():
    shown = messages.registered_texts() | messages.written_texts()
    assert len(shown) > 300
    assert sorted(shown - GERMAN["messages"].keys() - SAME - BLENDERS) == []


@pytest.mark.slow
def test_nothing_is_translated_that_is_not_shown():
    """What none of the two finds stands as a literal in the sources, or names a file of the signal
    library, as it is drawn."""
    shown = messages.registered_texts() | messages.written_texts() | messages.literals()
    shown |= {path.stem for path in (messages.ADDON / "signals").glob("*.json")}
    assert sorted(GERMAN["messages"].keys() - shown) == []


def test_messages_of_the_core_are_translated_with_their_arguments():
    assert GERMAN["sentences"].keys() == {cause.name.lower() for cause in Cause}
    for cause, words in GERMAN["sentences"].items():
        assert sorted(re.findall(r"\{[^}]*\}", words)) == sorted(
            re.findall(r"\{[^}]*\}", Cause[cause.upper()].value)
        ), cause


def test_a_message_is_said_in_the_language_of_the_interface(monkeypatch):
    message = Message.of(
        Cause.GAP, source="drill", first="bench", second="seat", distance=Metres(0.04)
    )
    assert (
        sentences.sentence(message)
        == "no contact leads from 'drill' to it: 'bench' and 'seat' are 4.0 cm apart"
    )
    monkeypatch.setattr(
        sentences, "iface_", lambda text: translations.dictionary()["de"]["*", text]
    )
    assert (
        sentences.sentence(message)
        == "Kein Kontakt führt von „drill“ zu ihm: „bench“ und „seat“ sind 4.0 cm voneinander "
        "entfernt"
    )


def test_translations_keep_the_gaps():
    for text, words in GERMAN["messages"].items():
        assert sorted(re.findall(r"\{[^}]*\}", text)) == sorted(re.findall(r"\{[^}]*\}", words)), (
            text
        )
        assert words.strip() == words
        assert words


def test_reports_fill_translated_gaps():
    assert GERMAN["messages"]["{} frames baked"].format(3) == "3 Bilder gebacken"


def test_the_dictionary_is_registered_and_removed():
    bpy.app.translations.unregister("haptic_tracing.addon.translations")
    translations.register()
    assert bpy.app.translations.pgettext_iface("Make Haptic") in ("Make Haptic", "Haptisch machen")
