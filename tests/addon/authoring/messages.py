"""Every text that the add-on shows: those of its classes and properties as Blender knows them, and
those in its sources."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, get_args

import bpy
import haptic_tracing
from haptic_tracing.addon.scene_reader.digest import TEXTS as CHANGES
from haptic_tracing.core.scene import body_map

ADDON = Path(haptic_tracing.__file__).parent / "addon"
PLUGINS = ADDON.parent / "plugins"
_BASES = (
    bpy.types.Operator,
    bpy.types.Panel,
    bpy.types.Menu,
    bpy.types.PropertyGroup,
    bpy.types.AddonPreferences,
    bpy.types.UIList,
)
_CALLS = {
    "poll_message_set",
    "Need",
    "warn",
    "draw_carrier",
    "report_text",
    "ui_text",
    "tell",
    "TranslatedError",
    "Refused",
    "pgettext_rpt",
    "pgettext_iface",
    "iface_",
    "pgettext_tip",
    "pgettext",
}
_KEYWORDS = {"text", "heading"}


def registered_texts() -> set[str]:
    """Labels, names and descriptions of the add-on's classes."""
    found = {text for cls in _classes() for text in _of_class(cls)}
    found |= {*CHANGES.values(), *get_args(body_map.View)}
    return {text for text in found if _has_words(text)}


@cache
def written_texts() -> set[str]:
    """Texts in the sources that are drawn or reported."""
    found: set[str] = set()
    for path in (*ADDON.rglob("*.py"), *PLUGINS.rglob("*.py")):
        if "translations" not in path.parts:
            found |= {
                text
                for text in _in_source(ast.parse(path.read_text(encoding="utf-8")))
                if _has_words(text)
            }
    return found


def literals() -> set[str]:
    """Every string in the sources of the add-on and the core."""
    return {
        node.value
        for folder in (ADDON, ADDON.parent / "core", PLUGINS)
        for path in folder.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def _classes() -> Iterator[Any]:
    stack = list(_BASES)
    while stack:
        cls = stack.pop()
        stack += cls.__subclasses__()
        if cls.__module__.startswith("haptic_tracing.") and getattr(cls, "is_registered", False):
            yield cls


def _of_class(cls: Any) -> Iterator[str]:
    if issubclass(cls, bpy.types.Operator):
        module, name = cls.bl_idname.split(".")
        rna = getattr(getattr(bpy.ops, module), name).get_rna_type()
        yield rna.name
        yield rna.description
    else:
        rna = cls.bl_rna
        if issubclass(cls, bpy.types.Panel | bpy.types.Menu):
            yield cls.bl_label
    known = {"rna_type", *(prop.identifier for base in _BASES for prop in base.bl_rna.properties)}
    for prop in rna.properties:
        unnamed = prop.name in (prop.identifier, "")  # never shown by name
        if (prop.identifier in known and prop.identifier != "name") or prop.is_hidden or unnamed:
            continue
        yield prop.name
        yield prop.description
        if prop.type == "ENUM":
            for item in prop.enum_items:
                yield item.name
                yield item.description


def _in_source(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = (
                node.func.attr
                if isinstance(node.func, ast.Attribute)
                else getattr(node.func, "id", "")
            )
            for keyword in node.keywords:
                if keyword.arg in _KEYWORDS:
                    yield from _constants(keyword.value)
            if name in _CALLS:
                for argument in node.args:
                    yield from _constants(argument)
            elif name in ("report", "refuse") and len(node.args) >= 2:
                yield from _constants(node.args[1])
        elif isinstance(node, ast.FunctionDef) and node.name in (
            "next_step",
            "steps",
            "advice",
            "linked_message",
        ):
            for inner in ast.walk(node):
                if isinstance(inner, ast.Return | ast.Yield) and inner.value is not None:
                    values = (
                        inner.value.elts if isinstance(inner.value, ast.Tuple) else [inner.value]
                    )
                    for value in values:
                        yield from _constants(value)


def _constants(node: ast.expr) -> Iterator[str]:
    """The texts that an expression may be: a constant, or either side of a condition."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from _constants(node.body)
        yield from _constants(node.orelse)
    elif isinstance(node, ast.BoolOp):
        for value in node.values:
            yield from _constants(value)


def _has_words(text: str) -> bool:
    return sum(letter.isalpha() for letter in text) > 1
