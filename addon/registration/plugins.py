"""The parts of plug-ins in Blender: the module `blender` of each, with its ``CLASSES``, and
`register` and `unregister` for the rest."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

import bpy

from ...core import plugins

_parts: list[tuple[str, ModuleType]] = []


def register() -> None:
    """Register the parts. One that fails is left out and leaves no class behind."""
    for name, plugin in plugins.plugins().items():
        module = f"{plugin.__name__}.blender"
        registered: list[type] = []
        try:
            if find_spec(module) is None:
                continue
            part = import_module(module)
            for cls in part.CLASSES:
                bpy.utils.register_class(cls)
                registered.append(cls)
            part.register()
        except Exception as error:
            _unregister(registered)
            plugins.note_failure(name, error)
        else:
            _parts.append((name, part))


def unregister() -> None:
    """Unregister them in reverse order."""
    while _parts:
        name, part = _parts.pop()
        try:
            part.unregister()
        except Exception as error:
            plugins.note_failure(name, error)
        _unregister(part.CLASSES)


def _unregister(classes: Sequence[type]) -> None:
    for cls in reversed(classes):
        bpy.utils.unregister_class(cls)
