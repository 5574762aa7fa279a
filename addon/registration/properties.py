"""The property groups, and the properties that node groups, objects and scenes have in `haptics`.

A library override stores an edit of any of them, and items added to any collection.
"""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from types import ModuleType
from typing import Any, get_type_hints

import bpy
from bpy.props import CollectionProperty, PointerProperty
from bpy.types import NodeTree, Object, PropertyGroup, Scene

from ..properties import (
    bake,
    drawing,
    listener,
    live_output,
    materials,
    object,
    rules,
    scene,
    sound,
    source,
)


def classes_of(*modules: ModuleType) -> tuple[type, ...]:
    """The Blender classes defined in modules, but for their bases (``_Name``), in the order of
    definition, so that a class follows those that it needs."""
    return tuple(
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, bpy.types.bpy_struct)
        and value.__module__ == module.__name__
        and not value.__name__.startswith("_")
    )


CLASSES = (
    *classes_of(bake, live_output, materials),
    *classes_of(drawing, sound, source, listener, object, rules, scene),
)
"""The property groups, each after those that it contains."""

_OVERRIDABLE: Any = {"LIBRARY_OVERRIDABLE"}


def _overridable(definition: Any) -> Any:
    """The definition of a property whose edits a library override stores."""
    more = {"USE_INSERTION"} if definition.function is CollectionProperty else set()
    return definition.function(**definition.keywords, override=_OVERRIDABLE | more)


for _group in CLASSES:
    _group.__annotations__ = {
        name: _overridable(definition) for name, definition in get_type_hints(_group).items()
    }


def _inner_groups(group: type) -> Iterator[str]:
    """The paths from a property group to those that it contains, at any depth."""
    for name, definition in group.__annotations__.items():
        kind = definition.keywords.get("type")
        if definition.function is PointerProperty and issubclass(kind, PropertyGroup):
            yield name
            yield from (f"{name}.{inner}" for inner in _inner_groups(kind))


_INNER_GROUPS = attrgetter(*_inner_groups(object.HapticObjectProperties))


def create_overridden_groups() -> None:
    """Before a save: create the property groups that library overrides and what they override lack,
    by reading them. Blender 5 stores the difference of two groups, but none from a group that does
    not exist."""
    for block in (*bpy.data.objects, *bpy.data.node_groups):
        if block.override_library is not None:
            for side in filter(None, (block, block.override_library.reference)):
                haptics = side.haptics
                if isinstance(side, Object):
                    _INNER_GROUPS(haptics)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    """Register the property groups, then give them to node groups, objects and scenes."""
    _register_classes()
    NodeTree.haptics = PointerProperty(
        type=drawing.HapticDrawing, name="Haptics", override=_OVERRIDABLE
    )
    Object.haptics = PointerProperty(
        type=object.HapticObjectProperties, name="Haptics", override=_OVERRIDABLE
    )
    Scene.haptics = PointerProperty(
        type=scene.HapticSceneProperties, name="Haptics", override=_OVERRIDABLE
    )


def unregister() -> None:
    """Unregister them in reverse order."""
    del Scene.haptics
    del Object.haptics
    del NodeTree.haptics
    _unregister_classes()
