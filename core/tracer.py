"""The haptic tracer: the paper's algorithm, once per frame.

    detect collisions -> update graph -> for each source: propagate -> for each listener: mix,
    render

Live preview, bake, export, command line and tests use the same tracer, so that their results agree.
"""

from __future__ import annotations

from hashlib import sha256
from time import perf_counter

from .collisions import CollisionDetector
from .contacts.settings import ContactSettings
from .events.frame import Frame
from .graph.haptic_graph import ObjectTable, build_graph
from .propagation import propagate
from .propagation.best_path import Kept
from .propagation.reuse import Inputs, Propagated
from .render.arrival import arriving
from .render.frame_result import FrameResult, Sounding
from .render.mixdown import Mixdown
from .render.renderer import SAMPLE_RATE, sample_index
from .unchanged import Unchanged

__all__ = ["Frame", "Tracer"]


class Tracer:
    """Steps through the frames of a scene. The arguments are those of `CollisionDetector`;
    ``sample_rate`` [Hz] is that of the samples."""

    def __init__(
        self,
        contact_settings: ContactSettings | None = None,
        sample_rate: float = SAMPLE_RATE,
        lazy: bool = False,
        paths: bool = False,
    ) -> None:
        self.sample_rate = sample_rate
        self.collisions = CollisionDetector(contact_settings or ContactSettings(), lazy, paths)
        self._table = Unchanged(ObjectTable.of)
        self._propagated: Propagated | None = None
        self._trees: Kept = {}
        self._mixdown = Mixdown(sample_rate)
        self._time: float | None = None
        self._start = 0.0  # of the last frame

    def reset(self) -> None:
        """Drop contacts, velocities and active signals."""
        self._time = None
        self.collisions.reset()
        self._mixdown.reset()

    def checksum(self) -> str:
        """Checksum of the state that later frames depend on, except samples. Tracers with equal
        checksums continue with bit-identical results."""
        gains = b"" if self._propagated is None else self._propagated.propagation.gain.tobytes()
        return sha256(repr(self._time).encode() + gains + self.collisions.history()).hexdigest()

    def pass_by(self, frame: Frame) -> None:
        """Follow the bodies to a frame that continues the last one and is not traced: what strikes
        on the way there belongs to the next frame."""
        self.collisions.pass_by(frame, self._table(frame.objects, frame.settings.epsilon))

    def step(self, frame: Frame) -> FrameResult:
        """Trace one frame. Raises ValueError, which names the object, if a designer's expression
        gives no valid gain.

        A retrace, of the frame that was traced last after an edit (`CollisionDetector.is_retrace`),
        renders no samples; later frames continue from those of its first trace.
        """
        retrace = frame.restore and self.collisions.is_retrace(frame)
        if not retrace and (
            not frame.continuous or (self._time is not None and frame.time <= self._time)
        ):
            self.reset()
        table = self._table(frame.objects, frame.settings.epsilon)
        collisions = self.collisions.detect(frame, table, self._time, retrace)
        if not retrace:
            self._start = next(
                t for t in (collisions.start, self._time, frame.time) if t is not None
            )
        watch = _Stopwatch(dict(collisions.milliseconds))
        sources = (
            tuple(source for source in frame.sources if source.triggers is None)
            + collisions.sources
        )
        inputs = Inputs(
            table, collisions.contacts, sources, frame.listeners, frame.settings, collisions.frames
        )
        propagated = self._propagate(inputs, watch)
        self.collisions.set_delays(
            propagated.propagation.longest_delays([source.name for source in sources])
        )
        block = None
        if not retrace:
            end = Sounding(frame.time, sources, frame.listeners, propagated.propagation)
            block = self._mixdown.render(self._time, end, frame.heard)
        watch.lap("mix")
        self._time = frame.time
        graph, propagation = propagated.graph, propagated.propagation
        return FrameResult(
            number=frame.number,
            time=frame.time,
            objects=table.names,
            contacts=collisions.contacts,
            graph=graph,
            propagation=propagation,
            sources=sources,
            listeners=frame.listeners,
            amplitudes=arriving(sources, propagation),
            impacts=collisions.impacts,
            block=block,
            first_sample=sample_index(self._start, self.sample_rate),
            sample_rate=self.sample_rate,
            milliseconds=watch.milliseconds,
            statistics={**collisions.statistics, **propagation.statistics},
            warnings=(*collisions.warnings, *propagation.warnings),
            before=None if retrace else self._mixdown.before,
            shots=collisions.shots,
        )

    def _propagate(self, inputs: Inputs, watch: _Stopwatch) -> Propagated:
        """Return graph and gains; those of the last frame if its inputs were the same."""
        known = self._propagated
        if known is None or known.inputs != inputs:
            gravity = self.collisions.settings.gravity
            graph = build_graph(
                inputs.table,
                inputs.contacts,
                inputs.sources,
                inputs.listeners,
                inputs.frames,
                gravity,
                None if known is None else known.graph,
            )
            watch.lap("graph")
            known = self._propagated = Propagated(
                inputs, graph, propagate(graph, inputs.settings, True, self._trees)
            )
        else:
            watch.lap("graph")
        watch.lap("propagate")
        return known


class _Stopwatch:
    """Stopwatch that adds the milliseconds between laps to given ones."""

    def __init__(self, milliseconds: dict[str, float]) -> None:
        self.milliseconds = milliseconds
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        now = perf_counter()
        self.milliseconds[stage] = 1000 * (now - self._last)
        self._last = now
