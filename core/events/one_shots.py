"""One-shots: temporary sources for the triggers of sources, which move with these."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import repeat

import numpy as np

from ..arrays import FloatArray
from ..contacts.shapes import pose_matrix
from ..contacts.tracker import FrameContacts
from ..frozen import frozen
from ..scene.impact_rule import LEAST_PITCH
from ..scene.rules import ContactSettings
from ..scene.values import Source, SourceKind, Trigger, TriggerKind
from ..signals import Signal
from .frame import Frame

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
    """The active shots.

    Attributes:
        delays: longest delay of each source at the listeners [s], by name.
        active: the shots that sound.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Drop all shots and positions."""
        self.delays: Mapping[str, float] = {}
        self.active: tuple[Shot, ...] = ()
        self._found: list[Shot] = []
        self._restored: tuple[frozenset[Shot], float | None] = frozenset(), None
        # By source and number of its trigger: the last three positions of the object that may pass
        # the region, in the region's axes.
        self._paths: dict[tuple[str, int], list[FloatArray]] = {}
        self._levels: dict[str, float] = {}  # trigger values of the last frame, by source

    def snapshot(self) -> tuple[Shot, ...]:
        """What `restore` needs of the last frame."""
        return self.active

    def restore(self, kept: Sequence[Shot], start: float | None, frame: Frame) -> None:
        """Return to those shots ``kept`` of a ``frame`` that begins at ``start`` [s] of which its
        sources still have the trigger."""
        known = {shot for source in frame.sources for shot in known_shots(source)}
        now = {
            (source.name, trigger.on, trigger.object)
            for source in frame.sources
            for trigger in source.triggers or ()
        }
        shots = frozenset(
            s
            for s in kept
            if (s in known if s.on is TriggerKind.TIMES else (s.source, s.on, s.object) in now)
        )
        self._restored = shots, start
        self._found = list(shots)

    def follow(
        self, frame: Frame, since: float | None, found: FrameContacts, settings: ContactSettings
    ) -> tuple[Source, ...]:
        """The temporary sources of a ``frame``: of its triggers after ``since`` [s], the time of
        the frame before (None without one), and of impacts ``found`` in it."""
        sources = [source for source in frame.sources if source.triggers]
        if not sources:
            self.clear()
            return ()
        before, self._levels = self._levels, {}
        paths, self._paths = self._paths, {}
        places = _places(frame)
        for source, number, trigger in (
            (s, k, trigger) for s in sources for k, trigger in enumerate(s.triggers or ())
        ):
            shot = Shot(source.name, frame.time, on=trigger.on, object=trigger.object)
            if trigger.on is TriggerKind.HIT:
                self._found += _struck(shot, source.object, frame.names, found)
            elif trigger.on is TriggerKind.LEVEL:
                self._levels[source.name] = trigger.value
                if since is not None and before.get(source.name, 1.0) <= 0 < trigger.value:
                    self._found.append(replace(shot, strength=min(trigger.value, 1.0)))
            elif (
                trigger.on is TriggerKind.PASSING
                and (position := places.get(trigger.object)) is not None
            ):
                path = [
                    *paths.get((source.name, number), ())[-2:],
                    _in_region(trigger, position),
                ]
                self._paths[source.name, number] = path
                way = entry(path, np.array(trigger.size) / 2)
                if since is not None and way is not None:
                    self._found.append(replace(shot, onset=since + way * (frame.time - since)))
        (restored, start), self._restored = self._restored, (frozenset(), None)
        if start is None:
            start = frame.time - frame.duration if since is None else since
        return self._sources(sources, start, frame, restored, settings)

    def _sources(
        self,
        sources: Sequence[Source],
        start: float,
        frame: Frame,
        restored: frozenset[Shot],
        settings: ContactSettings,
    ) -> tuple[Source, ...]:
        """The active temporary sources.

        Args:
            sources: those with triggers.
            start: beginning of the frame [s].
            frame: the frame.
            restored: shots that sound in it.
            settings: with the rules of impacts.
        """
        material = {item.name: item.material for item in frame.objects}
        playing: dict[str, tuple[Shot, Source]] = {}
        for source in sources:
            template = source.emitted
            earliest = (
                start - template.duration / LEAST_PITCH - max(self.delays.values(), default=0.0)
            )
            shots = [
                *known_shots(source, earliest, frame.time),
                *(shot for shot in self._found if shot.source == source.name),
            ]
            for shot in sorted(shots, key=lambda shot: (shot.onset, -shot.strength)):
                if shot.onset > frame.time or shot.name in playing:
                    continue
                signal, strength = _played(shot, template, source.object, material, settings)
                if (
                    shot.onset + signal.duration + self.delays.get(shot.name, 0.0) > start
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
                        replace(begun, signal=signal, amplitude=source.amplitude * strength),
                    )
        self.active = tuple(shot for shot, _ in playing.values())
        self._found = [shot for shot in self.active if shot.on is not TriggerKind.TIMES]
        return tuple(source for _, source in playing.values())


def _places(frame: Frame) -> dict[str, FloatArray]:
    """The positions (3,) of the objects' origins, by name."""
    if frame.transforms is not None:
        return dict(zip(frame.names, frame.transforms[:, :3, 3], strict=True))
    return {
        item.name: np.array(item.pose.position) for item in frame.objects if item.pose is not None
    }


def _struck(shot: Shot, carrier: str, names: Sequence[str], found: FrameContacts) -> list[Shot]:
    """A shot like ``shot`` for each impact ``found`` of its ``carrier``; ``names``: of the
    bodies."""
    pairs = [(tuple(names[row] for row in impact.objects), impact) for impact in found.impacts]
    return [
        replace(
            shot,
            onset=impact.time,
            strength=impact.amplitude,
            by=pair[pair[0] == carrier],
        )
        for pair, impact in pairs
        if carrier in pair
    ]


def _in_region(trigger: Trigger, position: FloatArray) -> FloatArray:
    """A position in the axes of the region of a trigger."""
    region = pose_matrix(trigger.pose)
    return region[:3, :3].T @ (position - region[:3, 3])


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
