"""How the objects of a scene hang together: what moves as one, and what turns or moves on what."""

from __future__ import annotations

from typing import Any

from bpy.types import Object, Scene

from ..blender.arrays import read_array
from ..blender.compatibility import driving_curves, fcurves_of
from .known_motion import is_simulated

_STEADY = 1e-5
"""Change of a key's value that is rounding."""

Link = tuple[Object, str]
"""An object, or, by its name, a bone of an armature, with all that is fixed to it."""


class Linkage:
    """The links of a scene as they are animated now."""

    def __init__(self) -> None:
        self._paths: dict[str, frozenset[str]] = {}

    def above(self, link: Link) -> Link | None:
        """The link that carries one; None if nothing does."""
        carrier = carrier_of(link)
        return None if carrier is None else self.root(carrier)

    def root(self, link: Link) -> Link:
        """The link that one is fixed to, itself if it can turn or move."""
        carrier = carrier_of(link)
        while carrier is not None and not (self.moves(link) or self._turns(link)):
            link, carrier = carrier, carrier_of(carrier)
        return link

    def moves(self, link: Link) -> bool:
        """Whether animation or the simulation moves a link relative to what carries it."""
        obj, bone = link
        if bone:
            path = f'pose.bones["{bone}"].location'
            return not obj.data.bones[bone].use_connect and path in self._animated(obj)
        return is_simulated(obj) or "location" in self._animated(obj)

    def _turns(self, link: Link) -> bool:
        """Whether something may turn a link: a constraint that moves it, too, parts the joint."""
        obj, bone = link
        turns = any(path.startswith("rotation") for path in self._animated(obj))
        return bool(bone) or turns or any(not item.mute for item in obj.constraints)

    def _animated(self, obj: Object) -> frozenset[str]:
        """The data paths whose values change by animation."""
        if obj.name_full not in self._paths:
            curves = (*fcurves_of(obj), *driving_curves(obj))
            changing = (curve.data_path for curve in curves if _changes(curve))
            self._paths[obj.name_full] = frozenset(changing)
        return self._paths[obj.name_full]


def constraints_of(scene: Scene) -> list[tuple[Object, Any]]:
    """The rigid body constraints of a scene between two objects, each after the object that has
    it."""
    group = scene.rigidbody_world and scene.rigidbody_world.constraints
    pins = [(obj, obj.rigid_body_constraint) for obj in (group.all_objects if group else ())]
    return [(obj, pin) for obj, pin in pins if pin and pin.object1 and pin.object2]


def carrier_of(link: Link) -> Link | None:
    """The object or bone that is the parent of one; None without, or if it deforms it."""
    obj, bone = link
    if bone:
        above = obj.data.bones[bone].parent
        return obj, above.name if above else ""
    parent = obj.parent
    if parent is not None and obj.parent_type == "BONE":
        return (parent, obj.parent_bone) if obj.parent_bone in parent.data.bones else None
    return (parent, "") if parent is not None and obj.parent_type == "OBJECT" else None


def _changes(curve: Any) -> bool:
    """Whether the value of a curve changes."""
    values = read_array(curve.keyframe_points, "co", 2)[:, 1].tolist() or [0.0]
    steady = max(values) - min(values) <= _STEADY and not (curve.driver or len(curve.modifiers))
    return not (curve.mute or steady)
