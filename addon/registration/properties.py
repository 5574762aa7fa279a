"""The properties that objects and scenes have in `haptics`."""

from __future__ import annotations

import bpy
from bpy.props import PointerProperty
from bpy.types import Object, Scene

from ..properties import haptics

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(haptics.CLASSES)


def register() -> None:
    """Register the property groups, then give them to objects and scenes."""
    _register_classes()
    Object.haptics = PointerProperty(type=haptics.HapticObjectProperties, name="Haptics")
    Scene.haptics = PointerProperty(type=haptics.HapticSceneProperties, name="Haptics")


def unregister() -> None:
    """Take them away."""
    del Scene.haptics
    del Object.haptics
    _unregister_classes()
