"""Update callbacks of properties."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, get_type_hints

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import Context, PropertyGroup

from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed

Callback = Callable[[Any, Context], None]
_Group = TypeVar("_Group", bound=type[PropertyGroup])


def changed(self: PropertyGroup, context: Context) -> None:
    """Mark the traced scene as changed."""
    mark_changed()


def view_changed(self: PropertyGroup, context: Context) -> None:
    """Redraw the viewports: their display has changed, not the traced scene."""
    redraw_viewports()


@cache
def edited(name: str) -> Callback:
    """The callback of the property ``name``, for which an imported file may store a value that the property cannot hold, with more digits
    or further parameters. The first edit drops that value."""

    def update(self: Any, context: Context) -> None:
        self.drop_imported(name)
        mark_changed()

    return update


def updating(callback: Callback | None = None) -> Callable[[_Group], _Group]:
    """Decorator of a property group: its values call this when they are edited; by default `edited` with their names, or `changed` where a
    file stores nothing for them. A property with its own ``update`` keeps it, a hidden one has none."""

    def decorate(group: _Group) -> _Group:
        annotations = get_type_hints(group)
        for name, definition in annotations.items():
            is_value = definition.function not in (PointerProperty, CollectionProperty)
            if is_value and "HIDDEN" not in definition.keywords.get("options", ()):
                own = callback or (edited(name) if hasattr(group, "drop_imported") else changed)
                definition.keywords.setdefault("update", own)
        group.__annotations__ = annotations
        return group

    return decorate
