"""The 25 body parts that a listener can represent, and their names in other systems: one table for
devices, formats and the body kit.

It is `body_parts.json`. Masks: bits of HapticReferenceSoftware's OHM metadata (HEAD_FRONT 0x1 ...
L_FOOT_FINGERS 0x80000000). A whole hand is palm, dorsum and fingers; a whole foot likewise. WYVRN's
files have no region for arms: they are mapped to the hand of the same limb.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from ..frozen import frozen
from .references import named

Side = Literal["L", "R", ""]


@frozen
class BodyPart:
    """A place on the body.

    name: ``ear.L``, ``hand.R``, ``belly``: a side is a suffix, as Blender names bones. side: ``L``,
    ``R``, or empty on the midline (always the wearer's own left and right). mirror: name of the
    partner on the other side; a part on the midline is its own. mpeg_mask: ``body_part_mask`` of
    ISO/IEC 23090-31. It has no left and right on the back: ``mpeg_target`` tells them apart.
    mpeg_target: ``body_part_target`` strings of ISO/IEC 23090-31, from the region to the side.
    wyvrn_target: nearest of the five regions that a WYVRN ``haptic.config`` can address.
    wyvrn_side: its ``Spatialization``. bhaptics: position of the bHaptics device that covers the
    part, or None if there is none. radius: default bounding radius of an adult's part, in metres.
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


_TABLE = json.loads(Path(__file__).with_name("body_parts.json").read_text("utf-8"))

BODY_PARTS: tuple[BodyPart, ...] = tuple(
    BodyPart(
        **{**row, "mpeg_mask": int(row["mpeg_mask"], 16), "mpeg_target": tuple(row["mpeg_target"])}
    )
    for row in _TABLE["parts"]
)

BODY_PART: Mapping[str, BodyPart] = MappingProxyType({part.name: part for part in BODY_PARTS})
"""Body parts by name."""

DEFAULT_LISTENERS: tuple[str, ...] = tuple(_TABLE["default_listeners"])
"""Names of the twelve body parts of the default set-up: those of the paper and the feet."""

PAPER_LISTENERS: tuple[str, ...] = tuple(_TABLE["paper_listeners"])
"""Names of the ten body parts of the paper's study and of the samples."""


def body_part(name: str) -> BodyPart:
    """The body part called ``name``. Raises ValueError, which lists the known names, for any
    other."""
    return named(name, BODY_PART, "body part")


def stereo_gains(part: str) -> tuple[float, float]:
    """The gains of a body part on the left and the right channel: its own side, or both at equal
    power on the midline or where the part is unknown."""
    side = BODY_PART[part].side if part in BODY_PART else ""
    return {"L": (1.0, 0.0), "R": (0.0, 1.0), "": (math.sqrt(0.5), math.sqrt(0.5))}[side]


_HEEL, _MASS, _HEIGHT = 0.063, 73.0, 1.76
"""Part of a body's mass with which a heel strikes in walking (Chi & Schmitt, J. Biomechanics 2005),
and mass [kg] and height [m] of the reference adult (ICRP Publication 89, 2002)."""

GENTLEST_STEP = 0.24
"""Energy [J] of the gentlest heel strikes of people, of 0.24 to 3.99 J (Chi & Schmitt 2005)."""


def heel_mass(height: float) -> float:
    """The mass [kg] with which the heel of a person of this ``height`` [m] strikes, by that of the
    reference adult at another scale."""
    return _HEEL * _MASS * (height / _HEIGHT) ** 3
