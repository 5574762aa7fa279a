"""Registers and unregisters what Blender has to know of: classes, handlers, menus, shortcuts and translations."""

from __future__ import annotations

from types import ModuleType


def _modules() -> tuple[ModuleType, ...]:
    """Every module with `register` and `unregister`, in the order of registration: property groups first; panels appear in this order."""
    from .. import operators, panels, translations
    from ..bake import playback
    from ..io import menus as file_menus
    from ..live_output import handlers as live_output_handlers
    from ..live_output import keymap as live_output_keymap
    from ..live_output import refresh
    from ..operators import bake, body_kit, live_output, materials, modes
    from ..panels import bake as bake_panel
    from ..panels import live_output as live_output_panels
    from ..panels import materials as materials_panels
    from ..panels import menus
    from ..panels import modalities as modalities_panels
    from ..properties import haptics, preferences
    from ..session import modalities
    from ..view import explanation, gain_plot, graph_mesh, meter_pictures, meters, overlay
    from . import handlers, keymap

    return (
        preferences,
        haptics,
        operators,
        panels,
        gain_plot,
        materials,
        materials_panels,
        modalities,
        modalities_panels,
        body_kit,
        playback,
        bake,
        bake_panel,
        file_menus,
        graph_mesh,
        overlay,
        explanation,
        modes,
        meter_pictures,
        meters,
        handlers,
        live_output,
        live_output_panels,
        live_output_handlers,
        live_output_keymap,
        refresh,
        menus,
        keymap,
        translations,
    )


def register() -> None:
    """Register everything; the reverse of `unregister`."""
    for module in _modules():
        if hasattr(module, "register"):
            module.register()


def unregister() -> None:
    """Remove everything that `register` added, and forget what was kept for drawing and playing."""
    for module in reversed(_modules()):
        if hasattr(module, "unregister"):
            module.unregister()
        elif hasattr(module, "forget"):
            module.forget()
