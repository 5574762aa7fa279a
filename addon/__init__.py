"""The Blender side: properties, panels, operators, handlers and overlays. Thin: what is computed is computed in `core`."""

from __future__ import annotations


def _modules() -> tuple:
    from . import (
        bake,
        body_kit,
        formats,
        handlers,
        keymap,
        live_output,
        materials,
        menus,
        meters,
        modalities,
        operators,
        overlay,
        panels,
        preferences,
        properties,
        translations,
    )

    return (
        preferences,
        properties,
        operators,
        panels,
        materials,
        modalities,
        body_kit,
        bake,
        formats,
        overlay,
        meters,
        handlers,
        live_output,
        menus,
        keymap,
        translations,
    )


def register() -> None:
    """Register everything; the reverse of `unregister`."""
    for module in _modules():
        module.register()


def unregister() -> None:
    """Remove everything that `register` added."""
    for module in reversed(_modules()):
        module.unregister()
