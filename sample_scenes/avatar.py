"""An artist's mannequin as the user's avatar: sixteen haptic body parts that touch at their joints,
and listeners: the ten of the paper unless others are named.

It faces -Y, so that its left is +X.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field

from bpy.types import Object, Scene
from mathutils import Matrix, Vector

from ..core.frozen import frozen
from ..core.scene.body import BODY_PART, PAPER_LISTENERS
from ..core.scene.materials import Material as Substance
from .geometry import SUNK, Geometry, Point, along, joined, limb, sphere, superellipsoid
from .materials import FLESH, surface
from .staging import make_listener, make_moving, make_static, place, place_empty

SIDES = ((1.0, "L"), (-1.0, "R"))

BODY, JOINT = 0, 1  # materials

UPPER_ARM, FOREARM = 0.285, 0.245
HIPS = (0.33, 0.225, 0.19)
THIGH_RADIUS, KNEE_RADIUS = 0.078, 0.055
SHOULDER_RADIUS, ELBOW_RADIUS, WRIST_RADIUS, ANKLE_RADIUS = 0.052, 0.040, 0.028, 0.036
FOOT_HEIGHT = 0.07
TURNED_UP = 4.0  # gain (12 dB) of listeners that must feel vibration through a ground
HAND = (0.085, 0.155, 0.036)

# Masses in kg of an adult of 75 kg, as shares of the body that anthropometry gives.
MASS = {
    "Head": 5.5,
    "Chest": 16.0,
    "Belly": 11.0,
    "Hips": 10.5,
    "Upper Arm": 2.0,
    "Forearm": 1.2,
    "Hand": 0.45,
    "Upper Leg": 9.0,
    "Lower Leg": 3.4,
    "Foot": 1.1,
}

# Overlap of neighbouring parts at a joint [m], so that they touch reliably.
OVERLAP = 0.004

ANKLE_HEIGHT = FOOT_HEIGHT + ANKLE_RADIUS - OVERLAP - SUNK


@frozen
class Hand:
    """Where a hand is: the middle of the palm's surface, the direction of the fingers and that of
    the back of the hand."""

    palm: Vector
    fingers: Vector
    back: Vector = field(default_factory=lambda: Vector((0.0, 0.0, 1.0)))

    def mirrored(self) -> Hand:
        """The same on the other side."""
        return Hand(*(_sided(vector, -1.0) for vector in (self.palm, self.fingers, self.back)))


HANGING = Hand(Vector((0.29, -0.06, 0.86)), Vector((0.1, -0.2, -1.0)), Vector((1.0, 0.0, 0.0)))
"""The left hand of one who stands, beside the thigh."""


@frozen
class Posture:
    """Where the limbs bend and end: those of the left, mirrored for the right unless ``right_hand``
    says otherwise.

    All in metres, relative to the avatar's origin. hips: centre of the hips. lean: how far the
    trunk leans back from upright, in radians. hip_joint: where the thigh begins, relative to the
    hips. slump: how much further back the trunk is than the hips.
    """

    hips: Vector
    hip_joint: Vector
    knee: Vector
    ankle: Vector
    hand: Hand
    right_hand: Hand | None = None
    lean: float = 0.0
    slump: float = 0.0

    def hand_of(self, side: float) -> Hand:
        """The left (1) or right (-1) hand."""
        return self.hand if side > 0 else (self.right_hand or self.hand.mirrored())


@frozen
class Mannequin:
    """Relative to the avatar's origin: the shapes of the parts by name (``Hand.L``), the centres of
    the joints (``elbow.L``), and by body part (``hand.L``) the part with its listener, and where.
    """

    shapes: Mapping[str, Geometry]
    joints: Mapping[str, Vector]
    anchors: Mapping[str, tuple[str, Vector]]

    @classmethod
    def of(cls, posture: Posture) -> Mannequin:
        """The body in a posture."""
        joints, shapes = _joints(posture), _trunk(posture)
        for side, letter in SIDES:
            shapes |= _arm(posture, joints, side, letter) | _leg(joints, letter)
        return cls(shapes, joints, _anchors(posture, joints))


@frozen
class Avatar:
    """The root that carries all parts, the parts by name (``Hand.L``), the listeners by body part
    (``hand.L``), the joints (``elbow.L``) relative to the root."""

    root: Object
    parts: Mapping[str, Object]
    listeners: Mapping[str, Object]
    joints: Mapping[str, Vector]


def seated(seat: float, lean: float, hand: Hand | None = None) -> Posture:
    """Sitting on a seat at height ``seat``, the back against a rest that leans back by ``lean``,
    feet on the ground, hands on the thighs.

    The origin is on the ground below the line where seat and rest meet. ``hand``: the left hand,
    where it is elsewhere.
    """
    # The backrest carries the shoulders and leaves the hips free.
    hips = Vector((0.0, -0.132, seat + HIPS[2] / 2 - SUNK))
    hip_joint = Vector((0.088, 0.008 - HIPS[1] / 2, THIGH_RADIUS - HIPS[2] / 2))
    knee = hips + hip_joint + Vector((0.05, -0.42, KNEE_RADIUS - THIGH_RADIUS))
    ankle = Vector((knee.x, knee.y - 0.03, ANKLE_HEIGHT))
    on_thigh = Hand(
        Vector((0.130, -0.45, seat + 2 * _thigh_radius(0.5) + 0.001)), Vector((-0.10, -1.0, -0.30))
    )
    return Posture(hips, hip_joint, knee, ankle, hand or on_thigh, lean=lean, slump=0.034)


def standing(hand: Hand, right_hand: Hand | None = None) -> Posture:
    """Standing upright above the origin; the feet point to -Y."""
    ankle = Vector((0.10, 0.0, ANKLE_HEIGHT))
    knee = Vector((0.096, -0.012, ANKLE_HEIGHT + 0.385))
    hip_joint = Vector((0.088, 0.0, 0.006 - HIPS[2] / 2))
    hips = Vector((0.0, 0.0, knee.z + 0.405)) - Vector((0.0, 0.0, hip_joint.z))
    return Posture(hips, hip_joint, knee, ankle, hand, right_hand)


def build_avatar(
    scene: Scene,
    posture: Posture,
    location: Point = (0.0, 0.0, 0.0),
    heading: float = 0.0,
    *,
    moving: bool = False,
    substance: Substance = FLESH,
    parent: Object | None = None,
    gain: float = 1.0,
    listening: Sequence[str] = PAPER_LISTENERS,
) -> Avatar:
    """Put the avatar into ``scene``, its haptic parts under one empty, turned by ``heading`` about
    z.

    ``moving``: that empty, or what carries it, will be animated. ``gain``: of its listeners.
    ``listening``: the body parts with a listener, of the twelve default ones.
    """
    root = place_empty(scene, "Avatar", location, parent, "ARROWS", 0.25, heading)
    materials = (surface("Avatar Body", "#e9e2d6", 0.45), surface("Avatar Joints", "#2f5d73", 0.4))
    mannequin = Mannequin.of(posture)
    parts: dict[str, Object] = {}
    for part, geometry in mannequin.shapes.items():
        obj = place(scene, f"Avatar {part}", geometry, materials, parent=root)
        if moving:
            make_moving(scene, obj, substance, MASS[part.split(".")[0]])
        else:
            make_static(scene, obj, substance)
        parts[part] = obj
    listeners: dict[str, Object] = {}
    for listener in listening:
        carrier, spot = mannequin.anchors[listener]
        empty = place_empty(
            scene,
            listener,
            spot - parts[carrier].location,
            parts[carrier],
            "SPHERE",
            BODY_PART[listener].radius,
        )
        listeners[listener] = make_listener(empty, listener, gain)
    return Avatar(root, parts, listeners, mannequin.joints)


def trunk_frame(posture: Posture) -> Callable[[float, float, float], Vector]:
    """Maps (left, forward, up) from the hips' centre, along the leaning trunk, to the avatar's
    frame."""
    sine, cosine = math.sin(posture.lean), math.cos(posture.lean)

    def point(left: float, forward: float, up: float) -> Vector:
        forward -= posture.slump
        return posture.hips + Vector(
            (left, -forward * cosine + up * sine, forward * sine + up * cosine)
        )

    return point


def _trunk(posture: Posture) -> dict[str, Geometry]:
    point = trunk_frame(posture)
    turn = Matrix.Rotation(-posture.lean, 4, "X")

    def set_at(geometry: Geometry, forward: float, up: float) -> Geometry:
        return geometry.transformed(Matrix.Translation(point(0.0, forward, up)) @ turn)

    neck = along(
        limb(0.12, 0.052, 0.047), Vector((0, 0.01, -0.165)), Vector((0, 0.012, -0.06))
    ).painted(JOINT)
    skull = joined((superellipsoid((0.165, 0.205, 0.245), 0.85), neck))
    return {
        "Hips": superellipsoid(HIPS, 0.55).moved(*posture.hips),
        "Belly": set_at(superellipsoid((0.27, 0.20, 0.19), 0.6), 0.012, 0.186),
        "Chest": set_at(superellipsoid((0.335, 0.225, 0.31), 0.62), 0.0, 0.425),
        "Head": set_at(skull, 0.02, 0.74),
    }


def _joints(posture: Posture) -> dict[str, Vector]:
    """Centres of the joints of both sides."""
    joints: dict[str, Vector] = {}
    for side, letter in SIDES:
        hand = posture.hand_of(side)
        fingers, back = _hand_axes(hand)
        shoulder = trunk_frame(posture)(side * 0.217, 0.0, 0.515)
        wrist = hand.palm + back * HAND[2] / 2 - fingers * (HAND[1] / 2 + WRIST_RADIUS - OVERLAP)
        joints[f"shoulder.{letter}"] = shoulder
        joints[f"elbow.{letter}"] = _bend(
            shoulder, wrist, UPPER_ARM, FOREARM, Vector((side * 0.75, 1.0, -0.6))
        )
        joints[f"wrist.{letter}"] = wrist
        joints[f"hip.{letter}"] = _sided(posture.hips + posture.hip_joint, side)
        joints[f"knee.{letter}"] = _sided(posture.knee, side)
        joints[f"ankle.{letter}"] = _sided(posture.ankle, side)
    return joints


def _hand_axes(hand: Hand) -> tuple[Vector, Vector]:
    """Unit vectors along the fingers and out of the back of the hand, at right angles."""
    fingers = hand.fingers.normalized()
    return fingers, (hand.back - fingers * hand.back.dot(fingers)).normalized()


def _anchors(posture: Posture, joints: Mapping[str, Vector]) -> dict[str, tuple[str, Vector]]:
    """The part that carries each default listener, and where."""
    point = trunk_frame(posture)
    anchors: dict[str, tuple[str, Vector]] = {}
    for side, letter in SIDES:
        hand = posture.hand_of(side)
        thigh = joints[f"hip.{letter}"].lerp(joints[f"knee.{letter}"], 0.45)
        anchors[f"ear.{letter}"] = ("Head", point(side * 0.085, 0.015, 0.735))
        anchors[f"upper_back.{letter}"] = ("Chest", point(side * 0.095, -0.105, 0.47))
        anchors[f"middle_back.{letter}"] = ("Belly", point(side * 0.075, -0.08, 0.19))
        anchors[f"hand.{letter}"] = (
            f"Hand.{letter}",
            hand.palm + _hand_axes(hand)[1] * HAND[2] / 2,
        )
        anchors[f"foot.{letter}"] = (
            f"Foot.{letter}",
            joints[f"ankle.{letter}"] + Vector((0.0, -0.075, -ANKLE_HEIGHT)),
        )
        anchors[f"upper_leg.{letter}"] = (
            f"Upper Leg.{letter}",
            thigh - _thigh_front(joints, letter) * _thigh_radius(0.45),
        )
    return anchors


def _thigh_front(joints: Mapping[str, Vector], letter: str) -> Vector:
    """Unit vector from the middle of the thigh out of its front: up when sitting, forward when
    standing."""
    along_thigh = (joints[f"knee.{letter}"] - joints[f"hip.{letter}"]).normalized()
    return (
        Vector((0.0, -1.0, 1.0)) - along_thigh * along_thigh.dot(Vector((0.0, -1.0, 1.0)))
    ).normalized()


def _arm(
    posture: Posture, joints: Mapping[str, Vector], side: float, letter: str
) -> dict[str, Geometry]:
    shoulder, elbow, wrist = (
        joints[f"{joint}.{letter}"] for joint in ("shoulder", "elbow", "wrist")
    )
    hand = posture.hand_of(side)
    fingers, back = _hand_axes(hand)
    turn = Matrix((fingers.cross(back), fingers, back)).transposed().to_4x4()
    centre = hand.palm + back * HAND[2] / 2
    return {
        f"Upper Arm.{letter}": _segment(
            shoulder, elbow, SHOULDER_RADIUS, ELBOW_RADIUS, 0.048, 0.039, ball_at_start=True
        ),
        f"Forearm.{letter}": _segment(elbow, wrist, ELBOW_RADIUS, WRIST_RADIUS, 0.040, 0.028),
        f"Hand.{letter}": superellipsoid(HAND, 0.65).transformed(Matrix.Translation(centre) @ turn),
    }


def _leg(joints: Mapping[str, Vector], letter: str) -> dict[str, Geometry]:
    hip, knee, ankle = (joints[f"{joint}.{letter}"] for joint in ("hip", "knee", "ankle"))
    sole = ankle.z - ANKLE_RADIUS - FOOT_HEIGHT + OVERLAP
    return {
        f"Upper Leg.{letter}": _segment(hip, knee, 0.0, KNEE_RADIUS, THIGH_RADIUS, 0.058),
        f"Lower Leg.{letter}": _segment(knee, ankle, KNEE_RADIUS, ANKLE_RADIUS, 0.053, 0.036),
        f"Foot.{letter}": superellipsoid((0.092, 0.25, FOOT_HEIGHT), 0.6).moved(
            ankle.x, ankle.y - 0.075, sole + FOOT_HEIGHT / 2
        ),
    }


def _segment(
    start: Vector,
    end: Vector,
    start_ball: float,
    end_ball: float,
    start_radius: float,
    end_radius: float,
    ball_at_start: bool = False,
) -> Geometry:
    """A limb between two joints: a taper that stops short of the balls, with the ball at its far
    end (and the near one) attached."""
    direction = (end - start).normalized()
    low = start + direction * max(
        start_ball - (OVERLAP if not ball_at_start else 0.6 * start_ball), 0.0
    )
    high = end - direction * 0.6 * end_ball
    parts = [
        along(limb((high - low).length, start_radius, end_radius), low, high),
        sphere(end_ball, 20, 10).moved(*end).painted(JOINT),
    ]
    if ball_at_start:
        parts.append(sphere(start_ball, 20, 10).moved(*start).painted(JOINT))
    return joined(parts)


def _sided(vector: Vector, side: float) -> Vector:
    return Vector((side * vector.x, vector.y, vector.z))


def _thigh_radius(part: float) -> float:
    return THIGH_RADIUS + (0.058 - THIGH_RADIUS) * part


def _bend(start: Vector, end: Vector, first: float, second: float, towards: Vector) -> Vector:
    """The joint of a limb of two bones from ``start`` to ``end``, bent ``towards`` a side. Where
    the limb is too short it is stretched."""
    span = end - start
    length = span.length
    direction = span / length
    if length >= first + second:
        return start + direction * length * first / (first + second)
    part = (first * first - second * second + length * length) / (2 * length)
    side = (towards - direction * towards.dot(direction)).normalized()
    return start + direction * part + side * math.sqrt(max(first * first - part * part, 0.0))
