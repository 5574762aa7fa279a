"""The result of one step of the tracer: plain data for panels, overlays, recordings and devices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..arrays import FloatArray
from ..contacts.contact_set import ContactSet
from ..contacts.one_shots import Shot
from ..contacts.tracker import Impact
from ..graph.haptic_graph import HapticGraph
from ..message import Message
from ..propagation import Propagation, objects_on
from ..scene.values import Listener, Source


@dataclass(frozen=True, slots=True)
class Sounding:
    """Sources, listeners and propagation at the end of a block, at ``time`` [s]."""

    time: float
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    propagation: Propagation


@dataclass(frozen=True, slots=True)
class FrameResult:
    """One traced frame.

    ``objects``: names in the order that ``contacts`` and ``graph`` number them. ``sources`` (s) include the temporary ones made by
    impacts; ``gains`` (s, l) include the sources' amplitudes. ``block`` (l, n): the rendered samples of the frame's interval, the first
    at sample number ``first_sample`` of ``sample_rate``; None where nothing was rendered. ``milliseconds`` per stage: read, broad,
    narrow, graph, propagate, mix. ``statistics``: counts of what was done and what was skipped. ``before``: what sounded at the start of
    the block; None where there was none before it. ``shots``: of sources with triggers, which sound as temporary ones of their names.
    """

    number: int
    time: float
    objects: tuple[str, ...]
    contacts: ContactSet
    graph: HapticGraph
    propagation: Propagation
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    gains: FloatArray
    impacts: tuple[Impact, ...]
    block: FloatArray | None
    first_sample: int
    sample_rate: float
    milliseconds: Mapping[str, float]
    statistics: Mapping[str, int | float]
    warnings: tuple[Message, ...] = ()
    before: Sounding | None = None
    shots: tuple[Shot, ...] = ()

    def path_objects(self, source: int, listener: int) -> tuple[str, ...]:
        """The objects of the best path from a source to a listener, () where there is none."""
        return objects_on(self.graph, self.propagation.best_path.get((source, listener), ()))
