"""The collision shapes of objects, built again where their surfaces have changed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import bpy
import numpy as np
from bpy.types import Object

from ...core.arrays import FloatArray
from ...core.contacts.surface_shape import SurfaceShape
from ...core.contacts.tracker import STILL
from .bone_parts import BoneParts, armature_of, parts_at_rest, rest_checksum
from .changes import Changes
from .collision_shapes import (
    collision_shape,
    distance_of_cloth,
    hides_multires,
    mesh_checksum,
    mesh_number,
    shape_settings,
)
from .tagged import Tagged


class _Built(NamedTuple):
    """A shape, the stretch and settings that it was built with, and the checksum of its mesh."""

    settings: Any
    content: Any
    surface: SurfaceShape


class _Posed(NamedTuple):
    """The parts of a mesh that bones deform, None if they move none of it; what these were made
    from, and the shape after their last ``motions``."""

    made_from: Any
    parts: BoneParts | None
    motions: FloatArray
    surface: SurfaceShape | None


class Shapes:
    """The shapes of the haptic objects of a scene. ``rebuilt``: how long reading a changed surface
    took the last time [ms], by name of the object."""

    def __init__(self) -> None:
        self.rebuilt: Mapping[str, float] = {}
        self._built: dict[int, _Built] = {}  # by session id
        self._posed: dict[int, _Posed] = {}  # the same, of those that bones deform
        # By evaluated mesh and settings, for objects that share a mesh; of one reading.
        self._shared: dict[Any, _Built] = {}
        # Session ids of objects and meshes whose geometry may have changed:
        self.unchecked: set[int] = set()
        self._postponed: set[int] = set()  # those that the next reading compares

    def forget(self) -> None:
        """Build every shape again."""
        self._built.clear()
        self._posed.clear()

    def recheck(self) -> None:
        """Compare all geometry with that of the shapes."""
        meshes = (mesh.session_uid for mesh in bpy.data.meshes)
        self.unchecked.update((*self._built, *self._posed, *meshes))

    @property
    def known(self) -> Set[int]:
        """Session ids of the objects whose shapes are known, without those that bones deform."""
        return self._built.keys()

    def note(self, edited: Iterable[int]) -> None:
        """Compare the geometry of these objects and meshes, by session id."""
        self.unchecked.update(edited)

    def to_check(self, rows: Mapping[int, int], exact: bool) -> set[int]:
        """The rows of the objects, of those by session id, to compare; if ``exact``, all that bones
        deform."""
        numbers = self.unchecked | self._posed.keys() if exact else self.unchecked
        return {rows[number] for number in numbers & rows.keys()}

    def begin(self, arrived: Iterable[int]) -> None:
        """Begin to read everything again. ``arrived``: session ids of objects that are there anew,
        of which Blender does not say what has changed before."""
        self.unchecked.update(arrived)
        self.rebuilt = {}

    def end(self) -> None:
        """End a reading."""
        self.unchecked, self._postponed = self._postponed, set()
        self._shared.clear()

    def follow(
        self, changes: Changes, rows: Iterable[int], records: Mapping[int, Tagged]
    ) -> tuple[dict[int, SurfaceShape], set[int]]:
        """The shapes of these rows that are no longer those of their ``records``, and the rows that
        have none any more."""
        found, gone = dict[int, SurfaceShape](), set[int]()
        ordered = sorted(rows)
        for row, obj in zip(ordered, changes.objects(ordered), strict=True):
            try:
                surface = self.of(obj, changes, np.array(records[row].stretch))
            except ValueError:
                gone.add(row)
                continue
            if surface is not records[row].surface:
                found[row] = surface
        return found, gone

    def of(self, obj: Object, changes: Changes, stretch: FloatArray) -> SurfaceShape:
        """The collision shape of an object with its world ``stretch`` (6,): the known one
        unless its settings or its mesh have changed. Raises ValueError if there is none."""
        if obj.haptics.surface == "SEEN" and obj.rigid_body is None:
            armature = armature_of(obj)
            surface = armature and self._of_bones(obj, armature, changes, stretch)
            if surface:
                return surface
        depsgraph, number = changes.depsgraph, obj.session_uid
        margin = distance_of_cloth(obj, depsgraph.scene)
        settings = tuple(stretch.tolist()), shape_settings(obj, depsgraph.scene), margin
        # None is left of a mesh that has no shape any more.
        known = self._built.pop(number, None)
        is_unchecked = number in self.unchecked
        if known is not None and known.settings != settings:
            known = None
        if known is not None and (not is_unchecked or hides_multires(obj)):
            self._built[number] = known
            return known.surface
        alike = mesh_number(obj, depsgraph), settings
        shared = self._shared.get(alike)
        if shared is not None:
            if known is None or known.content != shared.content:
                known = shared
            self._built[number] = known
            return known.surface
        started = perf_counter()
        content = mesh_checksum(obj, depsgraph)
        if known is None or known.content != content:
            known = _Built(settings, content, collision_shape(obj, depsgraph, stretch, margin))
            if is_unchecked and not changes.is_whole:
                milliseconds = 1000 * (perf_counter() - started)
                self.rebuilt = {**self.rebuilt, obj.name_full: milliseconds}
        self._built[number] = known
        if alike[0]:
            self._shared[alike] = known
        return known.surface

    def _of_bones(
        self, obj: Object, armature: Object, changes: Changes, stretch: FloatArray
    ) -> SurfaceShape | None:
        """The shape of a mesh that bones deform; None if they move none of it. The deviation is
        measured where everything is read, not from frame to frame."""
        depsgraph = changes.depsgraph
        made_from = tuple(stretch.tolist()), rest_checksum(obj, armature)
        known = self._posed.get(obj.session_uid)
        is_edited = obj.data is not None and obj.data.session_uid in self.unchecked
        if is_edited and obj.session_uid in changes.edited and not changes.is_whole:
            # After an edit of a property Blender names the mesh, too. To read all weights takes
            # long: the next reading does it that follows anything else.
            self._postponed |= {obj.session_uid, obj.data.session_uid}
            is_edited = False
        if known is None or known.made_from != made_from or is_edited:
            parts = parts_at_rest(obj, armature, stretch)
            known = _Posed(made_from, parts, np.zeros(()), None)
        parts, motions, surface = known.parts, known.motions, known.surface
        if parts is not None:
            now = parts.motions(obj, armature, depsgraph)
            moved = np.abs(now - motions).max()
            if surface is None or moved > (0.0 if changes.exact else STILL):
                motions = now
                deviation = 0.0 if surface is None else surface.deviation
                surface = SurfaceShape(parts.posed(now), deviation, parts.limbs)
            if changes.is_whole:
                deviation = parts.deviation(motions, obj, depsgraph, stretch)
                surface = replace(surface, deviation=deviation)
        self._posed[obj.session_uid] = _Posed(made_from, parts, motions, surface)
        return surface
