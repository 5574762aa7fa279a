"""The property groups, and the properties that node groups, objects and scenes have in `haptics`."""

from __future__ import annotations

from types import ModuleType

import bpy
from bpy.props import PointerProperty
from bpy.types import NodeTree, Object, Scene

from ..properties import bake, drawing, listener, live_output, materials, modalities, object, rules, scene, sound, source


def classes_of(*modules: ModuleType) -> tuple[type, ...]:
    """The Blender classes defined in modules, in the order of definition, so that a class follows those that it needs."""
    return tuple(
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, bpy.types.bpy_struct) and value.__module__ == module.__name__
    )


CLASSES = (
    *classes_of(bake, live_output, materials),
    *modalities.GROUPS,
    *classes_of(drawing, sound, source, listener, object, rules, scene),
)
"""The property groups, each after those that it contains."""

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    """Register the property groups, then give them to node groups, objects and scenes."""
    _register_classes()
    NodeTree.haptics = PointerProperty(type=drawing.HapticDrawing, name="Haptics")
    Object.haptics = PointerProperty(type=object.HapticObjectProperties, name="Haptics")
    Scene.haptics = PointerProperty(type=scene.HapticSceneProperties, name="Haptics")


def unregister() -> None:
    """Unregister them in reverse order."""
    del Scene.haptics
    del Object.haptics
    del NodeTree.haptics
    _unregister_classes()
