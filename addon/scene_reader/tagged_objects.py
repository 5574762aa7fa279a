"""Which objects of a scene are there and tagged."""

from __future__ import annotations

from collections.abc import Mapping

import bpy
import numpy as np
from bpy.types import Depsgraph, Object
from numpy.typing import NDArray

from .evaluation import Evaluation
from .present import present_and_disabled
from .renamed import ObjectsMeant
from .roles import is_tagged
from .world_transforms import session_ids


class TaggedObjects:
    """The tagged objects of a scene, known by their session ids.

    Attributes:
        rows: their numbers in `bpy.data.objects`, ascending, by session id.
        count: of all objects of the file.
        disabled: session ids, see `present_and_disabled`.
        arrived: session ids of the objects that are there since the last change.
    """

    def __init__(self) -> None:
        self.rows: dict[int, int] = {}
        self.count = 0
        self.disabled: frozenset[int] = frozenset()
        self.arrived: frozenset[int] = frozenset()
        self._names: dict[int, str] = {}
        self._ids: NDArray[np.int32] | None = None
        self._present = np.zeros(0, dtype=np.int32)
        self._layer = ""
        self._meant = ObjectsMeant()

    @property
    def are_known(self) -> bool:
        """Whether they were read, and not forgotten since."""
        return self._ids is not None

    def forget(self) -> None:
        """Find them out again at the next reading."""
        self._ids = None

    def note(self, evaluation: Evaluation) -> None:
        """Forget them if an evaluation has renamed one."""
        changed = evaluation.objects
        both = changed.keys() & self._names.keys()
        if any(changed[number].name_full != self._names[number] for number in both):
            self.forget()

    def are_those_of(self, evaluation: Evaluation, depsgraph: Depsgraph) -> bool:
        """Whether they are known of this view layer, and animation in this ``evaluation`` has not
        changed which are there."""
        return (
            self.are_known
            and self._layer == depsgraph.view_layer.name
            and all(
                obj.hide_viewport == (number in self.disabled)
                for number, obj in evaluation.objects.items()
            )
        )

    def by_row(self, objects: Mapping[int, Object]) -> dict[int, Object]:
        """The tagged ones of some objects, which are by session id."""
        return {self.rows[number]: obj for number, obj in objects.items() if number in self.rows}

    def follow(self, depsgraph: Depsgraph) -> bool:
        """Find out whether others are there than before, or all was forgotten; then, which of them
        are tagged."""
        ids, layer = session_ids(), depsgraph.view_layer
        self.count, self._layer = len(ids), layer.name
        present, self.disabled = present_and_disabled(layer)
        if (
            self._ids is not None
            and np.array_equal(self._ids, ids)
            and np.array_equal(self._present, present)
        ):
            return False
        there = set(present.tolist())
        self.arrived = frozenset(there.difference(self._present.tolist()))
        tagged = {
            row: obj
            for row, obj in enumerate(bpy.data.objects)
            if obj.session_uid in there and is_tagged(obj)
        }
        self._meant.follow(depsgraph.scene)
        self.rows = {obj.session_uid: row for row, obj in tagged.items()}
        self._names = {obj.session_uid: obj.name_full for obj in tagged.values()}
        self._ids, self._present = ids, present
        return True
