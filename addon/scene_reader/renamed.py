"""Rules and triggers that name an object, and follow when it is renamed."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

from bpy.types import Scene

from ...core.scene.rule_table import MOST_ROWS
from ..properties.rules import TABLES


class ObjectsMeant:
    """The objects that the rules of a scene named last."""

    def __init__(self) -> None:
        self._meant: dict[str, int] = {}  # session ids by name

    def follow(self, scene: Scene) -> None:
        """Put the new names of renamed objects into the rules of a scene."""
        before, self._meant = self._meant, {}
        naming = [item for item in _naming(scene) if getattr(*item)]
        if not naming:
            return
        names = {obj.session_uid: obj.name_full for obj in scene.objects}
        numbers = {name: number for number, name in names.items()}
        for owner, field in naming:
            written = getattr(owner, field)
            name = names.get(before.get(written, 0), written)
            if name != written:
                setattr(owner, field, name)
            if name in numbers:
                self._meant[name] = numbers[name]


def _naming(scene: Scene) -> Iterator[tuple[Any, str]]:
    """The groups and their properties that may name an object, without those of libraries."""
    if scene.is_editable:
        for table, _, _ in TABLES:
            for row in islice(getattr(scene.haptics, table).items, MOST_ROWS):
                for side in ("first", "second"):
                    if getattr(row, f"{side}_kind") == "OBJECT":
                        yield row, side
