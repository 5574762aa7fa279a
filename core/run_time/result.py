"""What propagates in a scene, by the names of sources and listeners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..diagnosis.doubts import doubts
from ..diagnosis.silence import reasons, silence_of
from ..formats.scene.recording import Recording, traced
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from ..message import sentence
from ..propagation import Propagation, objects_on
from ..render.arrival import signal_gains
from ..render.frame_result import FrameResult
from ..scene.references import require_known
from ..scene.values import HapticScene, Source


@frozen
class Pair:
    """A source and a listener: the ``gain`` of the paths between them, the objects on the best
    ``path``, and ``why`` nothing arrives, in sentences."""

    gain: float
    path: tuple[str, ...]
    why: tuple[str, ...]


@frozen(eq=False, repr=False)
class Result:
    """What propagates in a ``scene`` with contacts: its ``graph`` and, as arrays, the
    ``propagation``. The pair of a source and a listener is found by their names."""

    scene: HapticScene
    graph: HapticGraph
    propagation: Propagation

    def __getitem__(self, names: tuple[str, str]) -> Pair:
        """A source and a listener. Raises ValueError for unknown names.

        >>> scene.result()["drill", "hand"]
        Pair(gain=0.75, path=('bench',), why=())
        """
        rows = [
            {name: row for row, name in enumerate(known)}
            for known in (
                [source.name for source in self.scene.sources],
                [listener.name for listener in self.scene.listeners],
            )
        ]
        for kind, known, name in zip(("source", "listener"), rows, names, strict=True):
            require_known(name, known, kind, (kind,))
        row, column = (known[name] for known, name in zip(rows, names, strict=True))
        source = self.scene.sources[row]
        return Pair(
            float(signal_gains(self.scene.sources, self.propagation)[row, column]),
            objects_on(self.graph, self.propagation.best_path.get((row, column), ())),
            tuple(map(sentence, reasons(self._frame((source,)), self.scene.settings, column)))
            if source.amplitude * self.propagation.gain[row, column] == 0
            else (),
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """What in the scene is probably not meant, and why listeners feel nothing, in sentences.

        >>> scene.result().warnings
        ()
        """
        amplitudes = np.array([source.amplitude for source in self.scene.sources])
        reached = (amplitudes[:, None] * self.propagation.gain > 0).any(axis=0)
        unreached = np.flatnonzero(~reached).tolist()
        frame = self._frame(self.scene.sources) if unreached else None
        return (
            *doubts(self.scene),
            *map(sentence, self.propagation.warnings),
            *(silence_of(frame, self.scene.settings, row) for row in unreached if frame),
        )

    def _frame(self, sources: tuple[Source, ...]) -> FrameResult:
        """The first frame of these sources alone."""
        return next(traced(replace(self.scene, sources=sources), Recording.still(1.0), 8000.0))

    def __repr__(self) -> str:
        return (
            f"<Result of {len(self.scene.sources)} sources, {len(self.scene.listeners)} listeners>"
        )
