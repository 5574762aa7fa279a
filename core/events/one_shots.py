"""One-shots: temporary sources for the triggers of sources, which move with these."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import repeat

from ..frozen import frozen
from ..scene.values import Source, SourceKind
from .frame import Frame


@frozen
class Shot:
    """A trigger of a ``source``, by name, at ``onset`` [s] with ``strength`` in [0, 1]; ``risen``:
    by a value that has risen."""

    source: str
    onset: float
    strength: float = 1.0
    risen: bool = False

    @property
    def name(self) -> str:
        """The name of the temporary source."""
        return f"{self.source} at {self.onset:.4f} s"


def known_shots(source: Source, first: float = -math.inf, last: float = math.inf) -> list[Shot]:
    """The shots of triggers at given times, from ``first`` to ``last`` [s]."""
    shots = []
    for trigger in source.triggers or ():
        strengths = trigger.strengths or repeat(1.0)
        shots += [
            Shot(source.name, time, strength)
            for time, strength in zip(trigger.times, strengths, strict=False)
            if first <= time <= last
        ]
    return shots


class OneShots:
    """The active shots.

    Attributes:
        delays: longest delay of each source at the listeners [s], by name.
        active: the shots that sound.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Drop all shots."""
        self.delays: Mapping[str, float] = {}
        self.active: tuple[Shot, ...] = ()
        self._found: list[Shot] = []
        self._restored: tuple[frozenset[Shot], float | None] = frozenset(), None
        self._levels: dict[str, float] = {}  # trigger values of the last frame, by source

    def snapshot(self) -> tuple[Shot, ...]:
        """What `restore` needs of the last frame."""
        return self.active

    def restore(self, kept: Sequence[Shot], start: float | None, frame: Frame) -> None:
        """Return to those shots ``kept`` of a ``frame`` that begins at ``start`` [s] of which its
        sources still have the trigger."""
        known = {shot for source in frame.sources for shot in known_shots(source)}
        rising = {
            source.name
            for source in frame.sources
            for trigger in source.triggers or ()
            if trigger.value is not None
        }
        shots = frozenset(
            shot for shot in kept if (shot.source in rising if shot.risen else shot in known)
        )
        self._restored = shots, start
        self._found = list(shots)

    def follow(self, frame: Frame, since: float | None) -> tuple[Source, ...]:
        """The temporary sources of a ``frame``: of its triggers after ``since`` [s], the time of
        the frame before, None without one."""
        sources = [source for source in frame.sources if source.triggers]
        if not sources:
            self.clear()
            return ()
        before, self._levels = self._levels, {}
        for source in sources:
            for trigger in source.triggers or ():
                if trigger.value is None:
                    continue
                self._levels[source.name] = trigger.value
                if since is not None and before.get(source.name, 1.0) <= 0 < trigger.value:
                    strength = min(trigger.value, 1.0)
                    self._found.append(Shot(source.name, frame.time, strength, True))
        (restored, start), self._restored = self._restored, (frozenset(), None)
        if start is None:
            start = frame.time - frame.duration if since is None else since
        return self._sources(sources, start, frame, restored)

    def _sources(
        self,
        sources: Sequence[Source],
        start: float,
        frame: Frame,
        restored: frozenset[Shot],
    ) -> tuple[Source, ...]:
        """The active temporary sources.

        Args:
            sources: those with triggers.
            start: beginning of the frame [s].
            frame: the frame.
            restored: shots that sound in it.
        """
        playing: dict[str, tuple[Shot, Source]] = {}
        for source in sources:
            template = source.emitted
            earliest = start - template.duration - max(self.delays.values(), default=0.0)
            shots = [
                *known_shots(source, earliest, frame.time),
                *(shot for shot in self._found if shot.source == source.name),
            ]
            for shot in sorted(shots, key=lambda shot: (shot.onset, -shot.strength)):
                if shot.onset > frame.time or shot.name in playing:
                    continue
                if (
                    shot.onset + template.duration + self.delays.get(shot.name, 0.0) > start
                    or shot in restored
                ):
                    begun = replace(
                        source,
                        name=shot.name,
                        kind=SourceKind.TEMPORARY,
                        onset=shot.onset,
                        triggers=None,
                    )
                    playing[shot.name] = (
                        shot,
                        replace(begun, signal=template, amplitude=source.amplitude * shot.strength),
                    )
        self.active = tuple(shot for shot, _ in playing.values())
        self._found = [shot for shot in self.active if shot.risen]
        return tuple(source for _, source in playing.values())
