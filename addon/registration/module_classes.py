"""The classes that Blender has to know of, found in the modules that define them."""

from __future__ import annotations

from types import ModuleType

import bpy


def classes_of(*modules: ModuleType) -> tuple[type, ...]:
    """The classes of Blender's kinds that are defined in modules, in their order there: a class stands after those that it needs."""
    return tuple(
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, bpy.types.bpy_struct) and value.__module__ == module.__name__
    )
