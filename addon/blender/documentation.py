"""The documentation that the extension carries, a page of HTML each, and what F1 and *Online Manual* open of it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_ROOT = Path(__file__).parents[2]

_PAGES = (
    ("bpy.ops.haptic.*material*", "panels/materials"),
    ("bpy.ops.haptic.*wish*", "panels/materials"),
    ("bpy.ops.haptic.*bake*", "panels/bake"),
    ("bpy.ops.haptic.*take*", "panels/bake"),
    ("bpy.ops.haptic.*device*", "devices"),
    ("bpy.ops.haptic.*", "panels/scene"),
    ("bpy.ops.*_scene.haptic_*", "formats"),
    ("bpy.types.hapticmaterial*", "panels/materials"),
    *((f"bpy.types.haptic{kind}*", f"panels/{kind}") for kind in ("source", "listener", "object", "bake", "scene")),
    ("bpy.types.haptictake*", "panels/bake"),
    ("bpy.types.hapticmeters*", "panels/result"),
    ("bpy.types.haptic*devi*", "devices"),
    ("bpy.types.hapticliveoutput*", "devices"),
)
"""Operators and properties, by their lower-case names with wildcards, and their page; the first that fits counts."""


@cache
def page_url(page: str) -> str:
    """The address of a page ("panels/bake"); of its source where the extension was not built into a zip."""
    path = _ROOT / "manual" / f"{page}.html"
    return (path if path.is_file() else _ROOT / "docs" / f"{page}.md").as_uri()


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """For `bpy.utils.register_manual_map`."""
    return "", tuple((pattern, page_url(page)) for pattern, page in _PAGES)
