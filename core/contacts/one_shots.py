"""One-shots: temporary sources for the triggers of sources, which move with these."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import repeat

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from ..scene.impact_rule import LEAST_PITCH
from ..scene.rules import ContactSettings
from ..scene.values import HapticObject, Source, SourceKind, TriggerKind
from ..signals import Signal
from .shapes import pose_matrix

Places = Mapping[str, FloatArray]
"""The current positions (3,) of objects' origins, by name."""
Hit = tuple[tuple[str, str], float, float]
"""An impact: objects, onset [s] and fraction of the full energy."""

_NEAR = 1e-6
"""Metres from the boundary of a region within which a point is in it: poses are float32."""


@frozen
class Shot:
    """A trigger of a ``source``, by name, at ``onset`` [s] with ``strength`` in [0, 1]; ``by``: the
    striking object, in which case strength is the fraction of the full energy. ``on``, ``object``:
    of the trigger."""

    source: str
    onset: float
    strength: float = 1.0
    by: str = ""
    on: TriggerKind = TriggerKind.TIMES
    object: str = ""

    @property
    def name(self) -> str:
        """The name of the temporary source."""
        return f"{self.source} at {self.onset:.4f} s"


def known_shots(source: Source, first: float = -math.inf, last: float = math.inf) -> list[Shot]:
    """The shots of triggers at given times, from ``first`` to ``last`` [s]."""
    shots = []
    for trigger in source.triggers or ():
        strengths = trigger.strengths or repeat(1.0)
        by = trigger.by or repeat("")
        shots += [
            Shot(source.name, *values)
            for values in zip(trigger.times, strengths, by, strict=False)
            if first <= values[0] <= last
        ]
    return shots


class OneShots:
    """The active shots. ``delays``: longest delay of each source at the listeners [s], by name."""

    def __init__(self) -> None:
        self.delays: Mapping[str, float] = {}
        self.sounding: tuple[Shot, ...] = ()
        self._found: list[Shot] = []
        self._restored: set[Shot] = set()
        # By source and number of its trigger: the last three positions of the object that may pass
        # the region, in the region's axes.
        self._paths: dict[tuple[str, int], list[FloatArray]] = {}
        self._levels: dict[str, float] = {}  # trigger values of the last frame, by source

    def clear(self) -> None:
        """Drop all shots and positions."""
        self.delays = {}
        self.sounding = ()
        self._found.clear()
        self._paths.clear()
        self._levels.clear()

    def restore(self, kept: Iterable[Shot], sources: Sequence[Source]) -> None:
        """Restore those shots ``kept`` of which ``sources`` still have the trigger."""
        known = {shot for source in sources for shot in known_shots(source)}
        now = {
            (source.name, trigger.on, trigger.object)
            for source in sources
            for trigger in source.triggers or ()
        }
        self._restored = {
            s
            for s in kept
            if (s in known if s.on is TriggerKind.TIMES else (s.source, s.on, s.object) in now)
        }
        self._found = list(self._restored)

    def follow(
        self,
        sources: Sequence[Source],
        start: float | None,
        time: float,
        places: Places,
        hits: Sequence[Hit],
    ) -> None:
        """Find the triggers between two frames.

        Args:
            sources: those with triggers.
            start: time of the frame before [s], None for the first one.
            time: of this frame [s].
            places: positions (3,) of objects in this frame, by name.
            hits: impacts since the frame before: names of both objects, time [s], and fraction of
                the full energy.
        """
        before = self._levels
        paths = self._paths
        self._levels = {}
        self._paths = {}
        for source, number, trigger in (
            (s, k, trigger) for s in sources for k, trigger in enumerate(s.triggers or ())
        ):
            found = Shot(source.name, time, on=trigger.on, object=trigger.object)
            if trigger.on is TriggerKind.HIT:
                blows = [
                    (names[names[0] == source.object], onset, energy)
                    for names, onset, energy in hits
                    if source.object in names
                ]
                self._found += [
                    replace(found, onset=onset, strength=energy, by=other)
                    for other, onset, energy in blows
                ]
            elif trigger.on is TriggerKind.LEVEL:
                self._levels[source.name] = trigger.value
                if start is not None and before.get(source.name, 1.0) <= 0 < trigger.value:
                    self._found.append(replace(found, strength=min(trigger.value, 1.0)))
            elif (
                trigger.on is TriggerKind.PASSING
                and (position := places.get(trigger.object)) is not None
            ):
                region = pose_matrix(trigger.pose)
                path = [
                    *paths.get((source.name, number), ())[-2:],
                    region[:3, :3].T @ (position - region[:3, 3]),
                ]
                self._paths[source.name, number] = path
                way = entry(path, np.array(trigger.size) / 2)
                if start is not None and way is not None:
                    self._found.append(replace(found, onset=start + way * (time - start)))

    def sources(
        self,
        sources: Sequence[Source],
        start: float,
        time: float,
        objects: Sequence[HapticObject],
        settings: ContactSettings,
    ) -> tuple[Source, ...]:
        """The active temporary sources.

        Args:
            sources: those with triggers.
            start: beginning of the frame [s].
            time: its end [s].
            objects: of the scene, whose materials rules may name.
            settings: with the rules of impacts.
        """
        material = (
            {item.name: item.material for item in objects}
            if self._found or any(source.triggers for source in sources)
            else {}
        )
        playing: dict[str, tuple[Shot, Source]] = {}
        for source in sources:
            template = source.emitted
            earliest = (
                start - template.duration / LEAST_PITCH - max(self.delays.values(), default=0.0)
            )
            shots = [
                *known_shots(source, earliest, time),
                *(shot for shot in self._found if shot.source == source.name),
            ]
            for shot in sorted(shots, key=lambda shot: (shot.onset, -shot.strength)):
                if shot.onset > time or shot.name in playing:
                    continue
                signal, strength = _played(shot, template, source.object, material, settings)
                if (
                    shot.onset + signal.duration + self.delays.get(shot.name, 0.0) > start
                    or shot in self._restored
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
                        replace(begun, signal=signal, amplitude=source.amplitude * strength),
                    )
        self.sounding = tuple(shot for shot, _ in playing.values())
        self._found = [shot for shot in self.sounding if shot.on is not TriggerKind.TIMES]
        self._restored.clear()
        return tuple(source for _, source in playing.values())


def _played(
    shot: Shot,
    template: Signal,
    carrier: str,
    material: Mapping[str, str],
    settings: ContactSettings,
) -> tuple[Signal, float]:
    """The signal and the amplitude of a shot.

    Args:
        shot: the shot.
        template: the signal of its source.
        carrier: the object of its source; an impact plays by the rule of this and the striking one.
        material: of the objects, by name.
        settings: with the rules of impacts.
    """
    if not shot.by:
        return template, shot.strength
    rule = settings.impact_rule(*((name, material.get(name, "")) for name in (carrier, shot.by)))
    return rule.played(template, shot.strength, (carrier, shot.by), shot.onset)


def entry(path: Sequence[FloatArray], half: FloatArray) -> float | None:
    """Time at which a point enters a box of edges 2 ``half`` (3,), as a fraction of the last
    interval of its ``path`` of positions (3,); None if it does not, or was inside before. Exact for
    constant acceleration over the last three places, which are equally far apart in time; whether
    it passes a box is decided on the straight line."""
    if (
        len(path) < 2
        or np.any(np.minimum(path[-2], path[-1]) > half + _NEAR)
        or np.any(np.maximum(path[-2], path[-1]) < -half - _NEAR)
    ):
        return None
    start = path[-2]
    way = path[-1] - path[-2]
    bend = way - (start - path[-3]) if len(path) > 2 else np.zeros(3)
    if (
        np.all(np.abs(start) <= half + _NEAR)
        or _first_inside(start, way, np.zeros(3), half) is None
    ):
        return None
    return _first_inside(start, way, bend, half) or _first_inside(start, way, np.zeros(3), half)


def _first_inside(
    start: FloatArray, way: FloatArray, bend: FloatArray, half: FloatArray
) -> float | None:
    """The least f in (0, 1] at which ``start + way f + bend f (f - 1) / 2`` is in a box."""
    parts = [1.0]
    for side in (-half, half):
        for square, slope, height in np.column_stack(
            [bend / 2, way - bend / 2, start - side]
        ).tolist():
            parts += [root for root in _roots(square, slope, height) if 0 < root <= 1]
    inside = (
        f
        for f in sorted(parts)
        if np.all(np.abs(start + way * f + bend * (f * (f - 1) / 2)) <= half + _NEAR)
    )
    return next(inside, None)


def _roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """Where ``a f^2 + b f + c`` is 0."""
    if b * b < 4 * a * c:
        return ()
    q = -(b + math.copysign(math.sqrt(b * b - 4 * a * c), b)) / 2
    return (*((q / a,) if a else ()), *((c / q,) if q else ()))
