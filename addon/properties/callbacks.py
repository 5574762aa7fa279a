"""Update callbacks of properties."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from bpy.types import Context, PropertyGroup

from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed


def changed(self: PropertyGroup, context: Context) -> None:
    """Mark that what is traced has changed."""
    mark_changed()


def view_changed(self: PropertyGroup, context: Context) -> None:
    """Redraw the viewports: what they show has changed, not what is traced."""
    redraw_viewports()


@cache
def edited(name: str) -> Callable[[PropertyGroup, Context], None]:
    """The callback of the property ``name``, for which an imported file may hold a value that the property cannot: with more digits, or a
    function with more parameters. The first edit drops that value."""

    def update(self: Any, context: Context) -> None:
        self.drop_imported(name)
        mark_changed()

    return update
