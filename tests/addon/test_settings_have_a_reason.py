"""Each visible setting is of the view, a device, a file or safety, or is set in a sample scene, in
the study or in an example of the documentation; those that only designers set are listed here with
what differs then, and the list may only get shorter. And how many settings and operators there are.
"""

import ast
import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import bpy
import haptic_tracing

ROOT = Path(haptic_tracing.__file__).parent
FREE = {
    "view": ("scene.show_*", "scene.xray", "scene.meters.*", "scene.bake.use_track"),
    "mute and solo": ("*.muted", "*.solo"),
    "devices and calibration": (
        "scene.live_output.*",
        "object.live_output.*",
        "object.listener.full_scale*",
    ),
    "files": ("*.filepath", "*.drawing", "*.speaker", "*.strip", "*.loop"),
    "safety": ("object.listener.s_max", "object.listener.limiter"),
}
"""Settings that need no example, by what they are of."""
DESIGNERS = {
    "scene.impact_table.items.pitch": "a pair that sounds higher or lower than its materials",
    "scene.contact_tolerance": "models with gaps: up to which gap objects touch",
    "scene.transmission_table.items.*": "a contact that passes on less, or by its own function",
    "object.spring_loss": "a mount that rings longer or shorter",
    "object.constant": "the gain of the function Constant",
    "object.expression": "the formula of the function Expression",
    "object.density": "a body of another density than its material's",
    "object.plate_thickness": "a plate or shell",
    "object.reference_distance": "a source that is larger than a point",
    "object.source.sound.*": "how a sound becomes vibration",
    "object.source.trigger_*": "one-shots at markers, blows, and where something passes",
    "object.source.priority": "what is felt first in a mix",
    "object.listener.mixing*": "how sources add up in a listener",
}
MOST_SETTINGS, MOST_OPERATORS = 143, 61


def settings() -> Iterator[str]:
    """The visible properties of scenes and objects, by path."""

    def of(struct: Any, path: str) -> Iterator[str]:
        for item in struct.properties:
            if item.identifier in ("rna_type", "name") or item.is_hidden:
                continue
            inner = getattr(item, "fixed_type", None)
            if inner is not None and inner.identifier.startswith("Haptic"):
                yield from of(inner, f"{path}.{item.identifier}")
            else:
                yield f"{path}.{item.identifier}"

    for owner in (bpy.types.Scene, bpy.types.Object):
        group = owner.bl_rna.properties["haptics"].fixed_type
        yield from of(group, owner.bl_rna.identifier.lower())


def names_in(tree: ast.AST) -> Iterator[str]:
    """The names that a program sets: of attributes, of arguments, and in short texts."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr
        elif isinstance(node, ast.keyword) and node.arg:
            yield node.arg
        elif isinstance(node, ast.Constant) and len(str(node.value)) < 200:
            yield from re.findall(r"\w+", str(node.value))


def shown_somewhere() -> set[str]:
    found: set[str] = set()
    for folder in ("sample_scenes", "study"):
        for path in (ROOT / folder).rglob("*.py"):
            found |= set(names_in(ast.parse(path.read_text(encoding="utf-8"))))
        for path in (ROOT / folder).rglob("*.toml"):
            found |= set(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    for path in (ROOT / "docs").rglob("*.md"):
        for text in re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL):
            found |= set(names_in(ast.parse(text)))
    return found


def test_every_visible_setting_has_a_reason():
    known = shown_somewhere()
    free = [pattern for patterns in FREE.values() for pattern in patterns]
    left = {
        path
        for path in settings()
        if path.rpartition(".")[2] not in known
        and not any(fnmatch(path, pattern) for pattern in free)
    }
    unexplained = {path for path in left if not any(fnmatch(path, p) for p in DESIGNERS)}
    assert not unexplained, "set them in a sample, or let their value be the behaviour"
    unused = {p for p in DESIGNERS if not any(fnmatch(path, p) for path in left)}
    assert not unused, "take these out of the list"


def test_there_are_no_more_settings_and_operators_than_before():
    assert len(list(settings())) <= MOST_SETTINGS
    stack, found = [bpy.types.Operator], set()
    while stack:
        cls = stack.pop()
        stack += cls.__subclasses__()
        if cls.__module__.startswith("haptic_tracing.") and getattr(cls, "is_registered", False):
            found.add(cls.bl_idname)
    assert len(found) <= MOST_OPERATORS, sorted(found)
