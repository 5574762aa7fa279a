"""Reads a Blender scene into the values of the core.

Authored values are read when they change, transforms at every frame, all matrices in one call. No
bpy object is kept between calls: only session ids, row numbers and plain values.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator, Mapping, Set
from dataclasses import replace
from time import perf_counter
from typing import Any

import bpy
import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Depsgraph, Object, Scene
from numpy.typing import NDArray

from ...core.arrays import BoolArray, FloatArray, IntArray
from ...core.contacts.settings import Body, ContactSettings, Motion
from ...core.contacts.surface_shape import SurfaceShape
from ...core.contacts.tracker import STILL
from ...core.scene.rule_table import RuleTable
from ...core.scene.values import HapticObject, Listener, Settings, Source
from ..blender import compatibility
from ..blender.arrays import read_array
from ..blender.progress import progress
from ..blender.time import frame_seconds, seconds_of, stretching
from ..blender.units import metres_per_unit
from ..changes.revisions import SCENE
from .animated_curves import AnimatedCurves
from .bone_parts import BoneParts, armature_of, parts_at_rest, rest_checksum
from .collision_shapes import (
    collision_shape,
    distance_of_cloth,
    hides_multires,
    mesh_checksum,
    mesh_number,
    shape_of_instance,
    shape_settings,
)
from .evaluation import Evaluation
from .instances import (
    NONE,
    Instances,
    all_matrices,
    haptic_instances,
    instanced_collections,
)
from .objects import has_body_of, read_listener, read_object, read_source
from .parented import ParentedPoses
from .present import evaluated_in, present_and_disabled
from .problem import Problem
from .reading import Reading
from .renamed import ObjectsMeant
from .roles import haptic_carrier, is_silenced, is_tagged, solo_roles
from .rules import read_tables
from .settings import read_contact_settings, read_settings, setting_values
from .signals import is_audible
from .tagged import Tagged, TaggedLists
from .triggers import read_triggers
from .world_transforms import (
    in_metres,
    matrices_of,
    rigid_transforms,
    session_ids,
    world_matrices,
)

_FEW = 16
"""Objects up to which reading them alone takes less time than the matrices of all."""


class SceneReader:
    """Reads one scene at every frame.

    A *row* is the number of an object in `bpy.data.objects`, by which Blender returns the matrices
    of all objects in one call; instances follow in the rows after the last object. What was read is
    kept by row, and read again in the next `read` only where it may have changed. The callers say
    what may have: `forget` after an edit of properties, `note` after an evaluation by Blender.
    """

    def __init__(self) -> None:
        self._session_ids: NDArray[np.int32] | None = None
        self._present = np.zeros(0, dtype=np.int32)  # session ids
        self._disabled: frozenset[int] = frozenset()  # session ids, see `present_and_disabled`
        self._tagged: dict[int, Tagged] = {}  # by row
        self._rows: dict[int, int] = {}  # of the tagged objects, by session id
        self._names: dict[int, str] = {}  # the same, of their full names
        self._shapes: dict[
            int, tuple[Any, Any, SurfaceShape]
        ] = {}  # by session id: what it was built from, its mesh's checksum, and the shape
        # The same by evaluated mesh and settings, for objects that share a mesh; of one reading.
        self._alike: dict[Any, tuple[Any, Any, SurfaceShape]] = {}
        # By session id: what they were made from, the parts, their last motions, and the shape.
        self._bone_parts: dict[
            int, tuple[Any, BoneParts | None, FloatArray, SurfaceShape | None]
        ] = {}
        self._rebuilt: dict[str, float] = {}
        self._parented = ParentedPoses({})
        self._exact, self._frame = False, 0  # see `read`
        self._evaluations = 0  # that were noted since the last reading
        self._layer = ""  # view layer of the objects
        self._metres = 1.0  # per unit
        # First and last frame, seconds a frame, stretching, and contact tolerance.
        self._of_scene = (0, 0, 0.0, 1.0, 0.0)
        self._instances = NONE
        self._is_instance_moved = False
        self._problems_of_instances: tuple[Problem, ...] = ()
        self._instance_milliseconds = 0.0  # of reading those that moved in the last frame
        self._values: tuple[Any, ...] | None = None  # what the settings were read from
        self._settings = Settings()
        self._contact_settings = ContactSettings()
        self._unchecked: set[int] = set()  # session ids of objects whose geometry may have changed
        self._authored: set[int] = set()  # and of those with properties that may have
        self._postponed: set[int] = set()  # of the first, those that the next reading compares
        self._curves = AnimatedCurves()
        # By row: what its animated properties were last.
        self._animated: dict[int, tuple[Any, ...]] = {}
        self._lists: TaggedLists | None = None
        # Matrices of the tagged rows as they were read last.
        self._raw = np.zeros((0, 16), dtype=np.float32)
        self._rigid = np.zeros((0, 4, 4))  # of the tagged rows
        self._transforms = np.zeros((0, 4, 4))  # of the bodies
        self._placed: list[Source | Listener] = []  # with their positions in this frame
        self._anchors = np.zeros((0, 3))  # see `TaggedLists.anchors`
        self._tables: dict[str, Any] | None = None  # of rules
        self._meant = ObjectsMeant()
        # Problems of instances; those of objects are in `Tagged`.
        self._problems_beside: tuple[Problem, ...] = ()
        self._problems_of_rules: list[Problem] = []
        self._markers: tuple[tuple[str, int], ...] = ()
        self.solo_roles: frozenset[str] = frozenset()

    def forget(self) -> None:
        """Make the next `read` read everything."""
        self._session_ids = None

    def reread(self, objects: Set[int] | None) -> None:
        """Make the next `read` read these objects, by session id, or settings and rules for
        `SCENE`, because an authored value of theirs has changed; everything for None, and where
        others may depend on them."""
        if objects is not None and SCENE in objects:
            self._tables = None
            objects -= {SCENE}
        if (
            objects is None
            or not objects <= self._rows.keys()
            or self._is_triggered
            or not objects.isdisjoint(self._instances.instancers | self._instances.shown)
        ):
            self.forget()
        else:
            self._authored |= objects

    def forget_shapes(self) -> None:
        """Make the next `read` build every shape again."""
        self._shapes.clear()
        self._bone_parts.clear()
        self._session_ids = None

    def recheck_shapes(self) -> None:
        """Make the next `read` read all objects with shapes, and compare all geometry."""
        self._authored.update(self._shapes)
        self.recheck_geometry()

    def recheck_geometry(self) -> None:
        """Make the next `read` compare all geometry with that of the shapes."""
        meshes = (mesh.session_uid for mesh in bpy.data.meshes)
        self._unchecked.update((*self._shapes, *self._bone_parts, *meshes))

    def note(self, evaluation: Evaluation) -> None:
        """Make the next `read` compare what an evaluation may have changed."""
        self._evaluations += 1
        changed = evaluation.objects
        if any(changed[k].name_full != self._names[k] for k in changed.keys() & self._names.keys()):
            self.forget()
        self._unchecked |= evaluation.edited
        self._tables = None if evaluation.joints else self._tables
        known = self._instances
        self._is_instance_moved |= not (
            known.instancers.isdisjoint(evaluation.objects)
            and known.shown.isdisjoint(evaluation.edited)
        )

    @property
    def is_empty(self) -> bool:
        """True if the last reading found no tagged object, and nothing has changed since."""
        return self._session_ids is not None and not self._tagged

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
        exact = exact or frame - self._frame not in (0, 1)
        self._exact, self._frame = exact, frame
        only = evaluation if self._evaluations == 1 and not exact else None
        # Of one that does not name all, more may follow that is not noted.
        self._evaluations = int(evaluation is None or not evaluation.names_all)
        metres = metres_per_unit(scene)
        of_scene = (
            *(scene.frame_start, scene.frame_end, frame_seconds(scene), stretching(scene)),
            scene.haptics.contact_tolerance,
        )
        if (metres, of_scene) != (self._metres, self._of_scene):
            self._metres, self._of_scene, self._session_ids = metres, of_scene, None
        if self._marked(scene) != self._markers or not self._move_instances(depsgraph):
            self._session_ids = None
        if only is not None and self._covers(only, depsgraph):
            lists = self._read_changed(scene, depsgraph, exact, only.objects)
        else:
            lists = self._read_changed(scene, depsgraph, exact)
        now = seconds_of(scene, frame)
        duration = frame_seconds(scene)
        audible = [item for item in self._placed if is_audible(item, now, duration)]
        self._read_settings(scene)
        self._markers = self._marked(scene)
        return Reading(
            objects=lists.objects,
            bodies=lists.bodies,
            transforms=self._transforms,
            sources=tuple(item for item in audible if isinstance(item, Source)),
            listeners=tuple(item for item in audible if isinstance(item, Listener)),
            settings=self._settings,
            contact_settings=self._contact_settings,
            problems=(*self._problems_beside, *self._problems_of_rules, *lists.problems),
            hulls=lists.hulls,
            moving_instances=(len(self._instances.places), self._instance_milliseconds)
            if self._instance_milliseconds
            else None,
            rebuilt=self._rebuilt,
        )

    def _covers(self, evaluation: Evaluation, depsgraph: Depsgraph) -> bool:
        """Whether nothing has changed since the last reading but the matrices and surfaces of the
        few objects of this ``evaluation``."""
        return (
            evaluation.names_all
            and len(evaluation.objects) <= _FEW
            and self._session_ids is not None
            and self._lists is not None
            and not self._lists.animated
            and not self._is_triggered
            and not self._instance_milliseconds
            and self._layer == depsgraph.view_layer.name
            and self._unchecked & self._rows.keys() <= evaluation.objects.keys()
            # Animation may have changed whether they are there.
            and all(
                obj.hide_viewport == (number in self._disabled)
                for number, obj in evaluation.objects.items()
            )
        )

    def _read_everywhere(self, scene: Scene, depsgraph: Depsgraph) -> NDArray[np.float32]:
        """World matrices (n, 16) of all objects and instances by row, after reading everything
        again if there are others or an authored value has changed."""
        ids = session_ids()
        raw = in_metres(world_matrices(len(ids), depsgraph), self._metres)
        layer = depsgraph.view_layer
        present, self._disabled = present_and_disabled(layer)
        if (
            self._session_ids is None
            or not np.array_equal(self._session_ids, ids)
            or not np.array_equal(self._present, present)
        ):
            # Blender does not say what has changed of an object before that is there again.
            self._unchecked |= set(present.tolist()) - set(self._present.tolist())
            self._present = present
            self._read_all(depsgraph, raw)
            self._problems_beside = (
                *_instance_problems(depsgraph),
                *self._problems_of_instances,
            )
            self._session_ids, self._tables = ids, None
        self._layer = layer.name
        if self._instances is not NONE:
            raw = np.concatenate([raw, self._instances.matrices])
        return raw

    def _read_settings(self, scene: Scene) -> None:
        """Read the settings and rules if they have changed."""
        values = setting_values(scene)
        if self._tables is None:
            objects = [
                tagged.object for tagged in self._tagged.values() if tagged.object is not None
            ]
            self._tables, self._problems_of_rules = read_tables(scene, objects)
        elif values == self._values:
            return
        self._settings = read_settings(scene)
        contact_settings = read_contact_settings(scene, self._tables)
        if "source" in self.solo_roles:
            contact_settings = replace(contact_settings, impacts=False, textures=RuleTable())
        self._contact_settings = contact_settings
        self._values = values

    def _marked(self, scene: Scene) -> tuple[tuple[str, int], ...]:
        """The names and frames of the timeline's markers, if any source has triggers."""
        return (
            tuple((marker.name, marker.frame) for marker in scene.timeline_markers)
            if self._is_triggered
            else ()
        )

    @property
    def _is_triggered(self) -> bool:
        """Whether any source has triggers."""
        return any(isinstance(item, Source) and item.triggers is not None for item in self._placed)

    def _read_all(self, depsgraph: Depsgraph, raw: NDArray[np.float32]) -> None:
        """Read all tagged objects and instances; ``raw``: world matrices (n, 16) by row."""
        shown = set(self._present.tolist())
        tagged = {
            row: obj
            for row, obj in enumerate(bpy.data.objects)
            if obj.session_uid in shown and is_tagged(obj)
        }
        self._meant.follow(depsgraph.scene)
        self._rows = {obj.session_uid: row for row, obj in tagged.items()}
        self._names = {obj.session_uid: obj.name_full for obj in tagged.values()}
        self._lists = None
        self._rebuilt = {}
        self._curves.clear()
        self._animated.clear()
        self.solo_roles = solo_roles(tagged.values())
        rows = list(tagged)
        found = rigid_transforms(raw[np.array(rows, dtype=np.int64)])[1]
        stretches = dict(zip(rows, self._stretches(rows, found), strict=True))
        instances = self._read_instances(depsgraph, len(raw))
        self._tagged = {
            row: self._read_object(row, obj, depsgraph, stretches[row])
            for row, obj in progress(tuple(tagged.items()))
        }
        self._tagged |= instances
        numbers = {obj.session_uid: k for k, obj in enumerate(tagged.values())}
        # Below an untagged root, as imports have it, the first tagged one carries the others.
        leaders = dict(numbers)
        carried = {}
        for k, obj in enumerate(tagged.values()):
            above = _tagged_above(obj, numbers)
            leader = k if above is None else leaders.setdefault(above.session_uid, k)
            if leader != k:
                carried[k] = leader
        if carried != self._parented.carried:  # else poses stay what they were to the last bit
            self._parented = ParentedPoses(carried)

    def _move_instances(self, depsgraph: Depsgraph) -> bool:
        """Update the matrices of the instances if they may have moved. Returns False if there are
        others than before, so that everything has to be read."""
        self._instance_milliseconds = 0.0
        if not self._is_instance_moved or self._session_ids is None or self._lists is None:
            return True
        self._is_instance_moved = False
        if self._problems_of_instances:  # one without a shape may have one now
            return False
        started = perf_counter()
        matrices = self._instances.moved(depsgraph)
        if matrices is None or not self._unchecked.isdisjoint(self._instances.shown):
            return False
        known = self._lists.stretches[-len(matrices) :]
        if _differ(rigid_transforms(matrices)[1], known).any():
            return False
        self._instances = replace(self._instances, matrices=matrices)
        self._instance_milliseconds = 1000 * (perf_counter() - started)
        return True

    def _read_instances(self, depsgraph: Depsgraph, rows: int) -> dict[int, Tagged]:
        """All instances, as objects in the rows after ``rows``."""
        self._is_instance_moved = False
        tagged: dict[int, Tagged] = {}
        places: list[int] = []
        matrices: list[NDArray[np.float32]] = []
        instancers = set()
        shown = set()
        objects: dict[int, HapticObject] = {}
        shapes: dict[tuple[Any, ...], SurfaceShape] = {}
        problems: dict[Problem, None] = {}
        raw = all_matrices(depsgraph)
        stretches = np.zeros((len(raw), 6))
        shared = np.flatnonzero(read_array(depsgraph.object_instances, "is_instance", 1, np.bool_))
        stretches[shared] = _rounded(rigid_transforms(raw[shared])[1])
        for found in haptic_instances(depsgraph) if len(shared) else ():
            owner, name = found.owner, found.name
            instancers.add(found.instancer.session_uid)
            if found.shown.original is not None and found.shown.original != found.instancer:
                shown.add(found.shown.original.session_uid)
            stretch = stretches[found.place]
            data = 0 if found.shown.data is None else found.shown.data.as_pointer()
            if np.isnan(stretch).any():
                problems[_lost(owner)] = None
                continue
            key = owner.session_uid, data, *stretch.tolist()
            try:
                if owner.session_uid not in objects:
                    objects[owner.session_uid] = replace(
                        read_object(owner, depsgraph.scene), motion=Motion.KINEMATIC
                    )
                if key not in shapes:
                    shapes[key] = shape_of_instance(found, depsgraph, stretch)
            except ValueError as error:
                problems[Problem(owner.name_full, str(error))] = None
                continue
            item = replace(objects[owner.session_uid], name=name)
            shape = shapes[key]
            body = Body.of(item, shape.shape)
            row = rows + len(places)
            tagged[row] = Tagged(row, (), tuple(stretch.tolist()), item, body, None, None, None, ())
            places.append(found.place)
            matrices.append(raw[found.place])
        self._problems_of_instances = tuple(problems)
        self._instances = NONE
        if instancers:
            identity = read_array(depsgraph.object_instances, "persistent_id", 8, np.int32)
            self._instances = Instances(
                identity,
                np.array(places, dtype=np.int64),
                np.array(matrices, dtype=np.float32).reshape(-1, 16),
                frozenset(instancers),
                frozenset(shown),
            )
        return tagged

    def _read_changed(
        self,
        scene: Scene,
        depsgraph: Depsgraph,
        exact: bool,
        only: Mapping[int, Object] | None = None,
    ) -> TaggedLists:
        """Read what may have changed since the last frame: the transforms of all objects, and all
        of those with animated properties, another scale or an edited mesh.

        Args:
            scene: in its current frame.
            depsgraph: with the evaluated scene.
            exact: as of `read`.
            only: the objects that may have changed, by session id; None if any may.
        """
        evaluated = {} if only is None else self._by_row(only)
        if only is None:
            everything = self._read_everywhere(scene, depsgraph)
            lists = self._lists or TaggedLists.of(self._tagged)
            raw = everything.take(lists.rows, axis=0)
        else:
            assert self._lists is not None
            lists = self._lists
            raw = self._raw.copy()
            matrices = in_metres(matrices_of(evaluated.values(), depsgraph), self._metres)
            raw[lists.rows.searchsorted(list(evaluated))] = matrices
        animated = evaluated_in(
            _objects_in([row for row, _ in lists.animated], evaluated), depsgraph
        )
        rows = {
            row
            for (row, paths), obj in zip(lists.animated, animated, strict=True)
            if self._is_animated_now(row, obj, paths)
        }
        if lists is not self._lists:  # everything has just been read
            rows.clear()
        is_moved = self._move(lists, raw, exact, rows)
        reshaped = self._read_edited(lists, raw, exact, rows, evaluated, depsgraph)
        self._tagged |= reshaped
        changed = switched = False
        reread = sorted(rows)
        stretches = np.zeros((0, 6))
        if reread:
            found = rigid_transforms(raw[lists.rows.searchsorted(reread)])[1]
            stretches = self._stretches(reread, found)
        for row, obj, stretch in zip(
            reread, _objects_in(reread, evaluated), stretches, strict=True
        ):
            known = self._tagged[row]
            tagged = self._read_object(row, obj, depsgraph, stretch)
            if tagged == known:
                continue
            self._tagged[row] = tagged
            if tagged.animated != known.animated:
                self._animated.pop(row, None)  # the values were those of other properties
            if _is_same_but_shape(tagged, known):
                reshaped[row] = tagged
            else:
                switched |= (tagged.object is None) != (known.object is None)
                changed = True
        if switched and only is not None:
            self._session_ids = None
            return self._read_changed(scene, depsgraph, exact)
        if switched:  # sources and listeners may now be on another object, or on none
            for row, before in self._tagged.items():
                if row >= len(bpy.data.objects):
                    continue
                self._tagged[row] = self._read_object(
                    row, bpy.data.objects[row], depsgraph, np.array(before.stretch)
                )
        if changed:
            lists = TaggedLists.of(self._tagged, lists)  # of the same rows
        elif reshaped:
            lists = lists.reshaped(reshaped)
        if is_moved or lists is not self._lists:
            self._transforms = self._rigid.take(lists.of_bodies, axis=0)
            if lists is not self._lists:
                self._anchors = lists.anchors()
            turns = self._rigid[lists.rows.searchsorted(lists.of_places), :3]
            places = (turns[..., :3] @ self._anchors[..., None])[..., 0] + turns[..., 3]
            self._placed = [
                item.moved(place) for place, item in zip(places.tolist(), lists.places, strict=True)
            ]
        self._lists = lists
        self._unchecked, self._postponed = self._postponed, set()
        self._authored.clear()
        self._alike.clear()
        return lists

    def _by_row(self, objects: Mapping[int, Object]) -> dict[int, Object]:
        """The tagged ones of some objects, which are by session id."""
        return {self._rows[number]: obj for number, obj in objects.items() if number in self._rows}

    def _move(
        self, lists: TaggedLists, raw: NDArray[np.float32], exact: bool, rows: set[int]
    ) -> bool:
        """Take over the matrices that have changed.

        Args:
            lists: of the tagged objects.
            raw: their world matrices (m, 16).
            exact: as of `read`.
            rows: to be read again, to which those of another stretch are added.

        Returns:
            Whether any has changed.
        """
        if exact or lists is not self._lists:
            moved = np.arange(len(lists.rows))
        else:
            # Keep the old matrix while a simulation at rest trembles.
            moved = _moved(raw, self._raw, lists.still)
        if len(moved) == 0:
            return False
        if len(moved) == len(lists.rows):
            self._raw = raw
            self._rigid, stretches = rigid_transforms(raw)
        else:
            self._raw[moved] = raw[moved]
            self._rigid = self._rigid.copy()  # the old array belongs to the last reading
            self._rigid[moved], stretches = rigid_transforms(raw[moved])
        self._parented.correct(self._rigid, exact)
        known = lists.stretches[moved]
        rows |= set(lists.rows[moved[_differ(stretches, known)]].tolist())
        return True

    def _read_edited(
        self,
        lists: TaggedLists,
        raw: NDArray[np.float32],
        exact: bool,
        rows: set[int],
        evaluated: Mapping[int, Object],
        depsgraph: Depsgraph,
    ) -> dict[int, Tagged]:
        """The objects, by row, of which nothing but the mesh has changed.

        Args:
            lists: of the tagged objects.
            raw: their world matrices (m, 16).
            exact: as of `read`.
            rows: to be read again, to which those with other changes are added.
            evaluated: objects by row, as far as known.
            depsgraph: with the evaluated scene.
        """
        reshaped: dict[int, Tagged] = {}
        if lists is not self._lists:
            return reshaped
        unchecked = self._unchecked | self._bone_parts.keys() if exact else self._unchecked
        rows |= {self._rows[number] for number in self._authored & self._rows.keys()}
        edited = sorted({self._rows[number] for number in unchecked & self._rows.keys()} - rows)
        numbers = lists.rows.searchsorted(edited)
        moved = (raw[numbers] != self._raw[numbers]).any(axis=1).tolist()
        objects = _objects_in(edited, evaluated)
        for row, obj, is_moved in zip(edited, objects, moved, strict=True):
            tagged = None if is_moved else self._reshaped(row, obj, depsgraph)
            if tagged is None:
                rows.add(row)
            elif tagged is not self._tagged[row]:
                reshaped[row] = tagged
        return reshaped

    def _reshaped(self, row: int, obj: Object, depsgraph: Depsgraph) -> Tagged | None:
        """The object ``obj`` of a row, of which nothing but the mesh has changed; None if it must
        be read again, as after an edit of its rigid body or of its drivers, which Blender names as
        one of its geometry."""
        known = self._tagged[row]
        if (
            known.object is None
            or not has_body_of(obj, known.object, depsgraph.scene)
            or compatibility.animated_paths(obj) != known.animated
        ):
            return None
        try:
            surface = self._shape(obj, depsgraph, np.array(known.stretch))
        except ValueError:
            return None
        if surface is known.surface:
            return known
        return replace(known, body=Body.of(known.object, surface.shape), surface=surface)

    def _read_object(
        self, row: int, obj: Object, depsgraph: Depsgraph, stretch: FloatArray
    ) -> Tagged:
        """The roles of an object as values of the core, and the problems that prevent any."""
        (animated_now,) = evaluated_in([obj], depsgraph)
        haptics = animated_now.haptics
        name = obj.name_full
        problems: list[Problem] = []
        haptic_object = body = surface = source = listener = None
        animated = compatibility.animated_paths(obj)
        if np.isnan(stretch).any():
            nothing = (None,) * 5
            return Tagged(row, animated, tuple(stretch.tolist()), *nothing, (_lost(obj),))
        if haptics.enabled:
            try:
                surface = self._shape(obj, depsgraph, stretch)
                haptic_object = read_object(animated_now, depsgraph.scene)
                body = Body.of(haptic_object, surface.shape)
            except ValueError as error:
                if obj.session_uid not in self._instances.instancers:
                    problems.append(Problem(name, str(error)))
                elif haptics.source.enabled or haptics.listener.enabled:
                    problems.append(_only_instances(obj))
        carrier = haptic_carrier(obj)
        if carrier is not None and carrier.session_uid not in self._rows:
            # An armature keeps its body when that is deleted.
            carrier = carrier if carrier.users_collection else None
        for role in ("source", "listener"):
            if not getattr(haptics, role).enabled or (carrier == obj and haptic_object is None):
                continue  # the object's own problem reports it
            if carrier is None:
                problems.append(_without_carrier(obj, role))
                continue
            try:
                silenced = is_silenced(animated_now, role, self.solo_roles)
                if role == "listener":
                    listener = read_listener(animated_now, carrier.name_full, silenced)
                else:
                    triggers, wrong = read_triggers(obj, depsgraph.scene)
                    problems += wrong
                    frequency = self._curves.of_source(obj, depsgraph.scene)
                    source = replace(
                        read_source(animated_now, carrier.name_full, frequency, silenced),
                        triggers=triggers,
                    )
            except (OSError, ValueError) as error:
                rule = ("signal", 0) if role == "source" else None
                problems.append(
                    Problem(
                        name, str(error).replace("mixing_expression", "the mixing formula"), rule
                    )
                )
        return Tagged(
            row,
            animated,
            tuple(stretch.tolist()),
            haptic_object,
            body,
            surface,
            source,
            listener,
            tuple(problems),
        )

    def _is_animated_now(self, row: int, obj: Object, paths: tuple[str, ...] | None) -> bool:
        """Whether animation has changed any property of the object of a row since the last
        call."""
        if paths is None:
            return True
        values = _values_at(obj, paths)
        before = self._animated.get(row)
        self._animated[row] = values
        return values != before

    def _stretches(self, rows: list[int], found: FloatArray) -> FloatArray:
        """The stretches ``found`` (n, 6) of objects in the world, by row, to six digits; the known
        ones where only rounding differs, so that a rotating object keeps its shape."""
        rounded = _rounded(found)
        known = np.array(
            [
                self._tagged[row].stretch if row in self._tagged else own
                for row, own in zip(rows, rounded, strict=True)
            ]
        ).reshape(-1, 6)
        return np.where(_differ(rounded, known)[:, None], rounded, known)

    def _shape(self, obj: Object, depsgraph: Depsgraph, stretch: FloatArray) -> SurfaceShape:
        """The collision shape of an object with its world ``stretch`` (6,): the known one
        unless its settings or its mesh have changed."""
        if obj.haptics.surface == "SEEN" and obj.rigid_body is None:
            armature = armature_of(obj)
            shape = armature and self._bone_shape(obj, armature, depsgraph, stretch)
            if shape:
                return shape
        margin = distance_of_cloth(obj, depsgraph.scene)
        key = tuple(stretch.tolist()), shape_settings(obj, depsgraph.scene), margin
        session_id = obj.session_uid
        # None is left of a mesh that has no shape any more.
        known = self._shapes.pop(session_id, None)
        is_known = known is not None and known[0] == key
        is_unchecked = session_id in self._unchecked and not (is_known and hides_multires(obj))
        alike = None
        if is_unchecked or not is_known:
            alike = mesh_number(obj, depsgraph), key
            found = self._alike.get(alike)
            if found is not None:
                if known is None or not is_known or known[1] != found[1]:
                    known = found
                self._shapes[session_id] = known
                return known[2]
        started = perf_counter()
        content = mesh_checksum(obj, depsgraph) if is_unchecked or not is_known else None
        if known is None or not is_known or (is_unchecked and known[1] != content):
            known = key, content, collision_shape(obj, depsgraph, stretch, margin)
            if is_unchecked and self._lists is not None:
                milliseconds = 1000 * (perf_counter() - started)
                self._rebuilt = {**self._rebuilt, obj.name_full: milliseconds}
        self._shapes[session_id] = known
        if alike is not None and alike[0]:
            self._alike[alike] = known
        return known[2]

    def _bone_shape(
        self, obj: Object, armature: Object, depsgraph: Depsgraph, stretch: FloatArray
    ) -> SurfaceShape | None:
        """The shape of a mesh that bones deform; None if they move none of it. The deviation is
        measured where everything is read, not from frame to frame."""
        key = tuple(stretch.tolist()), rest_checksum(obj, armature)
        known = self._bone_parts.get(obj.session_uid)
        is_edited = obj.data is not None and obj.data.session_uid in self._unchecked
        if is_edited and obj.session_uid in self._authored and self._lists is not None:
            # After an edit of a property Blender names the mesh, too. To read all weights takes
            # long: the next reading does it that follows anything else.
            self._postponed |= {obj.session_uid, obj.data.session_uid}
            is_edited = False
        if known is None or known[0] != key or is_edited:
            known = key, parts_at_rest(obj, armature, stretch), np.zeros(()), None
        parts, motions, shape = known[1:]
        if parts is not None:
            now = parts.motions(obj, armature, depsgraph)
            moved = np.abs(now - motions).max()
            if shape is None or moved > (0.0 if self._exact else STILL):
                motions = now
                shape = SurfaceShape(parts.posed(now), 0.0 if shape is None else shape.deviation)
            if self._lists is None:
                shape = replace(shape, deviation=parts.deviation(motions, obj, depsgraph, stretch))
        self._bone_parts[obj.session_uid] = key, parts, motions, shape
        return shape


def _objects_in(rows: Collection[int], evaluated: Mapping[int, Object]) -> list[Object]:
    """The objects in some rows, of which some have just been ``evaluated``. Blender looks for one
    by its number among all that come before."""
    every: Any = bpy.data.objects if len(rows) <= _FEW else tuple(bpy.data.objects)
    return [evaluated.get(row) or every[row] for row in rows]


def _moved(raw: NDArray[np.float32], before: NDArray[np.float32], limits: FloatArray) -> IntArray:
    """Numbers (k,) of the matrices (n, 16) that differ from those ``before`` by more than
    ``limits`` (n, 16)."""
    others = np.flatnonzero((raw != before).any(axis=1))
    beyond = ~(np.abs(raw[others] - before[others]) <= limits[others]).all(axis=1)
    return others[beyond]


def _tagged_above(obj: Object, tagged: Container[int]) -> Object | None:
    """The nearest ancestor of an object whose session id is in ``tagged``; without one, its topmost
    ancestor."""
    above = obj.parent
    while above is not None and above.session_uid not in tagged and above.parent is not None:
        above = above.parent
    return above


def _rounded(stretches: FloatArray) -> FloatArray:
    """Stretches (n, 6) to six digits."""
    digits = [float(f"{part:.6g}") for part in stretches.reshape(-1).tolist()]
    return np.array(digits).reshape(-1, 6)


def _differ(stretches: FloatArray, known: FloatArray) -> BoolArray:
    """Whether stretches (n, 6) differ from those ``known`` (n, 6) by more than rounding, or are no
    numbers, (n,)."""
    limits = 1e-5 * np.abs(known)
    limits[:, 3:] = limits[:, :3].max(axis=1, keepdims=True)
    return np.asarray(~np.all(np.abs(stretches - known) <= limits, axis=1))


def _is_same_but_shape(tagged: Tagged, known: Tagged) -> bool:
    """Whether nothing but the shape of a haptic object differs from what was ``known`` of it."""
    if tagged.body is None or known.body is None:
        return False
    # Of an object, a body differs by its shape alone.
    return replace(tagged, body=known.body, surface=known.surface) == known


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


def _lost(obj: Object) -> Problem:
    """The problem of an object whose world matrix is not finite."""
    words = iface_(
        "its location, rotation or scale is not a number: look for a constraint, simulation or "
        "script that fails"
    )
    return Problem(obj.name_full, words)


def _only_instances(obj: Object) -> Problem:
    """The problem of a source or listener whose only surface is that of its instances."""
    words = iface_(
        "it has no surface but its instances, which are no sources or listeners: use Realize "
        "Instances"
    )
    return Problem(obj.name_full, words)


def _without_carrier(obj: Object, role: str) -> Problem:
    """The problem of a source or listener without a haptic object that carries it; the same one for
    all on one armature, so that it is shown once."""
    above: Object | None = obj
    while above is not None and above.type != "ARMATURE":
        above = above.parent
    if above is not None:
        words = iface_(
            "its listeners and sources are on no haptic object: choose its Body in the panel "
            "Selected Object, and make that haptic"
        )
        return Problem(above.name_full, words)
    if role == "source":
        return Problem(
            obj.name_full,
            iface_(
                "This source is on no haptic object: make it haptic, or parent it to a haptic "
                "object"
            ),
        )
    return Problem(
        obj.name_full,
        iface_(
            "This listener is on no haptic object: make it haptic, or parent it to a haptic object"
        ),
    )


def _instance_problems(depsgraph: Depsgraph) -> Iterator[Problem]:
    """The problems of collection instances with sources or listeners, which are ignored."""
    for instancer, shown in instanced_collections(depsgraph):
        if any(obj.haptics.source.enabled or obj.haptics.listener.enabled for obj in shown):
            words = iface_(
                "the sources and listeners of its collection don't count here: press Realize "
                "Instances"
            )
            yield Problem(instancer.name_full, words)
