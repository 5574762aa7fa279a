"""The haptic instances of a scene, read as tagged objects."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from time import perf_counter

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Depsgraph
from numpy.typing import NDArray

from ...core.arrays import FloatArray
from ...core.contacts.settings import Body, Motion
from ...core.contacts.shapes import Shape
from ...core.scene.values import HapticObject
from ..blender.arrays import read_array
from .collision_shapes import shape_of_instance
from .evaluation import Evaluation
from .instances import (
    NONE,
    HapticInstance,
    all_matrices,
    haptic_instances,
    instanced_collections,
)
from .objects import read_object
from .poses import differ, rounded
from .problem import Problem, lost
from .tagged import Tagged
from .world_transforms import rigid_transforms


class InstanceRecords:
    """The instances of a scene.

    Attributes:
        records: of them, in rows after those of the objects.
        problems: of instances, and of what they show.
        milliseconds: of reading those that moved in the last frame; 0 if none may have.
    """

    def __init__(self) -> None:
        self.records: dict[int, Tagged] = {}
        self.problems: tuple[Problem, ...] = ()
        self.milliseconds = 0.0
        self._known = NONE
        self._are_moved = False
        self._have_no_shape = False

    @property
    def matrices(self) -> NDArray[np.float32]:
        """World matrices (n, 16) in metres, column by column."""
        return self._known.matrices

    @property
    def instancers(self) -> Set[int]:
        """Session ids of the objects that have instances."""
        return self._known.instancers

    @property
    def concerned(self) -> Set[int]:
        """Session ids of these and of the objects that the instances show."""
        return self._known.instancers | self._known.shown

    def note(self, evaluation: Evaluation) -> None:
        """Look where the instances are if an evaluation may have moved any."""
        self._are_moved |= not (
            self._known.instancers.isdisjoint(evaluation.objects)
            and self._known.shown.isdisjoint(evaluation.edited)
        )

    def follow(self, depsgraph: Depsgraph, unchecked: Set[int]) -> bool:
        """Look where the instances are if they may have moved; False if there may be others, or
        others of the objects that they show, by session ids, are ``unchecked``."""
        self.milliseconds = 0.0
        if not self._are_moved:
            return True
        started = perf_counter()
        matrices = self._known.moved(depsgraph)
        if (
            self._have_no_shape  # but may have one now
            or matrices is None
            or not unchecked.isdisjoint(self._known.shown)
            or differ(rigid_transforms(matrices)[1], self._stretches).any()
        ):
            return False
        self._are_moved = False
        self._known = replace(self._known, matrices=matrices)
        self.milliseconds = 1000 * (perf_counter() - started)
        return True

    @property
    def _stretches(self) -> FloatArray:
        known = [record.stretch for record in self.records.values()]
        return np.array(known, dtype=np.float64).reshape(-1, 6)

    def read(self, depsgraph: Depsgraph, first_row: int) -> None:
        """Read all instances, as objects in the rows from ``first_row`` on."""
        self._are_moved, self.milliseconds = False, 0.0
        self.records = {}
        places: list[int] = []
        instancers, shown = set[int](), set[int]()
        problems: dict[Problem, None] = {}
        raw = all_matrices(depsgraph)
        stretches = np.zeros((len(raw), 6))
        shared = np.flatnonzero(read_array(depsgraph.object_instances, "is_instance", 1, np.bool_))
        stretches[shared] = rounded(rigid_transforms(raw[shared])[1])
        alike = _Alike(depsgraph)
        for found in haptic_instances(depsgraph) if len(shared) else ():
            instancers.add(found.instancer.session_uid)
            if found.shown.original is not None and found.shown.original != found.instancer:
                shown.add(found.shown.original.session_uid)
            stretch = stretches[found.place]
            if np.isnan(stretch).any():
                problems[lost(found.owner)] = None
                continue
            try:
                item, body = alike.of(found, stretch)
            except ValueError as error:
                problems[Problem(found.owner.name_full, str(error))] = None
                continue
            row = first_row + len(places)
            lengths = tuple(stretch.tolist())
            self.records[row] = Tagged(row, (), lengths, item, body)
            places.append(found.place)
        self._have_no_shape = bool(problems)
        self.problems = (*_ignored_roles(depsgraph), *problems)
        self._known = NONE
        if instancers:
            identity = read_array(depsgraph.object_instances, "persistent_id", 8, np.int32)
            numbers = np.array(places, dtype=np.int64)
            self._known = replace(
                NONE,
                identity=identity,
                places=numbers,
                matrices=raw[numbers],
                instancers=frozenset(instancers),
                shown=frozenset(shown),
            )


class _Alike:
    """Haptic objects and shapes, which instances of one owner, mesh and stretch share."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._objects: dict[int, HapticObject] = {}  # by session id of the owner
        self._shapes: dict[tuple[float, ...], Shape] = {}

    def of(self, found: HapticInstance, stretch: FloatArray) -> tuple[HapticObject, Body]:
        """The haptic object and the body of an instance with this ``stretch`` (6,). Raises
        ValueError if it has no shape."""
        owner = found.owner
        number = owner.session_uid
        data = 0 if found.shown.data is None else found.shown.data.as_pointer()
        key = number, data, *stretch.tolist()
        if number not in self._objects:
            read = read_object(owner, self._depsgraph.scene)
            self._objects[number] = replace(read, motion=Motion.KINEMATIC)
        item = replace(self._objects[number], name=found.name)
        if key not in self._shapes:
            self._shapes[key] = shape_of_instance(found, self._depsgraph, stretch).shape
        return item, Body.of(item, self._shapes[key])


def _ignored_roles(depsgraph: Depsgraph) -> Iterator[Problem]:
    """The problems of collection instances with sources or listeners, which are ignored."""
    for instancer, shown in instanced_collections(depsgraph):
        if any(obj.haptics.source.enabled or obj.haptics.listener.enabled for obj in shown):
            words = iface_(
                "the sources and listeners of its collection don't count here: use Object > "
                "Apply > Make Instances Real"
            )
            yield Problem(instancer.name_full, words)
