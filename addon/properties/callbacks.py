"""Update callbacks of properties."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from bpy.types import Context, PropertyGroup

from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed


def changed(self: PropertyGroup, context: Context) -> None:
    """Mark the traced scene as changed."""
    mark_changed()


def view_changed(self: PropertyGroup, context: Context) -> None:
    """Redraw the viewports: their display has changed, not the traced scene."""
    redraw_viewports()


@cache
def edited(name: str) -> Callable[[PropertyGroup, Context], None]:
    """The callback of the property ``name``, for which an imported file may store a value that the property cannot hold, with more digits
    or further parameters. The first edit drops that value."""

    def update(self: Any, context: Context) -> None:
        self.drop_imported(name)
        mark_changed()

    return update
