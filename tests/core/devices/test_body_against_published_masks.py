"""The body table against MPEG's published bits and the derived schemas' vocabulary, and against its
own mirror."""

import re

import pytest
from haptic_tracing.core.scene.body import BODY_PART, BODY_PARTS, PAPER_LISTENERS, body_part

# Bits of OHMData.h in MPEGGroup/HapticReferenceSoftware. On each side: ear 0x4, chest 0x10, then
# every second bit from the upper arm to the toes; the left one is the right one shifted by 1.
RIGHT_BITS = 0x4 | 0x10 | sum(1 << bit for bit in range(10, 32, 2))
LEFT_BITS = RIGHT_BITS << 1
MIDLINE_BITS = 0x1 | 0x2 | 0x40 | 0x80 | 0x100 | 0x200
MPEG_TARGETS = re.findall(
    r"\S+",
    "Unknown All Top Down Right Left Front Back Arm Head Chest Waist Leg Upper-arm Forearm Hand "
    "Crane Neck Thigh Calf Foot Palm Finger "
    "Sole Toe Thumb Index Middle Ring Pinky Hallux Index-toe Middle-toe Ring-toe Pinky-toe Minus "
    "Plus",
)
BHAPTICS_POSITIONS = [
    "VestFront",
    "VestBack",
    "Head",
    "ForearmL",
    "ForearmR",
    "HandL",
    "HandR",
    "GloveL",
    "GloveR",
    "FootL",
    "FootR",
]
# The study's rig as MPEG channels: (mask, target).
STUDY = {
    "ear.L": (0x8, ("Head", "Left")),
    "ear.R": (0x4, ("Head", "Right")),
    "upper_back.L": (0x100, ("Chest", "Back", "Left")),
    "upper_back.R": (0x100, ("Chest", "Back", "Right")),
    "middle_back.L": (0x200, ("Waist", "Back", "Left")),
    "middle_back.R": (0x200, ("Waist", "Back", "Right")),
    "upper_leg.L": (0x800000, ("Thigh", "Left")),
    "upper_leg.R": (0x400000, ("Thigh", "Right")),
    "hand.L": (0x2A0000, ("Hand", "Left")),
    "hand.R": (0x150000, ("Hand", "Right")),
}


def test_there_are_25_parts_with_unique_names_and_the_ten_of_the_study():
    assert len(BODY_PARTS) == len(BODY_PART) == 25
    assert set(PAPER_LISTENERS) == set(STUDY)
    for name, (mask, target) in STUDY.items():
        assert (body_part(name).mpeg_mask, body_part(name).mpeg_target) == (mask, target)


@pytest.mark.parametrize("part", BODY_PARTS, ids=lambda part: part.name)
def test_names_sides_masks_and_vocabularies_agree(part):
    side_bits = {"L": LEFT_BITS, "R": RIGHT_BITS, "": 0}[part.side]
    assert part.mpeg_mask and part.mpeg_mask & ~(side_bits | MIDLINE_BITS) == 0
    assert set(part.mpeg_target) <= set(MPEG_TARGETS)
    assert ("Left" in part.mpeg_target, "Right" in part.mpeg_target) == (
        part.side == "L",
        part.side == "R",
    )
    assert part.wyvrn_side == {"L": "Left", "R": "Right", "": "Global"}[part.side]
    assert part.bhaptics is None or part.bhaptics in BHAPTICS_POSITIONS
    assert part.name.endswith(f".{part.side}") if part.side else "." not in part.name
    assert 0.01 <= part.radius <= 0.2


@pytest.mark.parametrize("part", BODY_PARTS, ids=lambda part: part.name)
def test_mirroring_twice_is_the_part_itself_and_once_swaps_every_side(part):
    partner = body_part(part.mirror)
    assert partner.mirror == part.name
    assert {part.side, partner.side} in ({"L", "R"}, {""})
    assert partner.radius == part.radius and partner.wyvrn_target == part.wyvrn_target
    # A left bit of the table is the right bit shifted by one place, everywhere.
    mirrored = (
        (partner.mpeg_mask & RIGHT_BITS) << 1
        | (partner.mpeg_mask & LEFT_BITS) >> 1
        | partner.mpeg_mask & MIDLINE_BITS
    )
    assert mirrored == part.mpeg_mask
    assert [t for t in partner.mpeg_target if t not in ("Left", "Right")] == [
        t for t in part.mpeg_target if t not in ("Left", "Right")
    ]


def test_left_and_right_never_look_the_same_to_another_system():
    assert len({(part.mpeg_mask, part.mpeg_target) for part in BODY_PARTS}) == 25


def test_an_unknown_part_is_named_in_the_error():
    with pytest.raises(ValueError, match="'tail' is unknown"):
        body_part("tail")
