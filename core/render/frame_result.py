"""The result of one step of the tracer: plain data for panels, overlays, recordings and devices."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..contacts.contact_set import ContactSet
from ..contacts.impacts import Impact
from ..events.one_shots import Shot
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from ..message import Message
from ..propagation import Propagation, objects_on
from ..scene.values import Listener, Source


@frozen
class Sounding:
    """Sources, listeners and propagation at the end of a block, at ``time`` [s]."""

    time: float
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    propagation: Propagation


@frozen
class FrameResult:
    """One traced frame.

    ``objects``: names in the order that ``contacts`` and ``graph`` number them. ``sources`` (s)
    include the temporary ones made by impacts; ``amplitudes`` (s, l) are those that arrive, see
    `core.render.arrival`. ``block`` (l, n): the samples of the frame's interval, the first at
    sample number ``first_sample`` of ``sample_rate``; None if nothing was rendered.
    ``milliseconds`` per stage: read, broad, narrow, graph, propagate, mix. ``statistics``: counts
    of computed and skipped work. ``before``: the state at the start of the block; None for the
    first one. ``shots``: those of sources with triggers, which are temporary sources of their
    names.
    """

    number: int
    time: float
    objects: tuple[str, ...]
    contacts: ContactSet
    graph: HapticGraph
    propagation: Propagation
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    amplitudes: FloatArray
    impacts: tuple[Impact, ...]
    block: FloatArray | None
    first_sample: int
    sample_rate: float
    milliseconds: Mapping[str, float]
    statistics: Mapping[str, int | float]
    warnings: tuple[Message, ...] = ()
    before: Sounding | None = None
    shots: tuple[Shot, ...] = ()

    @property
    def gains(self) -> FloatArray:
        """Gain (s, l) from each source to each listener, without the source's amplitude; 0 for
        sources of amplitude 0, which are not traced."""
        own = np.array([source.amplitude for source in self.sources]).reshape(-1, 1)
        return np.asarray(
            np.divide(self.amplitudes, own, out=np.zeros_like(self.amplitudes), where=own > 0)
        )

    def arrivals(self) -> FloatArray:
        """Where on each listener vibration arrives, (l, 2): horizontally from 0 at the wearer's
        left to 1, vertically from 0 at the top to 1, of the listener's sphere seen from the front,
        for a wearer who faces -Y. The mean over sources by power; (0.5, 0.5) if nothing arrives."""
        graph = self.graph
        places = np.full((len(self.listeners), 2), 0.5)
        for column, (listener, node) in enumerate(
            zip(self.listeners, graph.listener_nodes.tolist(), strict=True)
        ):
            paths = [
                (row, self.propagation.best_path.get((row, column), ()))
                for row in np.flatnonzero(self.amplitudes[:, column]).tolist()
            ]
            entries = [(row, nodes[-2]) for row, nodes in paths if len(nodes) > 1]
            if entries and listener.radius > 0:
                rows, nodes = np.array(entries).T
                power = (self.amplitudes[rows, column] / self.amplitudes[rows, column].max()) ** 2
                away = (
                    power @ (graph.node_position[nodes] - graph.node_position[node]) / power.sum()
                )
                local = graph.frames.axes[graph.node_object[node]].T @ away / listener.radius
                places[column] = np.clip((1 - local[[0, 2]]) / 2, 0.0, 1.0)
        return places

    def path_objects(self, source: int, listener: int) -> tuple[str, ...]:
        """The objects of the best path from a source to a listener, () if there is none."""
        return objects_on(self.graph, self.propagation.best_path.get((source, listener), ()))
