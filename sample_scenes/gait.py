"""The walk of a character of `real_content`: keys of its bones, from where its feet are.

Places in the plane of a step are complex numbers, forward + up j [m] from the armature's origin; a
bone turned by an angle about its x axis turns by the same angle there.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable

from bpy.types import Object
from mathutils import Vector

from .animation import animate

PREFIX = "mixamorig:"
STRIDE = 1.0
"""Metres of two steps."""
_STANCE, _FLAT, _ROLLS = 0.62, 0.07, 0.40
"""Parts of a stride: when a foot leaves the ground, lies flat on it and begins to roll off."""
_STRIKE, _PUSH, _LIFT = 0.2, 0.6, 0.05
"""Angles of a foot when it comes down and leaves [rad], and how far a step lifts it [m]."""
_LOWER, _BOB = 0.04, 0.018
"""How far walking lowers hips, and how far they go up and down [m]."""
_HEEL, _TOE = -0.065, 0.2
"""Where a shoe begins and ends, from the ankle forward [m]."""
_ARM, _ELBOW = 0.38, 0.3


def walk(
    armature: Object, frames: Iterable[int], stride_frames: float, *, sole: float = 0.0
) -> None:
    """Let a character walk to where it looks, from where it is in the first of ``frames``.

    stride_frames: that two steps take. sole: how far below the armature's origin its feet stand, on
    shoes [m].
    """
    ahead = armature.rotation_euler.to_matrix() @ Vector((0.0, -1.0, 0.0))
    begin, numbers = armature.location.copy(), list(frames)
    strides = {frame: (frame - numbers[0]) / stride_frames for frame in numbers}
    sinks = {frame: _LOWER + _BOB * math.cos(4 * math.pi * at) for frame, at in strides.items()}
    animate(
        armature,
        "location",
        {
            frame: begin + ahead * STRIDE * at - Vector((0.0, 0.0, sinks[frame]))
            for frame, at in strides.items()
        },
    )
    for side, late in (("Left", 0.0), ("Right", 0.5)):
        turns: dict[str, dict[int, float]] = {
            name: {} for name in ("UpLeg", "Leg", "Foot", "Arm", "ForeArm")
        }
        for frame, at in strides.items():
            legs = _leg(armature, side, (at + late) % 1.0, sinks[frame], sole)
            swing = _ARM * math.cos(2 * math.pi * (at + late))
            for name, turn in zip(turns, (*legs, -swing, _ELBOW * (1.2 - swing)), strict=True):
                turns[name][frame] = turn
        for name, keys in turns.items():
            bone = armature.pose.bones[PREFIX + side + name]
            bone.rotation_mode = "XYZ"
            path = f'pose.bones["{bone.name}"].rotation_euler'
            animate(armature, path, {frame: (turn, 0.0, 0.0) for frame, turn in keys.items()})


def _leg(
    armature: Object, side: str, at: float, sink: float, sole: float
) -> tuple[float, float, float]:
    """The turns of thigh, shin and foot at a part of a stride, the armature lower by ``sink``."""
    hip, knee, ankle = (
        complex(-head.y, head.z)
        for head in (
            armature.data.bones[PREFIX + side + name].head_local
            for name in ("UpLeg", "Leg", "Foot")
        )
    )
    place, pitch = _foot(at, ankle.imag + sole)
    way = hip.real + place + (sink - sole) * 1j - hip
    thigh, shin = abs(knee - hip), abs(ankle - knee)
    length = min(abs(way), 0.9999 * (thigh + shin))
    bend = math.acos((thigh**2 + length**2 - shin**2) / (2 * thigh * length))
    above = thigh * way / abs(way) * cmath.exp(bend * 1j)
    upper = cmath.phase(above / (knee - hip))
    lower = cmath.phase((way / abs(way) * length - above) / (ankle - knee))
    return upper, lower - upper, pitch - lower


def _foot(at: float, height: float) -> tuple[complex, float]:
    """Where the ankle is at a part of a stride, from the ground below the hip, and the foot's
    angle; ``height``: of an ankle above its sole."""
    if at < _STANCE:
        roll = max(at - _ROLLS, 0.0) / (_STANCE - _ROLLS)
        pitch = _STRIKE * max(1 - at / _FLAT, 0.0) - _PUSH * roll**1.5
        pivot = _HEEL if pitch > 0 else _TOE
        return (
            STRIDE * (_STANCE / 2 - at) + pivot + (height * 1j - pivot) * cmath.exp(pitch * 1j)
        ), pitch
    begin, end = _foot(_STANCE - 1e-9, height)[0], _foot(0.0, height)[0]
    part = (at - _STANCE) / (1 - _STANCE)
    smooth = part * part * (3 - 2 * part)
    # On the ground it moves backwards below the hip, and so it does when it comes down there.
    back = STRIDE * (1 - _STANCE) * part * part * (1 - part)
    lift = _LIFT * math.sin(math.pi * part) * 1j
    return begin + (end - begin) * smooth + back + lift, _STRIKE * smooth - _PUSH * (1 - smooth)
