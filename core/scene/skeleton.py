"""Body parts found on a skeleton by the common names of bones: those of Rigify, Mixamo, MakeHuman,
Unreal, 3ds Max, VRM and similar rigs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .body import BODY_PARTS, BodyPart

Point = FloatArray


@frozen
class Bone:
    """A bone at rest: its name, head and tail in the space of its skeleton."""

    name: str
    head: tuple[float, float, float]
    tail: tuple[float, float, float]


@frozen
class PartPlace:
    """Location of a body part: its bone, and its position in the space of the skeleton at rest."""

    bone: str
    position: tuple[float, float, float]


# Names of bones, without prefixes, sides and numbers. Those of the torso are distinguished by their
# heights.
_LIMBS = {
    "upper_arm": ("upperarm", "uparm", "arm", "shldrbend", "shldr"),
    "forearm": ("forearm", "lowerarm", "loarm", "forearmbend", "elbow"),
    "hand": ("hand", "wrist"),
    "index_finger": (
        "findex",
        "handindex",
        "index",
        "indexproximal",
        "indexintermediate",
        "indexdistal",
        "indexfinger",
    ),
    "upper_leg": ("thigh", "upleg", "upperleg", "thighbend"),
    "lower_leg": ("shin", "calf", "lowerleg", "loleg", "leg", "knee"),
    "foot": ("foot", "ankle"),
}
_FEET = {
    "toes": ("toe", "toes", "bigtoe", "toebase"),
    "midfoot": ("midfoot", "instep", "metatarsal", "metatarsals"),
}
_HIPS = ("hips", "pelvis", "hip")
_TORSO = (
    "spine",
    "chest",
    "upperchest",
    "torso",
    "abdomen",
    "ribs",
    "waist",
    "spinelower",
    "spineupper",
    "abdomenlower",
    "abdomenupper",
)
_NECK = ("neck",)
_HEAD = ("head",)
_PART_OF = {
    name: part
    for part, names in {
        **_LIMBS,
        **_FEET,
        "hips": _HIPS,
        "chest": _TORSO,
        "head": (*_NECK, *_HEAD),
        "belly": ("belly",),
    }.items()
    for name in names
}
_SIDES = {"l": "L", "left": "L", "r": "R", "right": "R"}
_NOISE = {
    "def",
    "org",
    "mch",
    "b",
    "j",
    "c",
    "bip",
    "biped",
    "cc",
    "base",
    "jnt",
    "bind",
    "bone",
    "valvebiped",
    "mixamorig",
}
_SECOND_RATE = ("ORG-", "MCH-", "VIS_")
_MAKEHUMAN_INDEX = 2  # its fingers are numbered: finger1 is the thumb

_BACK = (-0.06, 0.055)
_OFF_THE_BONE = {
    "ear": (0.0, 0.045),
    "belly": (0.06, 0.0),
    "chest": (0.06, 0.055),
    "upper_back": _BACK,
    "middle_back": _BACK,
}
"""Distance from the middle of a bone to the skin in front, and to the side, as fractions of the
body's height."""


@frozen
class _Named:
    """The parts of a bone's name."""

    bone: Bone
    base: str
    side: str
    numbers: tuple[int, ...]

    @property
    def rank(self) -> tuple[bool, bool, tuple[int, ...], int]:
        """Sort key, the lowest preferred: deforming bones, then others, then helpers; the first of
        a chain."""
        return (
            self.bone.name.startswith(_SECOND_RATE),
            not self.bone.name.startswith("DEF-"),
            self.numbers,
            len(self.bone.name),
        )

    @property
    def head(self) -> Point:
        return np.array(self.bone.head, dtype=np.float64)

    @property
    def tail(self) -> Point:
        return np.array(self.bone.tail, dtype=np.float64)

    @property
    def middle(self) -> Point:
        return (self.head + self.tail) / 2


def places(bones: Iterable[Bone], parts: Sequence[BodyPart] = BODY_PARTS) -> dict[str, PartPlace]:
    """Locations of the body parts by name, without those for which the skeleton has no bone.

    Raises ValueError if the skeleton has no head, no hips, or no left and right.
    """
    named = [_Named(bone, *_taken_apart(bone.name)) for bone in bones]
    limbs = {
        (part, side): found
        for part, names in _LIMBS.items()
        for side in "LR"
        if (found := _first(named, names, side)) is not None
    }
    for side in "LR":
        if ("index_finger", side) not in limbs:
            numbered = [
                n
                for n in named
                if n.base == "finger" and n.side == side and n.numbers[:1] == (_MAKEHUMAN_INDEX,)
            ]
            if numbered:
                limbs["index_finger", side] = min(numbered, key=lambda n: n.rank)
    torso, head, hips = _trunk(named)
    if head is None or hips is None:
        missing = "head" if head is None else "hips"
        raise ValueError(
            f"no bone of the {missing} found: is it a body's? Known are the names of Rigify, "
            "Mixamo, MakeHuman"
        )
    up = _unit(head.middle - hips.head)
    across = [
        limbs[part, "L"].head - limbs[part, "R"].head
        for part in _LIMBS
        if (part, "L") in limbs and (part, "R") in limbs
    ]
    left = sum(across, np.zeros(3))
    left = left - up * (left @ up)
    if np.linalg.norm(left) < 1e-9:
        raise ValueError(
            "no left and right arms or legs found: names of bones end in .L and .R, or begin "
            "with Left and Right"
        )
    left = _unit(left)
    front = np.cross(left, up)
    height = _height(head, limbs, up, hips)
    belly = next((bone for bone in torso if bone is not hips), torso[0])
    trunk = {
        "head": head,
        "ear": head,
        "hips": hips,
        "belly": belly,
        "middle_back": torso[len(torso) // 2],
    }
    trunk |= dict.fromkeys(("chest", "upper_back"), torso[-1])
    result: dict[str, PartPlace] = {}
    for part in parts:
        name = part.name.partition(".")[0]
        carrier = trunk[name] if name in trunk else limbs.get((name, part.side))
        if carrier is None:
            continue
        forwards, aside = _OFF_THE_BONE.get(name, (0.0, 0.0))
        sideways = left * {"L": aside, "R": -aside, "": 0.0}[part.side]
        start = (
            carrier.head
            if name == "hips"
            else carrier.tail
            if name == "index_finger"
            else carrier.middle
        )
        result[part.name] = PartPlace(
            carrier.bone.name, tuple((start + (front * forwards + sideways) * height).tolist())
        )
    return result


def part_in(text: str) -> str:
    """The body part, without its side, in an object's name such as "Avatar Upper Arm.L"; the last
    of several; "" for none."""
    words = [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", text)]
    for pair in zip(reversed(["", *words][:-1]), reversed(words), strict=True):
        for name in ("".join(pair), pair[1]):
            if name in _PART_OF:
                return _PART_OF[name]
    return ""


def _taken_apart(name: str) -> tuple[str, str, tuple[int, ...]]:
    """A bone's name without prefixes, its side and its numbers."""
    name = re.sub(r"^mixamorig\d*_?", "", name.rpartition(":")[2])
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    side = ""
    base = ""
    numbers = []
    for word in words:
        lower = word.lower()
        if lower.isdigit():
            numbers.append(int(lower))
        elif lower in _SIDES and not side:
            side = _SIDES[lower]
        elif lower not in _NOISE:
            base += lower
    return base, side, tuple(numbers)


def _first(named: list[_Named], names: tuple[str, ...], side: str = "") -> _Named | None:
    """The best bone with the first of ``names`` that any bone has."""
    for name in names:
        found = [n for n in named if n.base == name and n.side == side]
        if found:
            return min(found, key=lambda n: n.rank)
    return None


def _trunk(named: list[_Named]) -> tuple[list[_Named], _Named | None, _Named | None]:
    """The bones of the torso from below, the head and the hips."""
    spines = [n for n in named if n.base in _TORSO and not n.side]
    least = min((n.rank[:2] for n in spines), default=None)
    spines = sorted((n for n in spines if n.rank[:2] == least), key=lambda n: n.numbers)
    head = _first(named, _HEAD)
    hips = _first(named, _HIPS)
    neck = _first(named, _NECK)
    chain = [n for n in spines if n.base == "spine"]
    # Rigify's spine is the hips, the belly, two of the chest, two of the neck and the head.
    if len(chain) == 7 and (head is None or chain[0].bone.name.startswith("DEF-")):
        return chain[1:4], chain[6], chain[0]
    bottom = hips or (spines[0] if spines else None)
    if head is not None and bottom is not None:
        up = head.head - bottom.head
        spines = sorted(spines, key=lambda n: float(n.middle @ up))
        if neck is not None:
            spines = [n for n in spines if n.head @ up < neck.head @ up] or spines
    hips = hips or (spines[0] if spines else None)
    return spines or ([hips] if hips is not None else []), head, hips


def _height(head: _Named, limbs: dict[tuple[str, str], _Named], up: Point, hips: _Named) -> float:
    """Distance from the soles to the middle of the head; without feet, twice that from the hips."""
    feet = [limbs["foot", side].tail for side in "LR" if ("foot", side) in limbs]
    if not feet:
        return 2.0 * float(np.linalg.norm(head.middle - hips.head))
    return max(float((head.middle - foot) @ up) for foot in feet)


def _unit(vector: Point) -> Point:
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise ValueError(
            "the head and the hips are at the same place: is this the armature of a body?"
        )
    return vector / length
