"""German is complete: every text of the add-on's classes, properties and sources has its translation, with the same gaps to fill."""

import ast
import importlib.util
import re
from pathlib import Path

import bpy
import pytest
from haptic_tracing.addon.translations import german, sentences
from haptic_tracing.core.diagnosis import silence

_spec = importlib.util.spec_from_file_location("messages_of_the_add_on", Path(__file__).parent / "messages.py")
messages = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(messages)

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
    assert sorted(shown - german.MESSAGES.keys() - SAME - BLENDERS) == []


def test_problems_of_objects_are_translated():
    """Those that are raised as they are shown; what the core says about files and formulas is in English."""
    source = (messages.ADDON / "scene_reader" / "collision_shapes.py").read_text(encoding="utf-8")
    raised = re.findall(r'raise ValueError\("([^"]+)"\)', source)
    assert len(raised) >= 4
    assert [text for text in raised if text not in german.MESSAGES] == []


def _sentences_of_silence():
    """What the core may say, a regular expression each: gaps are anything."""
    tree = ast.parse((Path(silence.__file__)).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Reason":
            yield from _patterns(node.args[1])
        elif isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("words", "why", "rule"):
            yield from ((f".*{pattern}.*") for pattern in _patterns(node.value))
        elif isinstance(node, ast.AugAssign) and getattr(node.target, "id", "") == "words":
            yield from ((f".*{pattern}") for pattern in _patterns(node.value))


def _patterns(node):
    match node:
        case ast.Constant(value=str(text)):
            yield re.escape(text)
        case ast.IfExp():
            yield from (*_patterns(node.body), *_patterns(node.orelse))
        case ast.JoinedStr():
            yield "".join(re.escape(part.value) if isinstance(part, ast.Constant) else ".*" for part in node.values)


def test_why_it_is_silent_is_translated_whatever_the_core_says():
    patterns = list(_sentences_of_silence())
    assert len(patterns) > 20
    assert [pattern for pattern in patterns if not any(re.fullmatch(pattern, template) for template in sentences.TEMPLATES)] == []
    assert sorted(set(sentences.TEMPLATES) - german.MESSAGES.keys()) == []


def test_warnings_of_propagation_are_translated():
    source = (Path(silence.__file__).parents[1] / "propagation" / "strategies.py").read_text(encoding="utf-8")
    warnings = re.findall(r'warnings\.append\("([^"]+)"\)', source)
    assert len(warnings) >= 4
    assert [text for text in warnings if text not in sentences.TEMPLATES] == []


@pytest.mark.parametrize(
    ("sentence", "template", "values"),
    [
        ("'drill' is muted", "'{}' is muted", ("drill",)),
        ("'a 'b' is muted", "'{}' is muted", ("a 'b",)),
        (
            "no contact leads from 'drill' to it: 'bench' and 'seat' are 4.0 cm apart, they touch from 1.0 cm on",
            "no contact leads from '{}' to it: '{}' and '{}' are {} apart, they touch from {} on",
            ("drill", "bench", "seat", "4.0 cm", "1.0 cm"),
        ),
    ],
)
def test_sentences_are_taken_apart(sentence, template, values, monkeypatch):
    assert sentences.matched(sentence) == (template, values)
    assert sentences.translated(sentence) == sentence
    monkeypatch.setattr(sentences, "iface_", german.MESSAGES.get)
    assert sentences.translated(sentence) == german.MESSAGES[template].format(*values)


def test_an_unknown_sentence_stays_as_it_is():
    assert sentences.matched("something else") is None
    assert sentences.translated("something else") == "something else"


def test_translations_keep_the_gaps():
    for text, words in german.MESSAGES.items():
        assert sorted(re.findall(r"\{[^}]*\}", text)) == sorted(re.findall(r"\{[^}]*\}", words)), text
        assert words.strip() == words
        assert words


def test_reports_fill_translated_gaps():
    assert german.MESSAGES["{} listeners mirrored"].format(3) == "3 Empfänger gespiegelt"


def test_the_dictionary_is_registered_and_removed():
    bpy.app.translations.unregister("haptic_tracing.addon.translations")
    from haptic_tracing.addon import translations

    translations.register()
    assert bpy.app.translations.pgettext_iface("Make Haptic") in ("Make Haptic", "Haptisch machen")
