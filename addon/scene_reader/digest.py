"""Digests of a scene, to find changes since a bake or since the detection of impacts.

A digest is plain data: settings and frame rate, and for every relevant object one checksum per aspect.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from typing import Any

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Object, Scene

from ..blender.arrays import read_array
from ..blender.compatibility import fcurves_of
from .roles import is_tagged, regions_of
from .triggers import marker_frames

Digest = dict[str, Any]

_MOST_CHANGES = 6
_WHOLES = (("frame rate", "frame rate"), ("gravity", "gravity"), ("world", "physics"))
_ASPECTS = ("haptics", "pose", "shape", "animation", "physics", "relations")
TEXTS = {
    "setting": "{} was {}, is {}",
    "frame rate": "the frame rate changed",
    "gravity": "gravity changed",
    "world": "the rigid body world changed",
    "added": "'{}' was added",
    "removed": "'{}' was removed",
    "haptics": "'{}': its haptic settings changed",
    "pose": "'{}': it was moved, turned or scaled",
    "shape": "'{}': its shape changed",
    "animation": "'{}': its animation changed",
    "physics": "'{}': its rigid body changed",
    "relations": "'{}': its parent, constraints or modifiers changed",
    "more": "and {} more",
    "range": "frames {} to {} are played, {} to {} were baked",
}
"""Sentences for the kinds of changes."""

Change = tuple[Any, ...]
"""A key of `TEXTS`, and the arguments of its text."""

_VIEW = {"tracing", "show_overlay", "show_intra", "show_best_paths", "show_labels", "show_flow", "xray"}
_NAMES = {"rna_type", "name"}
_LONG = 60  # characters of a text that a digest holds
_TRANSFORM = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")

_WORLD = ("enabled", "time_scale", "substeps_per_frame", "solver_iterations")
_BODY = (
    *("type", "enabled", "kinematic", "collision_shape", "mesh_source", "mass", "friction", "restitution", "use_margin"),
    *("collision_margin", "linear_damping", "angular_damping"),
)


def digest_of(scene: Scene) -> Digest:
    """The current digest of a scene, which does not depend on the current frame."""
    haptics = scene.haptics
    settings = dict(_properties(haptics, [key for key in _plain_keys(haptics) if key not in _VIEW]))
    regions = regions_of(scene)
    matter = [obj for obj in scene.objects if _matters(obj) or obj.name in regions]
    objects = {obj.name_full: {"haptics": _roles(obj, scene), **_motion(obj)} for obj in matter}
    return {"settings": settings, **_physics(scene), "objects": objects}


def motion_of(scene: Scene) -> str:
    """A checksum of everything that determines the impacts of a scene, independent of its haptic settings and the current frame.

    It covers physics, and the shape, transforms, animation, rigid body, parent, constraints and modifiers of haptic objects and of objects
    that may move them.
    """
    regions = regions_of(scene)
    moving = [obj for obj in scene.objects if _may_hit(obj) or obj.name in regions]
    return _sum([_physics(scene), [(obj.name_full, _motion(obj, "haptics.")) for obj in moving]])


def changes(before: Mapping[str, Any], now: Digest) -> tuple[Change, ...]:
    """The changes between two digests: the first few, and the number of further ones. ``before`` comes from a file and may be invalid."""
    was, settings = _mapping(before.get("settings")), now["settings"]
    found: list[Change] = [
        ("setting", key.replace("_", " "), was[key], settings[key]) for key in settings if key in was and was[key] != settings[key]
    ]
    found += [(kind,) for kind, key in _WHOLES if before.get(key) != now[key]]
    old, objects = _mapping(before.get("objects")), now["objects"]
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


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _acts(obj: Object) -> bool:
    """Whether an object has a rigid body or deforms others."""
    return obj.rigid_body is not None or obj.type in {"ARMATURE", "LATTICE"}


def _matters(obj: Object) -> bool:
    """Whether an object has a role, acts or moves: cameras, lights and scenery are ignored."""
    return is_tagged(obj) or _acts(obj) or (obj.type in {"MESH", "EMPTY"} and obj.animation_data is not None)


def _may_hit(obj: Object) -> bool:
    return obj.haptics.enabled or _acts(obj) or (obj.type in {"MESH", "EMPTY"} and bool(_animation(obj, "haptics.")[1]))


def _physics(scene: Scene) -> Digest:
    render, world = scene.render, scene.rigidbody_world
    return {
        "frame rate": [render.fps, round(render.fps_base, 6)],
        "gravity": [round(v, 6) for v in scene.gravity] if scene.use_gravity else None,
        "physics": None if world is None else _sum(_properties(world, _WORLD)),
    }


def _roles(obj: Object, scene: Scene) -> str:
    haptics, paths = obj.haptics, _animation(obj)[0]
    groups = (("", haptics), ("source.", haptics.source), ("listener.", haptics.listener), ("material.", haptics.material))
    roles = [
        _settings(group, {path for path in paths if path.startswith(f"haptics.{prefix}")}) for prefix, group in groups if is_tagged(obj)
    ]
    if haptics.source.one_shot and haptics.source.trigger_markers:
        roles.append(list(marker_frames(scene, haptics.source.trigger_markers)))
    if haptics.source.sound.kept:
        roles.append([_plain(haptics.source.sound.kept)])
    return _sum(roles)


def _motion(obj: Object, ignored: str = "haptics.felt.") -> dict[str, str]:
    """The aspects other than the haptic settings; animation of data paths that begin with ``ignored`` does not count."""
    paths, animation = _animation(obj, ignored)
    keys = getattr(obj.data, "shape_keys", None)
    if keys is not None:
        animation += _animation(keys)[1] + _sum([(key.name, round(key.value, 5)) for key in keys.key_blocks if not keys.animation_data])
    body = obj.rigid_body
    parent, body_of_it = (item.name_full if item is not None else "" for item in (obj.parent, obj.haptics.body))
    relations = [
        [body_of_it, parent, obj.parent_type, obj.parent_bone, [[round(v, 5) for v in row] for row in obj.matrix_parent_inverse]],
        [(item.name, item.type, item.mute) for item in obj.constraints],
        [(item.name, item.type, item.show_viewport) for item in obj.modifiers],
    ]
    return {
        "pose": _sum([list(getattr(obj, key)) for key in _TRANSFORM if key not in paths]),
        "shape": _shape(obj) if is_tagged(obj) or body is not None else "",
        "animation": animation,
        "physics": _sum(_properties(body, _BODY) if body is not None else []),
        "relations": _sum(relations),
    }


def _settings(group: Any, animated: Iterable[str]) -> list[Any]:
    """The plain properties of a group without animated ones, whose values depend on the current frame."""
    skipped = {path.rpartition(".")[2] for path in animated}
    return _properties(group, [key for key in _plain_keys(group) if key not in skipped])


def _plain_keys(group: Any) -> list[str]:
    return [p.identifier for p in group.bl_rna.properties if p.type not in {"POINTER", "COLLECTION"} and p.identifier not in _NAMES]


def _properties(owner: Any, keys: Iterable[str]) -> list[Any]:
    return [(key, _plain(getattr(owner, key))) for key in keys]


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, str):
        return value if len(value) <= _LONG else f"{value[:_LONG]}... {_sum(value)}"
    return value if isinstance(value, (bool, int)) else [_plain(part) for part in value]


def _shape(obj: Object) -> str:
    mesh = obj.data if obj.type == "MESH" else None
    if mesh is None:
        return _sum([round(v, 5) for corner in obj.bound_box for v in corner])
    places = read_array(mesh.vertices, "co", 3)  # attributes are those of the edited mesh in Edit Mode, which has no positions
    return f"{len(mesh.polygons)}:{zlib.crc32(places.tobytes()):08x}"


def _animation(datablock: Any, ignored: str = "haptics.felt.") -> tuple[frozenset[str], str]:
    """The data paths that are animated, and a checksum of their keys, drivers and strips. Paths that begin with ``ignored`` do not count:
    a bake writes some itself."""
    data = datablock.animation_data
    if data is None:
        return frozenset(), ""
    curves = [curve for curve in fcurves_of(datablock) if not curve.data_path.startswith(ignored)]
    drivers = [driver for driver in data.drivers if not driver.data_path.startswith(ignored)]
    keys = [zlib.crc32(read_array(curve.keyframe_points, "co", 2).tobytes()) for curve in curves]
    parts: list[Any] = [(c.data_path, c.array_index, key, c.mute, len(c.modifiers)) for c, key in zip(curves, keys, strict=True)]
    parts += [(d.data_path, d.array_index, d.driver.expression, d.mute) for d in drivers]
    parts += [
        (track.mute, [(s.frame_start, s.frame_end, s.mute, s.action.name if s.action else "") for s in track.strips])
        for track in data.nla_tracks
    ]
    return frozenset(item.data_path for item in (*curves, *drivers)), _sum(parts) if parts else ""


def _sum(value: Any) -> str:
    return f"{zlib.crc32(repr(value).encode()):08x}"
