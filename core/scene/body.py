"""The 25 body parts that a listener can stand for, and how other systems name them: one table for devices, formats and the body kit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Side = Literal["L", "R", ""]


@dataclass(frozen=True, slots=True)
class BodyPart:
    """A place on the body.

    name: ``ear.L``, ``hand.R``, ``belly``: a side is a suffix, as Blender names bones.
    side: ``L``, ``R``, or empty on the midline (always the wearer's own left and right).
    mirror: name of the partner on the other side; a part on the midline is its own.
    mpeg_mask: ``body_part_mask`` of ISO/IEC 23090-31. It has no left and right on the back: ``mpeg_target`` tells them apart.
    mpeg_target: ``body_part_target`` strings of ISO/IEC 23090-31, from the region to the side.
    wyvrn_target: nearest of the five regions that a WYVRN ``haptic.config`` can address.
    wyvrn_side: its ``Spatialization``.
    bhaptics: position of the bHaptics device that covers the part, or None where the maker has none.
    radius: default bounding radius of an adult's part, in metres.
    """

    name: str
    side: Side
    mirror: str
    mpeg_mask: int
    mpeg_target: tuple[str, ...]
    wyvrn_target: Literal["Head", "Chest", "Waist", "Leg", "Hand"]
    wyvrn_side: Literal["Global", "Left", "Right"]
    bhaptics: str | None
    radius: float


_WyvrnTarget = Literal["Head", "Chest", "Waist", "Leg", "Hand"]


def _midline(name: str, mask: int, target: tuple[str, ...], wyvrn: _WyvrnTarget, bhaptics: str | None, radius: float) -> tuple[BodyPart]:
    return (BodyPart(name, "", name, mask, target, wyvrn, "Global", bhaptics, radius),)


def _pair(
    name: str, left_mask: int, right_mask: int, target: tuple[str, ...], wyvrn: _WyvrnTarget, bhaptics: str | None, radius: float
) -> tuple[BodyPart, BodyPart]:
    """Both sides of a part; ``{}`` in the bHaptics position is the letter of the side."""
    left, right = (None, None) if bhaptics is None else (bhaptics.format("L"), bhaptics.format("R"))
    return (
        BodyPart(f"{name}.L", "L", f"{name}.R", left_mask, (*target, "Left"), wyvrn, "Left", left, radius),
        BodyPart(f"{name}.R", "R", f"{name}.L", right_mask, (*target, "Right"), wyvrn, "Right", right, radius),
    )


# Masks: bits of HapticReferenceSoftware's OHM metadata (HEAD_FRONT 0x1 ... L_FOOT_FINGERS 0x80000000). A whole hand is palm, dorsum and
# fingers; a whole foot likewise. Arms have no region of their own in WYVRN's files: they go to the hand of the same limb.
BODY_PARTS: tuple[BodyPart, ...] = (
    *_midline("head", 0x1 | 0x2, ("Head",), "Head", "Head", 0.10),
    *_pair("ear", 0x8, 0x4, ("Head",), "Head", "Head", 0.04),
    *_pair("chest", 0x20, 0x10, ("Chest", "Front"), "Chest", "VestFront", 0.10),
    *_midline("belly", 0x40, ("Waist", "Front"), "Waist", "VestFront", 0.12),
    *_midline("hips", 0x80, ("Waist",), "Waist", None, 0.15),
    *_pair("upper_back", 0x100, 0x100, ("Chest", "Back"), "Chest", "VestBack", 0.10),
    *_pair("middle_back", 0x200, 0x200, ("Waist", "Back"), "Waist", "VestBack", 0.10),
    *_pair("upper_arm", 0x800, 0x400, ("Upper-arm",), "Hand", None, 0.08),
    *_pair("forearm", 0x2000, 0x1000, ("Forearm",), "Hand", "Forearm{}", 0.07),
    *_pair("hand", 0x2A0000, 0x150000, ("Hand",), "Hand", "Hand{}", 0.06),
    *_pair("index_finger", 0x200000, 0x100000, ("Hand", "Index"), "Hand", "Glove{}", 0.02),
    *_pair("upper_leg", 0x800000, 0x400000, ("Thigh",), "Leg", None, 0.12),
    *_pair("lower_leg", 0x2000000, 0x1000000, ("Calf",), "Leg", None, 0.09),
    *_pair("foot", 0xA8000000, 0x54000000, ("Foot",), "Leg", "Foot{}", 0.08),
)

BODY_PART: Mapping[str, BodyPart] = MappingProxyType({part.name: part for part in BODY_PARTS})
"""Body parts by name."""

DEFAULT_LISTENERS: tuple[str, ...] = (
    "ear.L",
    "ear.R",
    "hand.L",
    "hand.R",
    "upper_back.L",
    "upper_back.R",
    "middle_back.L",
    "middle_back.R",
    "upper_leg.L",
    "upper_leg.R",
)
"""The ten places of the default set-up."""


def body_part(name: str) -> BodyPart:
    """The body part called ``name``. Raises ValueError that lists the known names."""
    if name not in BODY_PART:
        raise ValueError(f"body part {name!r} is unknown: use one of {', '.join(BODY_PART)}")
    return BODY_PART[name]
