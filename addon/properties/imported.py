"""What an imported file says beyond the properties of an object, source, listener or scene: JSON text, see `scene_reader.imported`."""

from __future__ import annotations

import json
from typing import Any

from bpy.props import StringProperty

from .callbacks import changed


class Imported:
    """Mixin: a property group that an imported file may say more about."""

    imported: StringProperty(
        name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"}, update=changed
    )

    def drop_imported(self, name: str) -> None:
        """Drop the exact number that was imported for the property ``name``: it was edited."""
        drop(self, "numbers", name)


def drop(owner: Any, *path: str) -> None:
    """Remove a value, given by its keys, from what was imported with ``owner``. Text that is no JSON object stays as it is: the reader
    reports it."""
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
