"""What is authored of the tagged objects, with the values that animation gives it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.settings import Body
from ...core.contacts.surface_shape import SurfaceShape
from ..blender import compatibility
from ..blender.progress import progress
from .animated_curves import AnimatedCurves
from .changes import Changes
from .instance_records import InstanceRecords
from .objects import has_body_of, read_listener, read_object, read_source
from .poses import differ, rounded
from .present import evaluated_in
from .problem import Problem, lost, only_instances, without_carrier
from .roles import haptic_carrier, is_silenced, solo_roles
from .shapes import Shapes
from .tagged import Tagged, TaggedLists
from .tagged_objects import TaggedObjects
from .triggers import read_triggers


class Authored:
    """The tagged objects of a scene as values of the core.

    Attributes:
        records: of them, by row.
        edited: session ids of those with properties that were edited since the last reading.
        solo: roles with a solo object.
    """

    def __init__(self, objects: TaggedObjects, instances: InstanceRecords, shapes: Shapes) -> None:
        self.records: dict[int, Tagged] = {}
        self.edited: set[int] = set()
        self.solo: frozenset[str] = frozenset()
        self._objects, self._instances, self._shapes = objects, instances, shapes
        self._curves = AnimatedCurves()
        self._animated: dict[int, tuple[Any, ...]] = {}  # last values by row

    def read(self, changes: Changes, stretches: FloatArray) -> None:
        """Read all tagged objects, whose stretches are (m, 6): the known ones where only rounding
        differs."""
        rows = list(self._objects.rows.values())
        objects = changes.objects(rows)
        self._curves.clear()
        self._animated.clear()
        self.solo = solo_roles(objects)
        lengths = rounded(stretches)
        known = lengths.copy()
        for k, row in enumerate(rows):
            if row in self.records:
                known[k] = self.records[row].stretch
        lengths = np.where(differ(lengths, known)[:, None], lengths, known)
        self.records = {
            row: self._record(row, obj, changes, stretch)
            for row, obj, stretch in progress(tuple(zip(rows, objects, lengths, strict=True)))
        }
        animated = [row for row, record in self.records.items() if record.animated != ()]
        self._note_animated(changes, animated)

    def to_read(self, changes: Changes, lists: TaggedLists, unchecked: Set[int]) -> set[int]:
        """The rows of objects of which more may have changed than place and shape: those whose
        properties animation has changed or somebody has edited, and, of the rows whose geometry is
        ``unchecked``, those with another rigid body or other drivers, which Blender names as
        changes of geometry."""
        rows = self._objects.rows
        found = {rows[number] for number in self.edited & rows.keys()}
        found |= self._note_animated(changes, lists.animated)
        others = sorted(unchecked - found)
        for row, obj in zip(others, changes.objects(others), strict=True):
            known = self.records[row]
            if (
                known.object is None
                or not has_body_of(obj, known.object, changes.scene)
                or compatibility.animated_paths(obj) != known.animated
            ):
                found.add(row)
        return found

    def follow(
        self, changes: Changes, rows: Iterable[int], stretched: Mapping[int, FloatArray]
    ) -> bool:
        """Read the objects in some ``rows`` again, some of them ``stretched`` otherwise than was
        known; whether any record has changed."""
        changed = self._changed(changes, sorted(rows), stretched)
        if any((new.object is None) != (self.records[new.row].object is None) for new in changed):
            # Sources and listeners may now be on another object, or on none.
            changed = self._changed(changes, [*self.records], stretched)
        for record in changed:
            if record.animated != self.records[record.row].animated:
                self._animated.pop(record.row, None)  # the values were those of other properties
            self.records[record.row] = record
        return bool(changed)

    def reshape(self, surfaces: Mapping[int, SurfaceShape]) -> dict[int, Tagged]:
        """Take over the shapes of haptic objects, by row, of which nothing else has changed; their
        records."""
        reshaped = {}
        for row, surface in surfaces.items():
            item = self.records[row].object
            assert item is not None
            body = Body.of(item, surface.shape, surface.limbs)
            reshaped[row] = replace(self.records[row], body=body, surface=surface)
        self.records |= reshaped
        return reshaped

    def _changed(
        self, changes: Changes, rows: list[int], stretched: Mapping[int, FloatArray]
    ) -> list[Tagged]:
        """The records of some rows that are now others."""
        records = (
            self._record(row, obj, changes, stretched.get(row, np.array(self.records[row].stretch)))
            for row, obj in zip(rows, changes.objects(rows), strict=True)
        )
        return [record for record in records if record != self.records[record.row]]

    def _note_animated(self, changes: Changes, rows: Sequence[int]) -> set[int]:
        """Which of the objects in some rows have properties that animation has changed since the
        last call, or may have where it can't be told."""
        found = set()
        objects = evaluated_in(changes.objects(rows), changes.depsgraph)
        for row, obj in zip(rows, objects, strict=True):
            paths = self.records[row].animated
            values = None if paths is None else _values_at(obj, paths)
            if values is None or values != self._animated.get(row):
                found.add(row)
            if values is not None:
                self._animated[row] = values
        return found

    def _record(self, row: int, obj: Object, changes: Changes, stretch: FloatArray) -> Tagged:
        """The roles of an object as values of the core, and the problems that prevent any."""
        (now,) = evaluated_in([obj], changes.depsgraph)
        animated = compatibility.animated_paths(obj)
        lengths = tuple(stretch.tolist())
        if np.isnan(stretch).any():
            return Tagged(row, animated, lengths, problems=(lost(obj),))
        problems: list[Problem] = []
        item = body = surface = None
        if now.haptics.enabled:
            try:
                surface = self._shapes.of(obj, changes, stretch)
                item = read_object(now, changes.scene)
                body = Body.of(item, surface.shape, surface.limbs)
            except ValueError as error:
                if obj.session_uid not in self._instances.instancers:
                    problems.append(Problem(obj.name_full, str(error)))
                elif now.haptics.source.enabled or now.haptics.listener.enabled:
                    problems.append(only_instances(obj))
        carrier = haptic_carrier(obj)
        if carrier is not None and carrier.session_uid not in self._objects.rows:
            # An armature keeps its body when that is deleted.
            carrier = carrier if carrier.users_collection else None
        source = listener = None
        for role in ("source", "listener"):
            if not getattr(now.haptics, role).enabled or (carrier == obj and item is None):
                continue  # the object's own problem reports it
            if carrier is None:
                problems.append(without_carrier(obj, role))
                continue
            silenced = is_silenced(now, role, self.solo)
            try:
                if role == "listener":
                    listener = read_listener(now, carrier.name_full, silenced)
                    continue
                triggers, wrong = read_triggers(obj, changes.scene)
                problems += wrong
                frequency = self._curves.of_source(obj, changes.scene)
                source = read_source(now, carrier.name_full, frequency, silenced)
                source = replace(source, triggers=triggers)
            except (OSError, ValueError) as error:
                words = str(error).replace("mixing_expression", "the mixing formula")
                rule = ("signal", 0) if role == "source" else None
                problems.append(Problem(obj.name_full, words, rule))
        return Tagged(
            row, animated, lengths, item, body, surface, source, listener, tuple(problems)
        )


def _values_at(obj: Object, paths: tuple[str, ...]) -> tuple[Any, ...]:
    """The values at data paths of an object, None for an invalid path."""
    values = []
    for path in paths:
        try:
            value: Any = obj.path_resolve(path)
        except ValueError:
            value = None
        values.append(tuple(value) if hasattr(value, "__iter__") else value)
    return tuple(values)
