"""Reads a Blender scene into the values of the core.

Authored values are read when they change, transforms at every frame, all matrices in one call. No
bpy object is kept between calls: only session ids, row numbers and plain values.
"""

from __future__ import annotations

from collections.abc import Set
from typing import Any

import numpy as np
from bpy.types import Depsgraph, Scene
from numpy.typing import NDArray

from ...core.arrays import IntArray
from ...core.scene.values import Listener, Source
from ..blender.time import frame_seconds, seconds_of, stretching
from ..blender.units import metres_per_unit
from ..changes.revisions import SCENE
from .authored import Authored
from .changes import FEW, Changes
from .evaluation import Evaluation
from .instance_records import InstanceRecords
from .places import Places
from .poses import Poses
from .reading import Reading
from .settings import SceneSettings
from .shapes import Shapes
from .signals import is_audible
from .tagged import TaggedLists
from .tagged_objects import TaggedObjects
from .world_transforms import in_metres, matrices_of, world_matrices


class SceneReader:
    """Reads one scene at every frame.

    A *row* is the number of an object in `bpy.data.objects`, by which Blender returns the matrices
    of all objects in one call; instances follow in the rows after the last object. What was read is
    kept by row, and read again in the next `read` only where it may have changed. The callers say
    what may have: `forget` after an edit of properties, `note` after an evaluation by Blender.
    """

    def __init__(self) -> None:
        self._objects = TaggedObjects()
        self._instances = InstanceRecords()
        self._shapes = Shapes()
        self._poses = Poses()
        self._authored = Authored(self._objects, self._instances, self._shapes)
        self._settings = SceneSettings()
        self._lists: TaggedLists | None = None  # of the last reading
        self._places = Places()
        self._frame = 0  # of the last reading
        self._evaluations = 0  # that were noted since
        self._wholly_read_with: Any = None  # see `_depended_on`

    def forget(self) -> None:
        """Make the next `read` read everything."""
        self._objects.forget()

    def reread(self, objects: Set[int] | None) -> None:
        """Make the next `read` read these objects, by session id, or settings and rules for
        `SCENE`, because an authored value of theirs has changed; everything for None, and where
        others may depend on them."""
        if objects is not None and SCENE in objects:
            self._settings.forget_rules()
            objects -= {SCENE}
        if (
            objects is None
            or not objects <= self._objects.rows.keys()
            or (self._lists is not None and self._lists.are_triggered)
            or not objects.isdisjoint(self._instances.concerned)
        ):
            self.forget()
        else:
            self._authored.edited |= objects

    def forget_shapes(self) -> None:
        """Make the next `read` build every shape again."""
        self._shapes.forget()
        self.forget()

    def recheck_shapes(self) -> None:
        """Make the next `read` read all objects with shapes, and compare all geometry."""
        self._authored.edited |= self._shapes.known
        self.recheck_geometry()

    def recheck_geometry(self) -> None:
        """Make the next `read` compare all geometry with that of the shapes."""
        self._shapes.recheck()

    def note(self, evaluation: Evaluation) -> None:
        """Make the next `read` compare what an evaluation may have changed."""
        self._evaluations += 1
        self._objects.note(evaluation)
        self._shapes.note(evaluation.edited)
        self._instances.note(evaluation)
        if evaluation.joints:
            self._settings.forget_rules()

    @property
    def is_empty(self) -> bool:
        """True if the last reading found no tagged object, and nothing has changed since."""
        is_any = self._authored.records or self._instances.records
        return self._objects.are_known and not is_any

    def read(
        self,
        scene: Scene,
        depsgraph: Depsgraph,
        exact: bool = False,
        evaluation: Evaluation | None = None,
        frame: int | None = None,
    ) -> Reading:
        """The scene in a ``frame``, as ``depsgraph`` has evaluated it.

        Args:
            scene: the scene.
            depsgraph: its evaluation.
            exact: also motions below the tolerance of rest count; so they do in any frame that is
                not the next one.
            evaluation: the changes up to now, noted last; None if they may be others. If no other
                one was noted since the last reading, only these are read.
            frame: that was evaluated; None for the scene's current one.
        """
        frame = scene.frame_current if frame is None else frame
        jumps = frame - self._frame not in (0, 1)
        if jumps:  # of which Blender doesn't tell what scripts have edited
            self._settings.forget_rules()
        changes = self._changes(depsgraph, exact or jumps, evaluation)
        lists = self._read_whole(changes) if changes.is_whole else self._follow(changes)
        self._finish(scene, frame, lists)
        return self._reading(scene, frame, lists)

    def _changes(self, depsgraph: Depsgraph, exact: bool, evaluation: Evaluation | None) -> Changes:
        """What may have changed since the last reading."""
        only = evaluation if self._evaluations == 1 and not exact else None
        # Of one that does not name all, more may follow that is not noted.
        self._evaluations = int(evaluation is None or not evaluation.names_all)
        if self._wholly_read_with != self._depended_on(depsgraph.scene) or not (
            self._instances.follow(depsgraph, self._shapes.unchecked)
        ):
            self.forget()
        few = None
        if only is not None and self._covers(only, depsgraph):
            few = self._objects.by_row(only.objects)
        is_whole = few is None and (self._objects.follow(depsgraph) or self._lists is None)
        edited = frozenset(self._authored.edited)
        metres = metres_per_unit(depsgraph.scene)
        return Changes(depsgraph, metres, exact, is_whole, few, edited)

    def _depended_on(self, scene: Scene) -> tuple[Any, ...]:
        """What everything is read again for: the unit, the frames, the contact tolerance, and, if
        any source has triggers, the timeline's markers."""
        are_triggered = self._lists is not None and self._lists.are_triggered
        return (
            metres_per_unit(scene),
            *(scene.frame_start, scene.frame_end, frame_seconds(scene), stretching(scene)),
            scene.haptics.contact_tolerance,
            [(marker.name, marker.frame) for marker in scene.timeline_markers]
            if are_triggered
            else [],
        )

    def _covers(self, evaluation: Evaluation, depsgraph: Depsgraph) -> bool:
        """Whether nothing has changed since the last reading but the matrices and surfaces of the
        few objects of this ``evaluation``."""
        return (
            evaluation.names_all
            and len(evaluation.objects) <= FEW
            and self._lists is not None
            and not self._lists.animated
            and not self._lists.are_triggered
            and not self._instances.milliseconds
            and self._objects.are_those_of(evaluation, depsgraph)
            and self._shapes.unchecked & self._objects.rows.keys() <= evaluation.objects.keys()
        )

    def _read_whole(self, changes: Changes) -> TaggedLists:
        """Read everything again: there are other objects, or what others depend on has changed."""
        self._lists = None
        self._shapes.begin(self._objects.arrived)
        rows = np.array(list(self._objects.rows.values()), dtype=np.int64)
        self._instances.read(changes.depsgraph, self._objects.count)
        self._poses.carry(changes.objects(rows.tolist()))
        stretches = self._poses.take(self._matrices(changes, rows), changes.exact)
        self._authored.read(changes, stretches[: len(rows)])
        self._settings.forget_rules()
        return TaggedLists.of({**self._authored.records, **self._instances.records})

    def _follow(self, changes: Changes) -> TaggedLists:
        """Read what may have changed since the last reading: where the objects and instances are,
        and all of the objects with animated properties, another scale or an edited mesh."""
        lists = self._lists
        assert lists is not None
        rows = self._objects.rows
        matrices = self._matrices(changes, lists.rows[: len(rows)])
        stretched = self._poses.follow(matrices, lists, changes.exact)
        unchecked = self._shapes.to_check(rows, changes.exact)
        to_read = stretched.keys() | self._authored.to_read(changes, lists, unchecked)
        surfaces, gone = self._shapes.follow(changes, unchecked - to_read, self._authored.records)
        reshaped = self._authored.reshape(surfaces)
        if not self._authored.follow(changes, to_read | gone, stretched):
            return lists.reshaped(reshaped) if reshaped else lists
        return TaggedLists.of({**self._authored.records, **self._instances.records}, lists)

    def _matrices(self, changes: Changes, rows: IntArray) -> NDArray[np.float32]:
        """World matrices (m, 16) in metres of the objects in some rows, and of the instances."""
        if changes.few is not None and self._lists is not None:
            numbers = self._lists.rows.searchsorted(list(changes.few))
            found = matrices_of(changes.few.values(), changes.depsgraph)
            return self._poses.with_some(numbers, in_metres(found, changes.metres))
        everywhere = world_matrices(self._objects.count, changes.depsgraph)
        own = in_metres(everywhere.take(rows, axis=0), changes.metres)
        return np.concatenate([own, self._instances.matrices]) if self._instances.records else own

    def _finish(self, scene: Scene, frame: int, lists: TaggedLists) -> None:
        """Take over what was read."""
        self._places.follow(lists, self._poses)
        self._settings.follow(scene, lists.objects, self._authored.solo)
        self._lists, self._frame = lists, frame
        self._wholly_read_with = self._depended_on(scene)
        self._authored.edited.clear()
        self._shapes.end()

    def _reading(self, scene: Scene, frame: int, lists: TaggedLists) -> Reading:
        """What was read."""
        now, duration = seconds_of(scene, frame), frame_seconds(scene)
        audible = [item for item in self._places.roles if is_audible(item, now, duration)]
        milliseconds = self._instances.milliseconds
        return Reading(
            objects=lists.objects,
            bodies=lists.bodies,
            transforms=self._places.transforms,
            sources=tuple(item for item in audible if isinstance(item, Source)),
            listeners=tuple(item for item in audible if isinstance(item, Listener)),
            settings=self._settings.settings,
            contact_settings=self._settings.contact_settings,
            problems=(*self._instances.problems, *self._settings.problems, *lists.problems),
            hulls=lists.hulls,
            moving_instances=(len(self._instances.records), milliseconds) if milliseconds else None,
            rebuilt=self._shapes.rebuilt,
        )
