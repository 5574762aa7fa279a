"""The extension's documentation as HTML pages, and the pages that F1 and *Online Manual* open."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_ROOT = Path(__file__).parents[2]

_PAGES = {
    "panels/materials": "ops.haptic.*material types.hapticmaterial",
    "panels/sound": "ops.haptic.convert_sound types.hapticsound",
    "panels/bake": "ops.haptic.*bake ops.haptic.*take types.hapticbake types.haptictake",
    "panels/result": "types.hapticmeters",
    "panels/source": "ops.haptic.*signal ops.haptic.*envelope ops.haptic.*emphasis "
    "types.hapticdrawing types.haptice types.hapticsource",
    "devices": "ops.haptic.*device types.haptic*devi types.hapticlive types.hapticactuator",
    "panels/scene": "ops.haptic. types.hapticscene types.hapticrule types.hapticimpact "
    "types.haptictransmission types.haptictexture",
    "formats": "ops.haptic.drop_scene ops.export_scene.haptic",
    **{f"panels/{kind}": f"types.haptic{kind}" for kind in ("listener", "object")},
}
"""Pages with patterns of the lower-case names of their operators and properties; the first match
counts."""


@cache
def page_url(page: str) -> str:
    """The address of a page ("panels/bake"); that of its source if the extension does not run from
    a zip."""
    path = _ROOT / "manual" / f"{page}.html"
    return (path if path.is_file() else _ROOT / "docs" / f"{page}.md").as_uri()


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """The manual map for `bpy.utils.register_manual_map`."""
    return "", tuple(
        (f"bpy.{name}*", page_url(page)) for page, names in _PAGES.items() for name in names.split()
    )
