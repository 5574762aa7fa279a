"""Digests of a scene, to find changes since a bake or since the detection of impacts.

A digest is plain data: settings and frame rate, and for every relevant object one checksum per
aspect.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import ID, NodeTree, Object, PropertyGroup, Scene

from ...core.forms import Form, JsonObject
from ...core.regular_file import open_regular
from ..blender.arrays import read_array
from ..blender.compatibility import animated_paths, fcurves_in, fcurves_of, nla_strips
from ..blender.paths import local_path
from ..blender.time import stretching
from ..blender.units import metres_per_unit
from ..properties.drawing import AMPLITUDE, FREQUENCY
from .deformation import deformation_of, drives_others, influence_of
from .drawings import mapping_of, points_of
from .objects import read_layers
from .plain_values import PLAIN_TYPES, TRANSFORM, checksum, plain, values_of, writable
from .present import present_objects, traced_layer
from .roles import is_tagged
from .triggers import marker_frames

Digest = JsonObject

_MOST_CHANGES = 6
_WHOLES = (
    ("frame rate", "frame rate"),
    ("gravity", "gravity"),
    ("world", "physics"),
    ("start", "start"),
    ("rules", "rules"),
    ("influences", "influences"),
)
_ASPECTS = ("haptics", "pose", "shape", "animation", "physics", "relations", "deformation")
TEXTS = {
    "setting": "{} was {}, is {}",
    "frame rate": "the frame rate changed",
    "gravity": "gravity changed",
    "world": "the rigid body world changed",
    "start": "the scene's first frame changed",
    "rules": "rules of contacts, impacts or textures, or the animation of settings changed",
    "added": "'{}' was added",
    "removed": "'{}' was removed",
    "haptics": "'{}': its haptic settings changed",
    "pose": "'{}': it was moved, turned or scaled",
    "shape": "'{}': its shape changed",
    "animation": "'{}': its animation changed",
    "physics": "'{}': its rigid body changed",
    "relations": "'{}': its parent, constraints or modifiers changed",
    "deformation": "'{}': what deforms it changed",
    "influences": "rigid body constraints or force fields changed",
    "more": "and {} more",
    "range": "frames {} to {} are played, {} to {} were baked",
    "felt": "in frame {} other gains are traced than were baked",
}
"""Sentences for the kinds of changes."""

Change = tuple[Any, ...]
"""A key of `TEXTS`, and the arguments of its text."""

_NOT_FELT = frozenset(
    {
        *(
            "rna_type",
            "tracing",
            "show_overlay",
            "show_intra",
            "show_best_paths",
            "show_labels",
            "show_flow",
            "xray",
            "bake",
            "meters",
        ),
        *("live_output", "materials", "kept_impacts", "sound"),
        *("full_scale", "full_scale_unit", "full_scale_source"),
    }
)
"""Properties that change nothing of what is baked: of the view, of output, and
those whose values objects copy."""
_BONE = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")

_WORLD = ("enabled", "time_scale", "substeps_per_frame", "solver_iterations")
_BODY = (
    *(
        "type",
        "enabled",
        "kinematic",
        "collision_shape",
        "mesh_source",
        "mass",
        "friction",
        "restitution",
        "use_margin",
    ),
    *("collision_margin", "linear_damping", "angular_damping"),
)


def digest_of(scene: Scene) -> Digest:
    """The current digest of a scene, which does not depend on the current frame."""
    animated, animation = _animation(scene)
    settings: JsonObject = {"metres per unit": metres_per_unit(scene)}
    rules = [animation]
    for key, value in _values(scene.haptics, animated, "haptics."):
        if scene.haptics.bl_rna.properties[key].type in PLAIN_TYPES:
            settings[key] = value
        else:
            rules.append(value)
    shown = _layer_objects(scene)
    moving = with_movers(obj for obj in shown if _is_relevant(obj))
    objects = {
        obj.name_full: {
            "haptics": _haptic_sum(obj, scene),
            **_motion(obj),
            "deformation": deformation_of(obj, animated_paths(obj) or ()),
        }
        for obj in moving
    }
    return {
        "settings": settings,
        "rules": checksum(rules),
        "start": scene.frame_start,
        "influences": _influences(shown),
        **_physics(scene),
        "objects": objects,
    }


def motion_of(scene: Scene) -> str:
    """A checksum of everything that determines the impacts of a scene, independent of its haptic
    settings and the current frame.

    It covers physics, and the shape, transforms, animation, rigid body, parent, constraints and
    modifiers of haptic objects and of objects that may move them.
    """
    moving = with_movers(obj for obj in _layer_objects(scene) if _may_collide(obj))
    motions = [(obj.name_full, _motion(obj, ("haptics.",))) for obj in moving]
    return checksum([_physics(scene), motions, metres_per_unit(scene)])


def changes(before: Form, now: Digest) -> tuple[Change, ...]:
    """The changes between two digests: the first few, and the number of further ones. ``before``
    comes from a file and may be invalid."""
    was = _mapping(before.get("settings"))
    settings = now["settings"]
    found: list[Change] = [
        ("setting", key.replace("_", " "), was[key], settings[key])
        for key in settings
        if key in was and was[key] != settings[key]
    ]
    found += [(kind,) for kind, key in _WHOLES if key in before and before[key] != now[key]]
    old = _mapping(before.get("objects"))
    objects = now["objects"]
    found += [("added", name) for name in objects if name not in old]
    found += [("removed", name) for name in old if name not in objects]
    for name, aspects in objects.items():
        known = _mapping(old.get(name, aspects))
        found += [(aspect, name) for aspect in _ASPECTS if known.get(aspect) != aspects[aspect]]
    more = len(found) - _MOST_CHANGES
    return (*found[:_MOST_CHANGES], *((("more", more),) if more > 0 else ()))


def words_for(change: Change) -> str:
    """A change as a sentence in the language of the interface."""
    kind, *values = change
    return iface_(TEXTS[kind]).format(*values)


def _mapping(value: Any) -> Form:
    return value if isinstance(value, dict) else {}


def _moves_others(obj: Object) -> bool:
    """Whether an object may move or deform others: it has a rigid body or is a deformer."""
    return obj.rigid_body is not None or obj.type in {"ARMATURE", "LATTICE"}


def _is_relevant(obj: Object) -> bool:
    """Whether an object has a role, acts or moves: cameras, lights and scenery are ignored."""
    return (
        is_tagged(obj)
        or _moves_others(obj)
        or (obj.type in {"MESH", "EMPTY"} and obj.animation_data is not None)
    )


def _may_collide(obj: Object) -> bool:
    return (
        obj.haptics.enabled
        or _moves_others(obj)
        or (obj.type in {"MESH", "EMPTY"} and bool(_animation(obj, ("haptics.",))[1]))
    )


def _physics(scene: Scene) -> Digest:
    render, world = scene.render, scene.rigidbody_world
    stretch = round(stretching(scene), 6)
    return {
        "frame rate": [
            render.fps,
            round(render.fps_base, 6),
            stretch,
        ],
        "gravity": [round(v, 6) for v in scene.gravity] if scene.use_gravity else None,
        "physics": None if world is None else checksum(values_of(world, _WORLD)),
    }


def _influences(objects: Iterable[Object]) -> str:
    """A checksum of the rigid body constraints and force fields among the objects."""
    found = [(obj, *_animation(obj)) for obj in objects if drives_others(obj)]
    return checksum([(influence_of(obj, paths), animation) for obj, paths, animation in found])


def _layer_objects(scene: Scene) -> Iterable[Object]:
    """The objects that are there, at least in some frames, in the view layer that is traced."""
    layer = traced_layer(scene)
    present = set(present_objects(layer).tolist())
    return [
        obj
        for obj in layer.objects
        if obj.session_uid in present or "hide_viewport" in _animation(obj)[0]
    ]


def with_movers(objects: Iterable[Object]) -> list[Object]:
    """The objects and those that move or deform them: parents, and the targets of constraints and
    modifiers."""
    found = {}
    new = list(objects)
    while new:
        obj = new.pop()
        if obj.name_full not in found:
            found[obj.name_full] = obj
            items = chain(obj.constraints, obj.modifiers)
            new += [
                target
                for target in (obj.parent, *(value for item in items for value in _targets(item)))
                if target is not None
            ]
    return list(found.values())


def _targets(item: Any) -> Iterator[Object]:
    """The objects that a constraint or modifier refers to."""
    for key in writable(item, {"POINTER"}):
        if isinstance(value := getattr(item, key), Object):
            yield value


def _haptic_sum(obj: Object, scene: Scene) -> str:
    """A checksum of an object's haptic properties, and of the markers and files to which these
    refer; "" if it has no haptic role."""
    if not is_tagged(obj):
        return ""
    source = obj.haptics.source
    roles: list[Any] = [_values(obj.haptics, _animation(obj)[0], "haptics."), source.sound.kept]
    if source.one_shot and source.trigger_markers:
        roles.append(marker_frames(scene, source.trigger_markers))
    if source.enabled and source.signal == "FILE":
        roles.append(_file_sum(source.filepath, obj))
    return checksum(roles)


def _values(group: Any, animated: Collection[str], prefix: str) -> list[tuple[str, Any]]:
    """The properties of a group, of the groups inside it and of the signals that it refers to,
    except those of which the data path, which begins with ``prefix``, is ``animated``: their values
    depend on the current frame."""
    found = []
    for key, kind in _felt_properties(group.__class__):
        path = f"{prefix}{key}"
        if path in animated:
            continue
        value = getattr(group, key)
        if kind == "COLLECTION":
            value = [
                ("", _values(item, animated, f"{path}[{number}]."))
                for number, item in enumerate(value)
            ]
        elif isinstance(value, ID):
            value = _datablock(value)
        elif kind == "POINTER" and value is not None:
            value = _values(value, animated, f"{path}.")
        else:
            value = plain(value)
        found.append((key, value))
    return found


@lru_cache(maxsize=64)
def _felt_properties(group: type[PropertyGroup]) -> tuple[tuple[str, str], ...]:
    """Names and kinds of the properties of a group that change what is felt."""
    return tuple(
        (item.identifier, item.type)
        for item in group.bl_rna.properties
        if item.identifier not in _NOT_FELT
    )


def _datablock(value: ID) -> Any:
    """The content of a drawn signal, the name of anything else."""
    if not isinstance(value, NodeTree):
        return value.name_full
    animated, animation = _animation(value)
    try:
        curves = [points_of(mapping_of(value, name)) for name in (AMPLITUDE, FREQUENCY)]
    except ValueError:
        curves = []
    drawn = [(points.round(6).tolist(), kinds) for points, kinds in curves]
    return checksum([_values(value.haptics, animated, "haptics."), animation, drawn])


def _file_sum(stored: str, owner: Object) -> str:
    """A checksum of the file whose path is stored with an object, "" if there is none."""
    try:
        path = local_path(stored, owner)
        state = path.stat()
        return _content_sum(path, state.st_mtime_ns, state.st_size)
    except (OSError, ValueError):
        return ""


@lru_cache(maxsize=64)
def _content_sum(path: Path, changed: int, size: int) -> str:
    """The checksum of a file with the modification time ``changed`` and a ``size`` in bytes."""
    with open_regular(path) as file:
        total = 0
        while part := file.read(1 << 20):
            total = zlib.crc32(part, total)
    return f"{size}:{total:08x}"


def _motion(obj: Object, ignored: tuple[str, ...] = ()) -> dict[str, str]:
    """Checksums of an object by aspect, other than its haptic properties: shape, transforms,
    animation, physics, relations. Animation of data paths that begin with those ``ignored`` does
    not count."""
    paths, animation = _animation(obj, ignored)
    keys = getattr(obj.data, "shape_keys", None)
    if keys is not None:
        animation += _animation(keys)[1] + checksum(
            [(key.name, round(key.value, 5)) for key in keys.key_blocks if not keys.animation_data]
        )
    body = obj.rigid_body
    parent, body_of_it = (
        item.name_full if item is not None else "" for item in (obj.parent, obj.haptics.body)
    )
    relations = [
        [
            body_of_it,
            parent,
            obj.parent_type,
            obj.parent_bone,
            [[round(v, 5) for v in row] for row in obj.matrix_parent_inverse],
        ],
        [
            _effective_values(item, f'constraints["{item.name}"].', paths)
            for item in obj.constraints
        ],
        [_effective_values(item, f'modifiers["{item.name}"].', paths) for item in obj.modifiers],
    ]
    placed = [
        (obj, "", TRANSFORM),
        *(
            (bone, f'pose.bones["{bone.name}"].', _BONE)
            for bone in (obj.pose.bones if obj.pose else ())
        ),
    ]
    pose = [
        values_of(item, [key for key in keys if f"{prefix}{key}" not in paths])
        for item, prefix, keys in placed
    ]
    return {
        "pose": checksum(pose),
        "shape": _shape(obj) if is_tagged(obj) or body is not None else "",
        "animation": animation,
        "physics": checksum(_body(obj)),
        "relations": checksum(relations),
    }


def _body(obj: Object) -> list[Any]:
    """The values of an object's rigid body, and its collision layers."""
    body = obj.rigid_body
    return [] if body is None else [*values_of(body, _BODY), read_layers(obj)]


def _effective_values(item: Any, prefix: str, animated: Collection[str]) -> list[Any]:
    """The properties of a modifier, constraint or strip that have an effect and are not
    ``animated``; of datablocks their names."""
    shown = getattr(item, "show_viewport", True)
    values = values_of(
        item, [key for key in writable(item, PLAIN_TYPES) if f"{prefix}{key}" not in animated]
    )
    pointers = (getattr(item, key) for key in writable(item, {"POINTER"}))
    return [
        item.type,
        shown,
        values,
        [value.name_full for value in pointers if isinstance(value, ID)],
    ]


def _shape(obj: Object) -> str:
    mesh = obj.data if obj.type == "MESH" else None
    if mesh is None:
        return checksum([round(v, 5) for corner in obj.bound_box for v in corner])
    places = read_array(
        mesh.vertices, "co", 3
    )  # attributes are those of the edited mesh in Edit Mode, which has no positions
    return f"{len(mesh.polygons)}:{zlib.crc32(places.tobytes()):08x}"


def _animation(datablock: Any, ignored: tuple[str, ...] = ()) -> tuple[frozenset[str], str]:
    """The data paths that are animated, and a checksum of their keys, drivers and strips, without
    those whose paths begin with one ``ignored``."""
    data = datablock.animation_data
    if data is None:
        return frozenset(), ""
    curves = [curve for curve in fcurves_of(datablock) if not curve.data_path.startswith(ignored)]
    drivers = [driver for driver in data.drivers if not driver.data_path.startswith(ignored)]
    parts: list[Any] = [_curve(curve) for curve in curves]
    parts += [
        (
            d.data_path,
            d.array_index,
            d.driver.type,
            d.driver.expression,
            d.mute,
            list(_variables(d.driver)),
        )
        for d in drivers
    ]
    parts += [
        (
            track.mute,
            [
                (
                    _effective_values(strip, "", ()),
                    [_curve(curve) for curve in fcurves_in(strip.action)] if strip.action else "",
                )
                for strip in nla_strips(track)
            ],
        )
        for track in data.nla_tracks
    ]
    return frozenset(item.data_path for item in (*curves, *drivers)), checksum(
        parts
    ) if parts else ""


_OF_KEYS = (
    ("co", 2, np.float32),
    ("handle_left", 2, np.float32),
    ("handle_right", 2, np.float32),
    ("interpolation", 1, np.int32),
)


def _curve(curve: Any) -> tuple[Any, ...]:
    """What an F-curve animates, and checksums of its keys and modifiers."""
    keys = [
        zlib.crc32(read_array(curve.keyframe_points, name, width, kind).tobytes())
        for name, width, kind in _OF_KEYS
    ]
    modifiers = [_effective_values(item, "", ()) for item in curve.modifiers]
    return curve.data_path, curve.array_index, keys, curve.mute, curve.extrapolation, modifiers


def _variables(driver: Any) -> Iterator[tuple[Any, ...]]:
    """What the variables of a driver read."""
    for variable in driver.variables:
        for target in variable.targets:
            owner = "" if target.id is None else target.id.name_full
            yield (
                variable.name,
                variable.type,
                owner,
                target.data_path,
                target.bone_target,
                target.transform_type,
            )
