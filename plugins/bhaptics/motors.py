"""The motors of bHaptics devices and the body parts that they represent."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.scene.body import BodyPart

# Places of the motors, x from the wearer's left to right (also on the back), y downwards, as in the
# maker's own files.
_VEST = tuple((i % 4 / 3, i // 4 / 4) for i in range(20))
_HEAD = tuple((i / 5, 0.5) for i in range(6))
_ARM = tuple((i % 3 / 2, float(i // 3)) for i in range(6))
_HAND = tuple((0.5, i / 2) for i in range(3))
_FOOT = tuple((i / 2, 0.5) for i in range(3))
DEVICES: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "Tactot": {"VestFront": _VEST, "VestBack": _VEST},
    "Tactal": {"Head": _HEAD},
    "Tactosy2": {"ForearmL": _ARM, "ForearmR": _ARM},
    "Hand": {"HandL": _HAND, "HandR": _HAND},
    "Foot": {"FootL": _FOOT, "FootR": _FOOT},
}
"""Motors (x, y) of each position, by device."""

_HALVES = {"L": (0.0, 0.5), "R": (0.5, 1.0), "": (0.0, 1.0)}
_HEIGHTS = {
    "upper_back": (0.0, 0.4),
    "middle_back": (0.4, 1.0),
    "chest": (0.0, 0.6),
    "belly": (0.6, 1.0),
}


def region(part: BodyPart, places: Sequence[tuple[float, float]]) -> list[int]:
    """Indices of the motors at ``places`` that represent a body part."""
    device = part.bhaptics or ""
    across = _HALVES[part.side] if device.startswith("Vest") or device == "Head" else (0.0, 1.0)
    along = _HEIGHTS.get(part.name.partition(".")[0], (0.0, 1.0))
    return [
        index
        for index, (x, y) in enumerate(places)
        if across[0] <= x <= across[1] and along[0] <= y <= along[1]
    ]
