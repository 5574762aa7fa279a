"""The best path to a listener, object by object."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bpy.types import Scene

from ...core.diagnosis.losses import object_losses
from ...core.graph.distance_only import distance_only
from ...core.scene.values import Mode, Source
from ..session.derived import Derived, Latest
from ..session.sessions import Traced
from .watched import active_name, watched


@dataclass(frozen=True, slots=True)
class Hop:
    """An object on a path, with its contact to the next one: loss [dB] and distance [m]."""

    object: str
    loss: float
    distance: float


@dataclass(frozen=True, slots=True)
class ListenerPath:
    """The path from a source to a listener. ``gain``: that of all paths together, including the source's amplitude; ``amplitude``: the
    source's, in decibels; ``hops``: of the best path, () in the modes without paths."""

    listener: str
    source: Source
    gain: float
    amplitude: float
    hops: tuple[Hop, ...]

    @property
    def best_gain(self) -> float:
        """Gain [dB] of the best path, including the source's amplitude."""
        return self.amplitude - sum(hop.loss for hop in self.hops)


def listener_path(traced: Traced, ends: tuple[str, str], before: ListenerPath | None = None) -> ListenerPath | None:
    """Computed on the worker: the best path to a listener from a source, or from the strongest one if that does not reach it; None if there
    is none. ``ends``: the names of listener and source."""
    listener, chosen = ends
    result = traced.result
    names = [item.name for item in result.listeners]
    if listener not in names:
        return None  # it was one in the frame before
    column = names.index(listener)
    reaching = [row for row in range(len(result.sources)) if result.gains[row, column] > 0]
    if not reaching:
        return None
    named = [row for row in reaching if result.sources[row].name == chosen]
    row = named[0] if named else max(reaching, key=lambda row: float(result.gains[row, column]))
    nodes = result.propagation.best_path.get((row, column), ())
    hops: tuple[Hop, ...] = ()
    if nodes and traced.settings.mode in (Mode.HT, Mode.SD):
        graph = distance_only(result.graph) if traced.settings.mode is Mode.SD else result.graph
        hops = tuple(Hop(*loss) for loss in object_losses(graph.in_band(graph.sources[row].band), nodes))
    source = result.sources[row]
    return ListenerPath(listener, source, float(result.gains[row, column]), 20 * math.log10(source.amplitude), hops)


_PATH: Derived[tuple[str, str], ListenerPath | None] = Derived(listener_path, every_frame=True)


def path_of(scene: Scene) -> Latest[ListenerPath | None] | None:
    """The path to the watched listener, from the active object if that is a source; without waiting."""
    listener = watched(scene)
    return _PATH.latest(scene, (listener, active_name())) if listener else None
