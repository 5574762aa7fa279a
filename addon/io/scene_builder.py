"""A haptic scene as objects of Blender."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.types import Collection, Object

from ...core.contacts.shape_surface import surface
from ...core.contacts.shapes import Box, Shape
from ...core.formats.export import Export
from ...core.formats.scene.recording import pair_of, without_rubbing
from ...core.formats.scene.values_json import item_to_dict
from ...core.forms import Form
from ...core.scene.functions import Identity, ModulationFunction
from ...core.scene.values import Contact, HapticObject, Listener, Pose, Source, Vector
from ..blender.single_precision import shortest
from ..blender.units import metres_per_unit
from ..properties.actuators import MUTED as ACTUATORS_MUTED
from ..properties.declared import write_values
from ..properties.materials import add_material, own_values
from ..scene_reader.functions import read_transmission
from ..scene_reader.imported import file_contacts, near, text_of, text_of_contacts
from ..scene_reader.objects import read_object
from .devices import take_devices
from .frame_scene import EXTRAS, MUTED
from .keyframes import local_place, write_keyframes
from .materials import take_materials
from .property_writer import (
    stored_text,
    write_body,
    write_listener,
    write_source,
    write_tables,
)

SMALLEST = 0.1
"""Least extent of an object without a shape in the file [m]."""
AXES = 0.1
LONGEST_NAME = 63


def build(export: Export, scene: bpy.types.Scene, settings: bool = True) -> list[str]:
    """Create the objects of an export in a collection with its name; ``settings``: also apply its
    settings and times to the scene, whose current frame stays.

    Returns sentences about losses.

    """
    builder = _Builder(export, scene)
    frame = scene.frame_current
    try:
        builder.add_materials()
        builder.add_objects()
        for source in builder.haptic.sources:
            builder.add_source(source)
        for listener in builder.haptic.listeners:
            builder.add_listener(listener)
        builder.add_devices()
        if settings:
            builder.take_settings()
        builder.keep_contacts()
        builder.add_frames()
    except BaseException:
        builder.remove()
        raise
    finally:
        scene.frame_set(frame)
    return builder.losses()


class _Builder:
    """One import."""

    def __init__(self, export: Export, scene: bpy.types.Scene) -> None:
        haptic, recording = without_rubbing(export.need_scene(), export.recording)
        self.export = replace(export, scene=haptic, recording=recording)
        self.scene = scene
        self.haptic = haptic if recording is None else recording.with_all(haptic)
        self.collection: Collection = bpy.data.collections.new(export.name)
        scene.collection.children.link(self.collection)
        self.objects: dict[str, Object] = {}
        self.poses = {item.name: item.pose or Pose() for item in self.haptic.objects}
        self.attached: dict[str, Object] = {}
        self.lost: dict[str, list[str]] = {}

    def remove(self) -> None:
        """Remove everything that was created."""
        bpy.data.batch_remove([*self.collection.objects, self.collection])

    def lose(self, what: str, name: str) -> None:
        """Record a loss of the item ``name``."""
        self.lost.setdefault(what, []).append(name)

    def losses(self) -> list[str]:
        """Sentences about all losses."""
        if self.export.tracks is not None:
            self.lose("rendered tracks, which are rendered again", "tracks")
        return [f"{what}: {_listed(names)}" for what, names in self.lost.items()]

    def add_materials(self) -> None:
        """Add the library, which precedes the objects."""
        for name in take_materials(self.scene, self.export.materials):
            self.lose("material of that name is another one in this scene", name)

    def add_objects(self) -> None:
        metres = metres_per_unit(self.scene)
        for item in self.haptic.objects:
            shape = item.shape
            guessed = item.shape is None
            if guessed:
                shape, centre = self._guessed(item)
                self.poses[item.name] = replace(self.poses[item.name], position=centre)
                self.lose("no shape in the file, made a box", item.name)
            obj = self._new(item.name, _mesh(item.name, shape))
            self.objects[item.name] = obj
            pose = self.poses[item.name]
            obj.rotation_mode = "QUATERNION"
            obj.location, obj.rotation_quaternion = pose.position, pose.rotation
            obj.location /= metres
            obj.scale /= metres
            haptics = obj.haptics
            material = item.material
            if len(material) > LONGEST_NAME:
                self.lose("name of its material, which is too long here", item.name)
                material = ""
            if material in self.scene.haptics.materials.items:
                haptics.material.name = material  # and its values, which the object's own replace
            write_body(haptics, item)
            haptics.imported = stored_text(
                replace(item, shape=None if guessed else shape, pose=pose, material=""),
                motion=item.motion.value,
            )
            if material and material not in self.scene.haptics.materials.items:
                add_material(self.scene, material, own_values(obj))
                haptics.material.name = material
            if read_object(obj, self.scene).propagation != item.propagation:
                self.lose(f"function {item.propagation.name!r} as the file has it", item.name)

    def add_source(self, item: Source) -> None:
        """Make its object the source if that has its position and name, otherwise an empty on
        it."""
        obj = self._holder(item, "source")
        second = None if item.second_object is None else self.objects[item.second_object].name_full
        triggers = item.triggers and tuple(
            replace(t, object=self.objects[t.object].name_full) if t.object else t
            for t in item.triggers
        )
        write_source(obj.haptics.source, replace(item, second_object=second, triggers=triggers))

    def add_listener(self, item: Listener) -> None:
        """Add a listener, as `add_source` does."""
        obj = self._holder(item, "listener")
        extras = dict(item.extras)
        muted = extras.get(MUTED) is True
        if muted:
            del extras[MUTED]
        for loss in write_listener(obj.haptics.listener, replace(item, extras=extras)):
            self.lose(loss, item.name)
        if muted:
            obj.haptics.live_output.actuators = ACTUATORS_MUTED

    def add_devices(self) -> None:
        """Add the devices and the listeners' choices of actuators."""
        listeners = {
            item.name: self.attached[f"listener {item.name}"] for item in self.haptic.listeners
        }
        take_devices(self.scene, self.export.devices, listeners)

    def take_settings(self) -> None:
        """Apply the settings, the scene properties in the extras, and the frame of the file."""
        haptics, settings = self.scene.haptics, self.haptic.settings
        write_values(haptics, settings)
        extras = dict(self.haptic.extras)
        known = extras.get(EXTRAS)
        if isinstance(known, dict):
            del extras[EXTRAS]
            self._take_time(known)
        self._take_rules()
        rules = {
            key: value
            for key, value in item_to_dict(self.haptic.rules).items()
            if not isinstance(value, list) or key in ("gravity", "passing")
        }
        haptics.imported = text_of(settings=item_to_dict(settings), rules=rules, extras=extras)

    def _take_rules(self) -> None:
        """Apply the rules of contacts and impacts."""
        scene, haptics, rules = self.scene, self.scene.haptics, self.haptic.rules
        write_values(haptics, rules)
        write_tables(haptics, rules)
        for row, rule in zip(
            haptics.transmission_table.items, rules.transmission_table.rows, strict=True
        ):
            if read_transmission(row)[0] != rule.value:
                self.lose("what its function does beside what the panel has", str(rule.value.name))
        scene.use_gravity = any(rules.gravity)
        if scene.use_gravity:
            scene.gravity = [value / metres_per_unit(scene) for value in rules.gravity]
        if (
            scene.rigidbody_world is not None
            and rules.time_scale != scene.rigidbody_world.time_scale
        ):
            self.lose("time scale, which a rigid body world has here", f"{rules.time_scale:g}")

    def _take_time(self, known: Form) -> None:
        rate, start = (known.get(key) for key in ("frame_rate", "frame_start"))
        if isinstance(rate, int | float) and 1 <= rate <= 10_000:
            set_frame_rate(self.scene, float(rate))
        if isinstance(start, int):
            self.scene.frame_start = start

    def keep_contacts(self) -> None:
        """Store the contacts of the file in addition to those of earlier imports; they replace
        those of objects that are imported again."""
        frames = self.export.recording.frames if self.export.recording is not None else ()
        begun = [item for frame in frames for item in frame.contacts]
        later: dict[tuple[str, str], Contact] = {}
        for item in begun:
            later.setdefault(pair_of(item), item)
        functions: dict[tuple[str, str], set[ModulationFunction]] = {}
        for item in (*self.haptic.contacts, *begun):
            functions.setdefault(pair_of(item), set()).add(item.transmission)
        for pair in {pair_of(item) for item in begun}:
            if len(functions[pair]) > 1:
                self.lose("functions of contacts that change over time", " and ".join(pair))
        haptics = self.scene.haptics
        names = {obj.name_full for obj in self.objects.values()}
        try:
            before = file_contacts(haptics.imported_contacts).contacts
        except ValueError:  # damaged: it must be imported again
            before = {}
        old = [
            item
            for pair, items in before.items()
            if not names.intersection(pair) and all(name in bpy.data.objects for name in pair)
            for item in items
        ]
        haptics.imported_contacts = text_of_contacts(
            [*old, *map(self._renamed, self.haptic.contacts)],
            [self._renamed(item) for item in later.values() if item.transmission != Identity()],
            shortest(haptics.contact_tolerance),
        )

    def _renamed(self, item: Contact) -> Contact:
        """A contact with the names that its objects have in Blender."""
        first, second = (self.objects[name].name_full for name in item.objects)
        return replace(item, objects=(first, second))

    def add_frames(self) -> None:
        """Add keyframes, and the sources that begin later. Impacts come from the file and are not
        searched for."""
        recording = self.export.recording
        if recording is None:
            return
        begun = [source for frame in recording.frames for source in frame.sources]
        for source in begun:
            if f"source {source.name}" not in self.attached:
                self.add_source(source)
        if any(source.second_object is not None for source in (*self.haptic.sources, *begun)):
            self.scene.haptics.impacts = False
        set_frame_rate(self.scene, recording.frame_rate)
        last = recording.frames[-1].number
        self.scene.frame_start, self.scene.frame_end = (
            recording.frame_start,
            max(last, recording.frame_start),
        )
        if self.scene.frame_start != recording.frame_start:
            self.lose("negative frames, Blender plays from 0", f"{recording.frame_start} to {last}")
        first_scene = self.export.need_scene()
        moved = replace(
            first_scene,
            objects=tuple(
                replace(item, pose=self.poses[item.name]) for item in first_scene.objects
            ),
        )
        for loss in write_keyframes(moved, recording, self.objects, self.attached):
            self.lose("not carried over", loss)

    def _new(self, name: str, data: Any) -> Object:
        obj = bpy.data.objects.new(name, data)
        self.collection.objects.link(obj)
        if obj.name_full != name:
            self.lose("renamed", f"{name} to {obj.name_full}")
        return obj

    def _holder(self, item: Source | Listener, role: str) -> Object:
        """The object for a source or listener."""
        carrier = self.objects[item.object]
        pose = self.poses[item.object]
        place = local_place(item.position, pose)
        others = [
            other
            for other in (
                self.attached.get(f"{kind} {item.name}") for kind in ("source", "listener")
            )
            if other is not None
        ]
        there = [
            other
            for other in others
            if other.parent is carrier and math.dist(other.location, place) < 1e-5
        ]
        if item.name == item.object and near(pose.position, item.position):
            obj = carrier
        elif there:
            obj = there[0]
        else:
            obj = self._new(item.name, None)
            obj.empty_display_size = AXES
            obj.parent = carrier
            obj.location = place
        self.attached[f"{role} {item.name}"] = obj
        return obj

    def _guessed(self, item: HapticObject) -> tuple[Shape, Vector]:
        """A box around all positions on an object, and its centre in the world."""
        known = [
            position
            for contact in self.haptic.contacts
            for name, position in zip(contact.objects, contact.positions, strict=True)
            if name == item.name
        ]
        known += [source.position for source in self.haptic.sources if source.object == item.name]
        known += [
            listener.position for listener in self.haptic.listeners if listener.object == item.name
        ]
        points = np.array(known or [self.poses[item.name].position])
        low = points.min(axis=0)
        high = points.max(axis=0)
        x, y, z = np.maximum(high - low, SMALLEST).tolist()
        cx, cy, cz = ((low + high) / 2).tolist()
        return Box((x, y, z)), (cx, cy, cz)


def set_frame_rate(scene: bpy.types.Scene, rate: float) -> None:
    """Set the frames per second, as an integer divided by a base."""
    whole = max(math.ceil(rate - 1e-6), 1)
    scene.render.fps = whole
    scene.render.fps_base = 1.0 if abs(whole - rate) < 1e-6 else whole / rate


def _mesh(name: str, shape: Shape) -> bpy.types.Mesh:
    points, faces = surface(shape)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.validate()
    return mesh


def _listed(names: Iterable[str]) -> str:
    names = list(names)
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
