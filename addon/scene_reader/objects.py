"""One object of Blender as haptic object, source and listener, in the values of the core."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bpy.types import Object, Scene

from ...core.contacts.settings import Motion
from ...core.declaration import Curve
from ...core.scene.materials import named_in
from ...core.scene.values import ALL_LAYERS, HapticObject, Listener, Source
from ...core.signals import Automation, impact_material
from ..blender.full_names import object_named
from ..blender.single_precision import shortest
from ..blender.units import metres_per_unit
from ..properties.declared import read_values
from .functions import read_function
from .kept_signal import signal_of_text
from .signals import decaying, played_once, read_signal


def read_object(obj: Object, scene: Scene) -> HapticObject:
    """The haptic object of a Blender object, without shape and pose. Raises ValueError if its
    function is invalid."""
    haptics = obj.haptics
    return HapticObject(
        obj.name_full,
        **read_values(HapticObject, haptics),
        **_read_physics(obj, scene),
        propagation=read_function(haptics),
        impact_material=read_impact_material(obj) or "",
        material=haptics.material.name,
    )


def has_body_of(obj: Object, item: HapticObject, scene: Scene) -> bool:
    """Whether an object is still the rigid body, or none, that its haptic object ``item`` says."""
    return _read_physics(obj, scene) == {
        "mass": item.mass,
        "motion": item.motion,
        "layers": item.layers,
    }


def _read_physics(obj: Object, scene: Scene) -> dict[str, Any]:
    """The values of a haptic object that a rigid body has."""
    return {
        "mass": None if obj.rigid_body is None else mass_of(obj, scene),
        "motion": read_motion(obj),
        "layers": read_layers(obj),
    }


def mass_of(obj: Object, scene: Scene) -> float:
    """The mass [kg] of a rigid body as Blender shows it, with the cube of the unit scale."""
    assert obj.rigid_body is not None
    return float(f"{shortest(obj.rigid_body.mass) * metres_per_unit(scene) ** 3:.7g}")


def read_source(
    obj: Object, carrier: str, frequency: Automation | None = None, is_silenced: bool = False
) -> Source:
    """The source of a Blender object, without its triggers and its position, which the reader sets
    in every frame.

    Args:
        obj: the object.
        carrier: name of the haptic object that it is on.
        frequency: over the scene's time, None where it is not animated.
        is_silenced: whether it is muted, or others are solo.
    """
    properties = obj.haptics.source
    values = read_values(Source, properties)
    kept = properties.signal == "KEPT"
    signal = signal_of_text(properties.kept) if kept else read_signal(properties, frequency)
    signal = decaying(signal, properties.decay)
    values["signal"] = played_once(signal) if properties.one_shot else signal
    if is_silenced:
        values["amplitude"] = 0.0
    return Source(obj.name_full, carrier, **values)


def calibrated(listener: Listener) -> Listener:
    """A listener of a track with the calibration that the object of its name has now: a track has
    none, because calibrations belong to the device that plays it."""
    obj = object_named(listener.name)
    if obj is None or not obj.haptics.listener.full_scale:
        return listener
    held = obj.haptics.listener
    try:
        points = Curve(label="Full Scale").read(str(held.full_scale))
    except ValueError:
        return listener  # the panel names the fault
    return replace(listener, full_scale=points, full_scale_unit=held.full_scale_unit)


def read_listener(obj: Object, carrier: str, is_silenced: bool = False) -> Listener:
    """The listener of a Blender object on the haptic object of the name ``carrier``, without its
    position, as `read_source`."""
    properties = obj.haptics.listener
    values = read_values(Listener, properties)
    if values["mixing"] != "custom":
        values["mixing_expression"] = ""
    if is_silenced:
        values["gain"] = 0.0
    return Listener(obj.name_full, carrier, **values)


def read_impact_material(obj: Object) -> str | None:
    """The impact material of an object, by the name of its haptic material; None if that is
    unknown."""
    material = named_in(obj.haptics.material.name)
    return None if material is None else impact_material(material.name)


def read_layers(obj: Object) -> int:
    """The layers of collision of a rigid body, as bits: its collision collections in Blender; none
    of a part of a haptic compound, which strikes for it. An object without one is in all."""
    body = obj.rigid_body
    if body is None:
        return ALL_LAYERS
    above = obj.parent
    whole = above.rigid_body if above is not None and above.haptics.enabled else None
    if whole is not None and whole.collision_shape == "COMPOUND":
        return 0
    return sum(1 << k for k, is_in in enumerate(body.collision_collections) if is_in)


def read_motion(obj: Object) -> Motion:
    """How an object moves: by physics, by animation, or not at all."""
    body = obj.rigid_body
    if body is None or body.kinematic:
        return Motion.KINEMATIC
    return Motion.DYNAMIC if body.type == "ACTIVE" else Motion.STATIC
