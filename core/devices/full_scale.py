"""What kinds of devices do at full scale, where their profile doesn't tell: the peak acceleration
of a sine by frequency, published or, marked so, estimated. Such values say what is felt; they are
no calibration of an actuator."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from ..frozen import frozen
from .profiles import Actuator


@frozen
class TypicalFullScale:
    """Of a kind of device: its ``title``, ``points`` of hertz and m/s^2, and their ``source``."""

    title: str
    points: tuple[tuple[float, float], ...]
    source: str


_ROWS = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
TYPICAL: Mapping[str, TypicalFullScale] = MappingProxyType(
    {
        kind: TypicalFullScale(
            row["title"], tuple((float(f), float(a)) for f, a in row["points"]), row["source"]
        )
        for kind, row in _ROWS.items()
    }
)
"""By the kind of an actuator, and of devices that are sound cards."""


def full_scale_of(
    actuator: Actuator,
) -> tuple[tuple[tuple[float, float], ...], str, str]:
    """Points, unit and source of an actuator's full scale: its own, or what is typical of its
    kind."""
    if actuator.full_scale:
        return actuator.full_scale, actuator.full_scale_unit, actuator.full_scale_source
    typical = TYPICAL[actuator.kind]
    return typical.points, "m/s^2", typical.source
