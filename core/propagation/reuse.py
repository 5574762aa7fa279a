"""What the propagation of a frame was computed from, so that an unchanged frame is not propagated
again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from ..contacts.contact_set import ContactSet
from ..contacts.tracker import STILL
from ..graph.haptic_graph import HapticGraph, ObjectTable
from ..graph.object_frames import ObjectFrames
from ..scene.values import Listener, Settings, Source
from .result import Propagation


class Inputs(NamedTuple):
    """All that graph and gains of a frame depend on; ``frames``: where the objects lie, None where
    the strategy does not ask for it."""

    table: ObjectTable
    contacts: ContactSet
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings
    frames: ObjectFrames | None

    def same_as(self, other: Inputs, still: float = STILL) -> bool:
        """Whether nothing differs but positions, by at most ``still`` metres."""
        if (
            self.table is not other.table
            or self.contacts is not other.contacts
            or self.settings != other.settings
        ):
            return False
        if not _same(self.sources, other.sources, still) or not _same(
            self.listeners, other.listeners, still
        ):
            return False
        return _same_frames(self.frames, other.frames, still)


@dataclass(frozen=True, slots=True)
class Propagated:
    """A propagated frame."""

    inputs: Inputs
    graph: HapticGraph
    propagation: Propagation


def _same(
    first: Sequence[Source | Listener], second: Sequence[Source | Listener], still: float
) -> bool:
    return len(first) == len(second) and all(
        a is b or _same_item(a, b, still) for a, b in zip(first, second, strict=True)
    )


def _same_frames(one: ObjectFrames | None, other: ObjectFrames | None, still: float) -> bool:
    """Whether neither centres [m] nor the ends of axes of a metre differ by more than ``still``."""
    if one is None or other is None:
        return one is other
    pairs = (one.centre, other.centre), (one.axes, other.axes)
    return all(np.allclose(a, b, rtol=0.0, atol=still, equal_nan=True) for a, b in pairs)


def _same_item(a: Source | Listener, b: Source | Listener, still: float) -> bool:
    for key in _FIELDS[type(a)]:
        one, other = getattr(a, key), getattr(b, key)
        if one is other:
            continue
        if not key.endswith("position") or one is None or other is None:
            if one != other:
                return False
        elif any(abs(x - y) > still for x, y in zip(one, other, strict=True)):
            return False
    return True


_FIELDS = {cls: tuple(f.name for f in fields(cls)) for cls in (Source, Listener)}
