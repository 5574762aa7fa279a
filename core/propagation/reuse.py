"""What the propagation of a frame was computed from, so that an unchanged frame is not propagated
again."""

from __future__ import annotations

from typing import NamedTuple

from ..contacts.contact_set import ContactSet
from ..frozen import frozen
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


@frozen
class Propagated:
    """A propagated frame."""

    inputs: Inputs
    graph: HapticGraph
    propagation: Propagation
