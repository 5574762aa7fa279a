"""Values of an imported file that properties of an object, source, listener or scene cannot hold, as JSON text; see
`scene_reader.imported`."""

from __future__ import annotations

import json
from typing import Any

from .callbacks import changed
from .kinds import text


class Imported:
    """Mixin: a property group with additional values of an imported file."""

    imported: text("Imported", "What an imported file says beyond these properties", options={"HIDDEN"}, update=changed)

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
