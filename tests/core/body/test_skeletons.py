"""Body parts on the skeletons that people have: every part is found, on its own side, where a body
has it."""

import numpy as np
import pytest
from haptic_tracing.core.scene.body import BODY_PART, BODY_PARTS
from haptic_tracing.core.scene.skeleton import Bone, places

# Where the joints of a body 1.8 m high are that faces -y: x to its left, z up. Name: head and tail.
_SPINE = {1: (0.95, 1.05), 2: (1.05, 1.2), 3: (1.2, 1.35), 4: (1.35, 1.48)}


def _body(names):
    """A skeleton from the names of its bones; "{}" stands for the side."""
    bones = []
    for role, pattern in names.items():
        if role in _UPRIGHT:
            low, high = _UPRIGHT[role]
            bones.append(Bone(pattern, (0, 0.02, low), (0, 0.02, high)))
            continue
        head, tail = _LIMB[role]
        for sign, side in ((1, "L"), (-1, "R")):
            name = pattern(side)
            bones.append(Bone(name, (sign * head[0], *head[1:]), (sign * tail[0], *tail[1:])))
    return bones


_UPRIGHT = {
    "hips": (0.92, 1.0), "spine1": (1.0, 1.12), "spine2": (1.12, 1.25), "spine3": (1.25, 1.42), "spine4": (1.42, 1.48),
    "neck1": (1.48, 1.52), "neck2": (1.52, 1.58), "head": (1.58, 1.8),
}  # fmt: skip
_LIMB = {
    "shoulder": ((0.03, 0, 1.45), (0.18, 0, 1.45)), "upper_arm": ((0.18, 0, 1.45), (0.2, 0, 1.15)), "forearm": ((0.2, 0, 1.15), (0.22, 0,
    0.9)),
    "hand": ((0.22, 0, 0.9), (0.22, 0, 0.8)), "index": ((0.22, 0, 0.8), (0.22, -0.02, 0.72)), "thigh": ((0.1, 0, 0.95), (0.1, 0, 0.5)),
    "shin": ((0.1, 0, 0.5), (0.1, 0, 0.1)), "foot": ((0.1, 0, 0.1), (0.1, -0.15, 0.0)),
}  # fmt: skip


def _dotted(base):
    return lambda side: f"{base}.{side}"


def _worded(base, prefix=""):
    return lambda side: f"{prefix}{'Left' if side == 'L' else 'Right'}{base}"


RIGIFY = {
    "hips": "spine", "spine1": "spine.001", "spine2": "spine.002", "spine3": "spine.003", "neck1": "spine.004", "neck2": "spine.005",
    "head": "spine.006", "shoulder": _dotted("shoulder"), "upper_arm": _dotted("upper_arm"), "forearm": _dotted("forearm"),
    "hand": _dotted("hand"), "index": _dotted("f_index.01"), "thigh": _dotted("thigh"), "shin": _dotted("shin"), "foot": _dotted("foot"),
}  # fmt: skip
RIGIFY_GENERATED = {
    role: (
        "DEF-" + name if isinstance(name, str) else (lambda side, name=name: "DEF-" + name(side))
    )
    for role, name in RIGIFY.items()
}


def _mixamo(prefix):
    return {
        "hips": f"{prefix}Hips", "spine1": f"{prefix}Spine", "spine2": f"{prefix}Spine1", "spine3": f"{prefix}Spine2",
        "neck1": f"{prefix}Neck",
        "head": f"{prefix}Head", "shoulder": _worded("Shoulder", prefix), "upper_arm": _worded("Arm", prefix),
        "forearm": _worded("ForeArm", prefix), "hand": _worded("Hand", prefix), "index": _worded("HandIndex1", prefix),
        "thigh": _worded("UpLeg", prefix), "shin": _worded("Leg", prefix), "foot": _worded("Foot", prefix),
    }  # fmt: skip


MAKEHUMAN = {
    "hips": "spine05", "spine1": "spine04", "spine2": "spine03", "spine3": "spine02", "spine4": "spine01", "neck1": "neck01",
    "neck2": "neck02",
    "head": "head", "shoulder": _dotted("clavicle"), "upper_arm": _dotted("upperarm01"), "forearm": _dotted("lowerarm01"),
    "hand": _dotted("wrist"), "index": _dotted("finger2-1"), "thigh": _dotted("upperleg01"), "shin": _dotted("lowerleg01"),
    "foot": _dotted("foot"),
}  # fmt: skip
UNREAL = {
    "hips": "pelvis", "spine1": "spine_01", "spine2": "spine_02", "spine3": "spine_03", "neck1": "neck_01", "head": "head",
    **{role: (lambda side, base=base: f"{base}_{side.lower()}") for role, base in {
        "shoulder": "clavicle", "upper_arm": "upperarm", "forearm": "lowerarm", "hand": "hand", "index": "index_01", "thigh": "thigh",
        "shin": "calf", "foot": "foot"}.items()},
}  # fmt: skip
BIPED = {
    "hips": "Bip01 Pelvis", "spine1": "Bip01 Spine", "spine2": "Bip01 Spine1", "spine3": "Bip01 Spine2", "neck1": "Bip01 Neck",
    "head": "Bip01 Head",
    **{role: (lambda side, base=base: f"Bip01 {side} {base}") for role, base in {
        "shoulder": "Clavicle", "upper_arm": "UpperArm", "forearm": "Forearm", "hand": "Hand", "thigh": "Thigh", "shin": "Calf",
        "foot": "Foot"}.items()},
}  # fmt: skip
SKELETONS = {
    "Rigify metarig": RIGIFY,
    "Rigify generated": RIGIFY_GENERATED,
    "Mixamo": _mixamo("mixamorig:"),
    "Mixamo numbered": _mixamo("mixamorig1:"),
    "Mixamo plain": _mixamo(""),
    "MakeHuman": MAKEHUMAN,
    "Unreal": UNREAL,
    "3ds Max": BIPED,
}


@pytest.mark.parametrize("name", SKELETONS)
def test_every_part_is_where_a_body_has_it(name):
    found = places(_body(SKELETONS[name]))
    missing = {part.name for part in BODY_PARTS} - set(found)
    assert missing == ({"index_finger.L", "index_finger.R"} if name == "3ds Max" else set())
    position = {part: np.array(place.position) for part, place in found.items()}
    for part, place in position.items():
        side = BODY_PART[part].side
        assert (place[0] > 0.02, place[0] < -0.02) == (side == "L", side == "R"), part
        if side == "L":
            assert place * [-1, 1, 1] == pytest.approx(position[BODY_PART[part].mirror])
    for above, below in (
        ("head", "chest.L"),
        ("chest.L", "belly"),
        ("belly", "upper_leg.L"),
        ("upper_leg.L", "lower_leg.L"),
        ("lower_leg.L", "foot.L"),
    ):
        assert position[above][2] > position[below][2], (above, below)
    assert position["upper_back.L"][2] > position["middle_back.L"][2]
    assert position["chest.L"][1] < -0.03
    assert position["belly"][1] < -0.03
    assert position["upper_back.L"][1] > 0.03
    assert position["middle_back.L"][1] > 0.03
    bones = {bone.name: bone for bone in _body(SKELETONS[name])}
    assert all(place.bone in bones for place in found.values())
    assert (
        len(
            {
                found[part].bone
                for part in (
                    "head",
                    "hips",
                    "upper_arm.L",
                    "forearm.L",
                    "hand.L",
                    "upper_leg.L",
                    "lower_leg.L",
                    "foot.L",
                )
            }
        )
        == 8
    )


@pytest.mark.parametrize("name", SKELETONS)
@pytest.mark.parametrize(
    "turn", [((0, 0, 1), (1, 0, 0), (0, 1, 0)), ((1, 0, 0), (0, 0, 1), (0, -1, 0))]
)
def test_any_orientation_gives_the_same_body(name, turn):
    """Files from elsewhere have other axes up."""
    matrix = np.array(turn, dtype=float)
    matrix[:, 0] *= np.linalg.det(matrix)
    straight = _body(SKELETONS[name])
    turned = [
        Bone(b.name, tuple(matrix @ b.head * 100), tuple(matrix @ b.tail * 100)) for b in straight
    ]
    expected, found = places(straight), places(turned)
    assert set(found) == set(expected)
    for part, place in found.items():
        assert place.bone == expected[part].bone
        assert np.array(place.position) == pytest.approx(100 * matrix @ expected[part].position)


def test_helpers_of_a_generated_rig_do_not_win():
    bones = _body(RIGIFY_GENERATED)
    extra = [Bone("ORG-" + b.name.removeprefix("DEF-"), b.head, b.tail) for b in bones] + [
        Bone("head", (0, 0, 1.6), (0, 0, 1.8))
    ]
    found = places([*extra, *bones])
    assert {place.bone.split("-")[0] for place in found.values()} == {"DEF"}


@pytest.mark.parametrize(
    ("bones", "words"),
    [
        ([], "no bone of the head"),
        ([Bone("Bone", (0, 0, 0), (0, 0, 1))], "no bone of the head"),
        ([Bone("head", (0, 0, 1), (0, 0, 2))], "no bone of the hips"),
        (
            [Bone("head", (0, 0, 1), (0, 0, 2)), Bone("hips", (0, 0, 0), (0, 0, 1))],
            "no left and right",
        ),
        (
            [Bone("head", (0, 0, 0), (0, 0, 0)), Bone("hips", (0, 0, 0), (0, 0, 1))],
            "at the same place",
        ),
    ],
)
def test_what_is_no_body_is_told_so(bones, words):
    with pytest.raises(ValueError, match=words):
        places(bones)
