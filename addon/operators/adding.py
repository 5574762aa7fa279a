"""Operators that add sources, a medium or a sample scene."""

from __future__ import annotations

import time

import bpy
from bpy.types import Context, Object, Scene
from mathutils import Matrix, Vector

from ...core.scene.materials import MATERIALS
from ...sample_scenes import SAMPLES, build_sample, geometry
from ..authoring import materials
from ..blender.compatibility import is_animated
from ..blender.polling import Edit, OnActive, receiving
from ..blender.units import metres_per_unit
from ..properties.kinds import choice
from ..scene_reader import triggers
from ..scene_reader.roles import haptic_carrier
from .tagging import make_source

_SOURCES = (
    ("PULSE", "Jackhammer", "Regular blows", 25.0, "MOD_TIME"),
    ("SINE", "Shaker", "A pure vibration", 60.0, "FORCE_HARMONIC"),
    ("NOISE", "Rumble", "A rough, random vibration", 60.0, "FORCE_TURBULENCE"),
)
SOURCE_ITEMS = tuple(
    (kind, title, description, icon, number)
    for number, (kind, title, description, _, icon) in enumerate(_SOURCES)
)
SAMPLE_ITEMS = tuple((sample.name, sample.title, sample.description) for sample in SAMPLES.values())


class HAPTIC_OT_add_source_object(Edit):
    """Add a haptic source at the 3D cursor: an empty on the active object if that is haptic, otherwise a small body"""

    bl_label = "Add Haptic Source"

    kind: choice("Signal", "What the source emits", SOURCE_ITEMS)

    def apply(self, context: Context) -> None:
        _, title, _, frequency, _ = next(source for source in _SOURCES if source[0] == self.kind)
        carrier = (
            haptic_carrier(context.object)
            if context.object is not None and context.object.select_get()
            else None
        )
        place = Matrix.Translation(context.scene.cursor.location)
        place @= Matrix.Scale(1 / metres_per_unit(context.scene), 4)
        if carrier is not None:
            obj = bpy.data.objects.new(title, None)
            obj.empty_display_type, obj.empty_display_size = "SPHERE", 0.1
        else:
            standing = geometry.cylinder(0.05, 0.2, 16).moved(z=0.1)
            obj = bpy.data.objects.new(title, geometry.to_mesh(title, standing, ()))
        _link(context, obj)
        if carrier is not None:
            obj.parent = carrier
            obj.matrix_parent_inverse = carrier.matrix_world.inverted_safe()
        else:
            materials.make_haptic(context.scene, {obj: MATERIALS["steel"]})
        obj.matrix_basis = place
        make_source(obj, self.kind)
        obj.haptics.source.frequency = frequency


def _link(context: Context, obj: Object) -> None:
    """Link an object to the active collection, and make it the active and only selected object."""
    receiving(context.collection).objects.link(obj)
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


class HAPTIC_OT_make_one_shot(OnActive):
    """Play a blast once per trigger, now if Trigger is not animated yet; in a medium it spreads as a pressure front"""

    bl_label = "Play Once"

    kind: choice(
        "Blast",
        "Which blast the source plays",
        (
            (
                "EXPLOSION",
                "Explosion",
                "An overpressure of 5 milliseconds, as that of a kilogram of TNT ten metres away",
            ),
            ("GUN", "Gun", "An overpressure of a millisecond, as at the muzzle"),
        ),
    )

    def apply(self, context: Context) -> None:
        source = context.object.haptics.source
        source.enabled = source.one_shot = True
        source.signal = "BLAST"
        source.decay = 0.005 if self.kind == "EXPLOSION" else 0.001
        if not is_animated(context.object, {triggers.PATH}):
            source.trigger = 1.0
            context.object.keyframe_insert(triggers.PATH)
        carrier = haptic_carrier(context.object)
        if (
            carrier is not None
            and carrier.haptics.medium
            and (carrier.haptics.function != "physical" or carrier.haptics.loss_factor > 0)
        ):
            _spread_as_front(context.scene, carrier, 1.5 if self.kind == "EXPLOSION" else 0.3)


def _spread_as_front(scene: Scene, medium: Object, radius: float) -> None:
    """Make a medium transmit with spherical spreading from ``radius`` metres on, at the speed of
    sound."""
    haptics = medium.haptics
    materials.spread_all_around(haptics, radius)
    material = scene.haptics.materials.items.get(haptics.material.name)
    speed = haptics.wave_speed or MATERIALS["air"].wave_speed
    if material is None:
        haptics.wave_speed = speed
    else:
        material.wave_speed = material.wave_speed or speed


class HAPTIC_OT_add_medium(Edit):
    """Add a medium around the selected objects, or at the 3D cursor; it transmits vibration between all objects that it overlaps"""

    bl_label = "Add Medium"

    medium: choice(
        "Medium",
        "What fills the volume",
        (
            ("air", "Air", "Carries the blast of an explosion", "FORCE_WIND", 0),
            ("water", "Water", "Carries sound and shock", "MOD_FLUIDSIM", 1),
        ),
    )

    def apply(self, context: Context) -> None:
        material = MATERIALS[self.medium]
        corners = [
            obj.matrix_world @ Vector(corner)
            for obj in context.selected_objects
            if obj.type == "MESH"
            for corner in obj.bound_box
        ]
        metre = 1 / metres_per_unit(context.scene)
        cursor = context.scene.cursor.location
        corners = corners or [
            cursor + Vector((2, 2, 2)) * metre,
            cursor - Vector((2, 2, 2)) * metre,
        ]
        low = Vector(map(min, zip(*corners, strict=True)))
        high = Vector(map(max, zip(*corners, strict=True)))
        volume = geometry.box(tuple(high - low + Vector((0.5, 0.5, 0.5)) * metre))
        mesh = geometry.to_mesh(material.title, volume, ())
        obj = bpy.data.objects.new(material.title, mesh)
        _link(context, obj)
        obj.location = (low + high) / 2
        obj.display_type = "BOUNDS"
        obj.hide_render = True
        obj.haptics.medium = True
        materials.make_haptic(context.scene, {obj: material})


class HAPTIC_OT_add_sample(Edit):
    """Add a sample scene to this file as a new scene"""

    bl_label = "Add Sample Scene"
    bl_property = "sample"

    sample: choice("Sample", "The scene to build", SAMPLE_ITEMS)

    def apply(self, context: Context) -> None:
        started = time.perf_counter()
        scene = build_sample(self.sample)
        _frame(context, scene)
        self.tell(
            "{} built in {:.1f} seconds: press play. Your own scene is in the scene menu at the "
            "top right",
            scene.name,
            time.perf_counter() - started,
        )


def _frame(context: Context, scene: Scene) -> None:
    """Show the camera view of a scene in the window's 3D viewports."""
    for area in (
        context.window.screen.areas
        if context.window is not None and scene.camera is not None
        else ()
    ):
        if area.type == "VIEW_3D":
            view = area.spaces.active
            view.use_local_camera = False
            view.region_3d.view_perspective = "CAMERA"
