"""What a reading of a scene goes by."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import bpy
from bpy.types import Depsgraph, Object, Scene

from ...core.frozen import frozen

FEW = 16
"""Objects up to which reading them alone takes less time than the matrices of all."""


@frozen(eq=False)
class Changes:
    """An evaluated scene, and what may have changed in it since the last reading.

    Attributes:
        depsgraph: with the evaluated scene.
        metres: a unit of the scene.
        exact: motions below the tolerance of rest count, too.
        is_whole: anything may have changed, also which objects there are.
        few: the tagged objects, by row, that alone may have changed; None if others may, too.
        edited: session ids of the objects whose properties were edited.
    """

    depsgraph: Depsgraph
    metres: float
    exact: bool
    is_whole: bool
    few: Mapping[int, Object] | None
    edited: frozenset[int]

    @property
    def scene(self) -> Scene:
        """The evaluated scene."""
        return self.depsgraph.scene

    def objects(self, rows: Collection[int]) -> list[Object]:
        """The objects in some rows. Blender looks for one by its number among all that come
        before."""
        every = bpy.data.objects if len(rows) <= FEW else tuple(bpy.data.objects)
        few = self.few or {}
        return [few.get(row) or every[row] for row in rows]
