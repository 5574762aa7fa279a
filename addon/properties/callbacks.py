"""What edits of properties do: they mark the traced scene as changed, or redraw."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, get_type_hints

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import Context, PropertyGroup

from ..changes.redraw import redraw_viewports
from ..changes.revisions import SCENE, mark_changed

Callback = Callable[[Any, Context], None]
_Group = TypeVar("_Group", bound=type[PropertyGroup])


def changed(self: PropertyGroup, context: Context) -> None:
    """Mark the traced scene as changed."""
    mark_changed()


def scene_changed(self: PropertyGroup, context: Context) -> None:
    """Mark the settings and rules of the scene as changed, and no object."""
    mark_changed((SCENE,))


def object_changed(self: PropertyGroup, context: Context) -> None:
    """Mark the object that has this property as changed, and no other: what the tracer reads of
    others does not depend on the value."""
    mark_changed((self.id_data.session_uid,))


def view_changed(self: PropertyGroup, context: Context) -> None:
    """Redraw the viewports: their display has changed, not the traced scene."""
    redraw_viewports()


def updating(callback: Callback = changed, *, animated: bool = True) -> Callable[[_Group], _Group]:
    """Decorator of a property group: its values call this when they are edited. They can't be keyed
    unless they are ``animated``. A property with its own ``update`` or ``options`` keeps these; a
    hidden one is unchanged."""

    def decorate(group: _Group) -> _Group:
        annotations = get_type_hints(group)
        for name, definition in annotations.items():
            is_value = definition.function not in (PointerProperty, CollectionProperty)
            if is_value and "HIDDEN" not in definition.keywords.get("options", ()):
                common: dict[str, Any] = {
                    "update": callback,
                    **({} if animated else {"options": set()}),
                }
                annotations[name] = definition.function(**{**common, **definition.keywords})
        group.__annotations__ = annotations
        return group

    return decorate
