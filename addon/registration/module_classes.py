"""Collection of the Blender classes that modules define."""

from __future__ import annotations

from types import ModuleType

import bpy


def classes_of(*modules: ModuleType) -> tuple[type, ...]:
    """The Blender classes defined in modules, in the order of definition, so that a class follows those that it needs."""
    return tuple(
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, bpy.types.bpy_struct) and value.__module__ == module.__name__
    )
