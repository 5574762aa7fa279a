"""What edits of properties do: they mark the traced scene as changed, and drop what a file stored beyond them."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, get_type_hints

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import Context, PropertyGroup

from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed
from .kinds import text

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


def updating(callback: Callback | None = None, *, animated: bool = True) -> Callable[[_Group], _Group]:
    """Decorator of a property group: its values call this when they are edited; by default `edited` with their names, or `changed` where a
    file stores nothing for them. They can't be keyed unless they are ``animated``. A property with its own ``update`` or ``options`` keeps
    these; a hidden one is unchanged."""

    def decorate(group: _Group) -> _Group:
        annotations = get_type_hints(group)
        for name, definition in annotations.items():
            is_value = definition.function not in (PointerProperty, CollectionProperty)
            if is_value and "HIDDEN" not in definition.keywords.get("options", ()):
                own = callback or (edited(name) if hasattr(group, "drop_imported") else changed)
                common: dict[str, Any] = {"update": own} if animated else {"update": own, "options": set()}
                annotations[name] = definition.function(**{**common, **definition.keywords})
        group.__annotations__ = annotations
        return group

    return decorate


class Stored:
    """Mixin: a property group with an item of an imported file as JSON text; see `scene_reader.imported`."""

    imported: text("Imported", "What an imported file says beyond these properties", options={"HIDDEN"}, update=changed)


class Imported(Stored):
    """Mixin: a property group with the values of an imported file that its properties cannot hold."""

    def drop_imported(self, name: str) -> None:
        """Drop the exact number that was imported for the property ``name``: because it was edited."""
        drop(self, "numbers", name)


def drop(owner: Any, *path: str) -> None:
    """Remove a value, given by its keys, from the imported values of ``owner``. Text that is not a JSON object is kept; the reader reports
    it."""
    if not owner.imported:
        return
    try:
        form = json.loads(owner.imported)
    except (ValueError, RecursionError):
        return
    *outer, last = path
    holder = form
    for key in outer:
        holder = holder.get(key) if isinstance(holder, dict) else None
    if isinstance(holder, dict) and last in holder:
        del holder[last]
        used = {key: value for key, value in form.items() if value != {}}
        owner.imported = json.dumps(used, ensure_ascii=False, separators=(",", ":")) if used else ""
