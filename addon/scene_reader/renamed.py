"""Rules and triggers that name an object, and follow when it is renamed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

from bpy.types import Object, Scene

from ...core.scene.rule_table import MOST_ROWS
from ..properties.rules import TABLES


class ObjectsMeant:
    """The objects that the rules and triggers of a scene named last."""

    def __init__(self) -> None:
        self._meant: dict[str, int] = {}  # session ids by name

    def follow(self, scene: Scene, tagged: Iterable[Object]) -> None:
        """Put the new names of renamed objects into the rules of a scene and the triggers of the
        sources among its ``tagged`` objects."""
        before, self._meant = self._meant, {}
        naming = [item for item in _naming(scene, tagged) if getattr(*item)]
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


def _naming(scene: Scene, tagged: Iterable[Object]) -> Iterator[tuple[Any, str]]:
    """The groups and their properties that may name an object, without those of libraries."""
    if scene.is_editable:
        for table, _, _ in TABLES:
            for row in islice(getattr(scene.haptics, table).items, MOST_ROWS):
                for side in ("first", "second"):
                    if getattr(row, f"{side}_kind") == "OBJECT":
                        yield row, side
    for obj in tagged:
        if obj.haptics.source.one_shot and obj.is_editable:
            yield obj.haptics.source, "trigger_object"
            yield obj.haptics.source, "trigger_region"
