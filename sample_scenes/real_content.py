"""What samples and benchmarks of imported content share: skinned characters, arms of robots, bowls,
instances of collections, and the roles that *Make Haptic*, *Match Materials* and *Add Body
Listeners* give."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import bpy
from bpy.types import Armature, Collection, Material, Object, Scene
from mathutils import Vector

from ..addon.authoring import body_kit, signals
from ..addon.authoring import materials as library
from ..core.scene.body import BODY_PART, DEFAULT_LISTENERS
from ..core.scene.materials import MATERIALS
from .avatar import SIDES, Mannequin, Posture, trunk_frame
from .gait import PREFIX
from .geometry import Point, joined, lathe, to_mesh
from .materials import surface
from .staging import make_source, place_empty, place_mesh

_TRUNK = {"Hips": 0.0, "Spine": 0.09, "Spine1": 0.186, "Spine2": 0.28, "Neck": 0.57, "Head": 0.63}
"""Where the bones of the trunk begin [m], upwards from the centre of the hips."""
_CROWN = 0.86
_WORDS = {"L": "Left", "R": "Right"}
_LIMBS = {
    "Upper Arm": ("Arm", "Spine2", "shoulder"),
    "Forearm": ("ForeArm", "Arm", "elbow"),
    "Hand": ("Hand", "ForeArm", "wrist"),
    "Upper Leg": ("UpLeg", "Hips", "hip"),
    "Lower Leg": ("Leg", "UpLeg", "knee"),
    "Foot": ("Foot", "Leg", "ankle"),
}
"""Parts of the mannequin: their bone, the bone before it, the joint where it begins."""

BOWL = (0.05, 0.0), (0.11, 0.06), (0.1, 0.06), (0.04, 0.01)
"""The profile of a bowl: radii and heights of its outside upwards and its inside downwards [m]."""
BOWL_STEP = 0.02
"""How much higher a bowl stands in another [m]."""

Bones = dict[str, tuple[str, Vector, Vector]]
"""By name: the bone before it, head and tail."""


def add_character(
    scene: Scene,
    name: str,
    posture: Posture,
    location: Point = (0.0, 0.0, 0.0),
    parent: Object | None = None,
    heading: float = 0.0,
) -> tuple[Object, Object]:
    """A mannequin as rigs have it: one mesh, skinned to an armature with Mixamo's names of bones,
    at rest in ``posture``, turned by ``heading`` about z. Returns the armature and the mesh."""
    mannequin = Mannequin.of(posture)
    data: Armature = bpy.data.armatures.new(f"{name} Rig")
    armature = bpy.data.objects.new(data.name, data)
    scene.collection.objects.link(armature)
    armature.location, armature.parent = location, parent
    armature.rotation_euler = (0.0, 0.0, heading)
    _add_bones(scene, armature, _bones(mannequin, posture))
    skins = (surface(f"{name} Skin", "#e9e2d6", 0.45), surface(f"{name} Joints", "#2f5d73", 0.4))
    shape = joined(mannequin.shapes.values())
    body = place_mesh(scene, name, to_mesh(name, shape, skins), (0.0, 0.0, 0.0), parent=armature)
    for bone, vertices in _weights(mannequin):
        group = body.vertex_groups.get(bone) or body.vertex_groups.new(name=bone)
        group.add(vertices, 1.0, "REPLACE")
    skin: Any = body.modifiers.new("Armature", "ARMATURE")
    skin.object = armature
    return armature, body


def _bones(mannequin: Mannequin, posture: Posture) -> Bones:
    """The skeleton inside a mannequin."""
    names, point = list(_TRUNK), trunk_frame(posture)
    ends = [*list(_TRUNK.values())[1:], _CROWN]
    bones: Bones = {
        bone: (before, point(0.0, 0.0, low), point(0.0, 0.0, high))
        for bone, before, low, high in zip(names, ["", *names], _TRUNK.values(), ends, strict=False)
    }
    for _, letter in SIDES:
        places = [mannequin.joints[f"{joint}.{letter}"] for _, _, joint in _LIMBS.values()]
        ends_of_limbs = {
            "Hand": 2 * mannequin.anchors[f"hand.{letter}"][1]
            - mannequin.joints[f"wrist.{letter}"],
            "Foot": mannequin.anchors[f"foot.{letter}"][1],
        }
        for (bone, before, _), head, after in zip(
            _LIMBS.values(), places, [*places[1:], places[-1]], strict=True
        ):
            carrier = before if before in _TRUNK else _WORDS[letter] + before
            bones[_WORDS[letter] + bone] = carrier, head, ends_of_limbs.get(bone, after)
    return bones


def _add_bones(scene: Scene, armature: Object, bones: Bones) -> None:
    """Their z axes look forward, so that legs swing about x."""
    layer = scene.view_layers[0]
    with bpy.context.temp_override(
        scene=scene, view_layer=layer, object=armature, active_object=armature
    ):
        layer.objects.active = armature
        bpy.ops.object.mode_set(mode="EDIT")
        for name, (before, head, tail) in bones.items():
            bone = armature.data.edit_bones.new(PREFIX + name)
            bone.head, bone.tail = head, tail
            bone.align_roll((0.0, -1.0, 0.0))
            bone.parent = armature.data.edit_bones.get(PREFIX + before)
        bpy.ops.object.mode_set(mode="OBJECT")


def _weights(mannequin: Mannequin) -> Iterator[tuple[str, list[int]]]:
    """The vertices that each bone moves; the belly bends in its middle."""
    first = 0
    for part, shape in mannequin.shapes.items():
        numbers = range(first, first + len(shape.vertices))
        first = numbers.stop
        limb, _, letter = part.partition(".")
        if part == "Belly":
            middle = shape.centre().z
            upper = [vertex[2] > middle for vertex in shape.vertices]
            for bone, is_upper in (("Spine", False), ("Spine1", True)):
                chosen = [k for k, above in zip(numbers, upper, strict=True) if above == is_upper]
                yield PREFIX + bone, chosen
        else:
            bone = {"Chest": "Spine2"}.get(part, part)
            yield PREFIX + (_WORDS[letter] + _LIMBS[limb][0] if letter else bone), list(numbers)


def add_arm(
    scene: Scene,
    name: str,
    lengths: Sequence[float],
    location: Point,
    materials: Sequence[Material],
) -> list[Object]:
    """The links of a robot's arm, one on the other, upright at rest: concave meshes with their
    origins at the joints, as files for simulators have them."""
    links: list[Object] = []
    for number, length in enumerate(lengths):
        thin, thick = (length - 0.05, length - 0.03)
        shape = lathe(
            ((0.09, 0.0), (0.09, 0.03), (0.05, 0.05), (0.05, thin), (0.09, thick), (0.09, length)),
            32,
        )
        mesh = to_mesh(f"{name}_link{number}", shape, materials)
        place_at = (0.0, 0.0, lengths[number - 1]) if links else location
        parent = links[-1] if links else None
        links.append(place_mesh(scene, mesh.name, mesh, place_at, parent=parent))
    return links


def add_instance(
    scene: Scene, collection: Collection, name: str, location: Point, heading: float = 0.0
) -> Object:
    """An instance of a collection, as assets and blocks are imported."""
    obj = place_empty(scene, name, location, heading=heading)
    obj.instance_type, obj.instance_collection = "COLLECTION", collection
    return obj


def to_collection(name: str, objects: Iterable[Object]) -> Collection:
    """Move objects out of the scene into a collection that only instances show."""
    collection = bpy.data.collections.new(name)
    for obj in objects:
        for other in obj.users_collection:
            other.objects.unlink(obj)
        collection.objects.link(obj)
    return collection


def make_haptic(scene: Scene, objects: Iterable[Object], told: Mapping[str, str]) -> None:
    """What *Make Haptic* and *Match Materials* do; ``told``: what the user answers there, the
    preset of a Blender material or of an object without one by its name."""
    chosen = list(objects)
    with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
        library.list_names(scene, chosen)
        for row in scene.haptics.materials.names:
            # Without the number that Blender adds.
            row.preset = told.get(row.name.partition(".")[0], row.preset)
        library.make_haptic(scene, library.guesses(chosen))
    for obj in chosen:
        obj.haptics.surface = "SEEN"


def add_listeners(scene: Scene, armature: Object, body: Object) -> None:
    """What *Add Body Listeners* does: the twelve listeners on the bones, a body of flesh."""
    layer = scene.view_layers[0]
    with bpy.context.temp_override(scene=scene, view_layer=layer):
        layer.update()
        wanted = [BODY_PART[name] for name in DEFAULT_LISTENERS]
        missing = body_kit.place_on_bones(armature, wanted, scene.collection)
        assert not missing
        library.make_haptic(scene, {body: library.guesses([body])[body] or MATERIALS["flesh"]})
    body.haptics.surface = "SEEN"
    armature.haptics.body = body


def add_source(obj: Object) -> Object:
    """What *Add Source* does: the signal that the name tells."""
    told = signals.signal_for(obj.name)
    return make_source(obj, told.signal, told.frequency, told.amplitude)
