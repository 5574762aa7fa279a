"""Temporary sources: active impact templates, attached to the two bodies that hit each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..scene.rules import ContactSettings, ImpactTemplates
from ..scene.values import HapticObject, Source, SourceKind
from ..signals import DEFAULT_IMPACT, Signal, impact_template
from .impacts import Impact
from .one_shots import Shot
from .rubbing import FrameRubbing

MOST_FRAMES = 4096
"""Number of frames whose impacts are stored."""

_UNMOVED = 1e-5
"""Difference of poses, relative to the largest coordinate, below which a body has not moved: poses
are float32."""


@frozen
class Templates:
    """Signals of impacts between ``objects``, by name, by the rules of ``settings``."""

    settings: ContactSettings
    objects: Mapping[str, HapticObject]

    def of(self, first: str, second: str, impact: Impact) -> tuple[Signal, float]:
        """The signal and the amplitude of an impact of two objects."""
        a = self.objects[first]
        b = self.objects[second]
        rule = self.settings.impact_rule((a.name, a.material), (b.name, b.material))
        template = rule.template
        if not isinstance(template, Signal):
            known = (
                template is ImpactTemplates.BY_MATERIAL and a.impact_material and b.impact_material
            )
            template = (
                impact_template(a.impact_material, b.impact_material) if known else DEFAULT_IMPACT
            )
        return rule.played(template, impact.amplitude, (first, second), impact.time)


@frozen
class ActiveImpact:
    """An impact and its source: the template's ``end`` [s], and the source's position in the frame
    of either body."""

    impact: Impact
    source: Source
    local: tuple[FloatArray, FloatArray]
    end: float

    @classmethod
    def of(
        cls, impact: Impact, bodies: tuple[str, str], local: tuple[FloatArray, FloatArray]
    ) -> ActiveImpact:
        """An impact of ``bodies``, by name, with the default signal."""
        first, second = bodies
        source = Source(
            name=f"impact of {first} and {second} at {impact.time:.4f} s",
            object=first,
            position=impact.positions[0],
            second_object=second,
            second_position=impact.positions[1],
            amplitude=impact.amplitude,
            kind=SourceKind.TEMPORARY,
            signal=DEFAULT_IMPACT,
            onset=impact.time,
        )
        return cls(impact, source, local, impact.time + DEFAULT_IMPACT.duration)

    def playing(self, templates: Templates) -> ActiveImpact:
        """This impact with its signal and amplitude by ``templates``."""
        signal, amplitude = templates.of(
            self.source.object, self.source.second_object or "", self.impact
        )
        if signal == self.source.signal and amplitude == self.source.amplitude:
            return self
        source = replace(self.source, signal=signal, amplitude=amplitude)
        return replace(self, source=source, end=self.impact.time + signal.duration)


@frozen
class FrameImpacts:
    """A snapshot of the temporary sources of one frame.

    Attributes:
        start: time at which the frame begins [s].
        sounding: the active impacts.
        poses: (k, 2, 3, 4) of both bodies of each of these impacts, then of each pair that slides
            or rolls, at the end of the frame.
        shots: the active one-shots.
        rubbed: what slides and rolls.
    """

    start: float
    sounding: tuple[ActiveImpact, ...]
    poses: FloatArray
    shots: tuple[Shot, ...] = ()
    rubbed: FrameRubbing | None = None

    def bodies_unmoved(self, transforms: FloatArray) -> bool:
        """Whether the struck and rubbing bodies are at the same ``poses`` in ``transforms`` (n, 4,
        4), those of all bodies."""
        poses = _touched_poses(self.sounding, self.rubbed, transforms)
        return bool(
            np.allclose(
                poses,
                self.poses,
                rtol=0.0,
                atol=_UNMOVED * max(1.0, float(np.abs(poses).max(initial=0.0))),
            )
        )


class ImpactSources:
    """The temporary sources of active impacts. ``delays``: longest delay of each at the listeners
    [s], by name."""

    def __init__(self) -> None:
        self.delays: Mapping[str, float] = {}
        self._sounding: list[ActiveImpact] = []

    def clear(self) -> None:
        """Drop all sources."""
        self.delays = {}
        self._sounding.clear()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sources, made from their objects and times."""
        return tuple(sounding.source.name for sounding in self._sounding)

    def snapshot(
        self,
        start: float,
        transforms: FloatArray,
        shots: tuple[Shot, ...],
        rubbed: FrameRubbing | None,
    ) -> FrameImpacts | None:
        """What `restore` needs of the frame that begins at ``start`` [s]; None if nothing is
        active.

        ``transforms`` (n, 4, 4): of the bodies at its end; ``shots``, ``rubbed``: see
        `FrameImpacts`.
        """
        if not self._sounding and not shots and rubbed is None:
            return None
        return FrameImpacts(
            start,
            tuple(self._sounding),
            _touched_poses(self._sounding, rubbed, transforms),
            shots,
            rubbed,
        )

    def restore(self, kept: FrameImpacts, templates: Templates) -> tuple[Impact, ...]:
        """Restore the impacts of a frame, with signals from ``templates``; return those that began
        in that frame."""
        self._sounding = [sounding.playing(templates) for sounding in kept.sounding]
        return tuple(
            sounding.impact for sounding in kept.sounding if sounding.impact.time > kept.start
        )

    def end_before(self, time: float) -> None:
        """Drop the sources whose templates have ended by ``time`` [s], including delays at
        listeners."""
        self._sounding = [
            item
            for item in self._sounding
            if item.end + self.delays.get(item.source.name, 0.0) > time
        ]

    def add(
        self,
        impacts: Sequence[Impact],
        names: Sequence[str],
        transforms: FloatArray,
        templates: Templates,
    ) -> None:
        """Add sources for ``impacts`` of bodies called ``names`` (n,) at rigid world ``transforms``
        (n, 4, 4)."""
        for impact in impacts:
            first, second = impact.objects
            local = (
                _to_body(transforms[first], impact.positions[0]),
                _to_body(transforms[second], impact.positions[1]),
            )
            self._sounding.append(
                ActiveImpact.of(impact, (names[first], names[second]), local).playing(templates)
            )

    def renumber(self, numbers: Mapping[Any, int]) -> None:
        """Number the bodies by their names; sources on those that have no number end."""
        self._sounding = [
            replace(item, impact=replace(item.impact, objects=(first, second)))
            for item in self._sounding
            if (first := numbers.get(item.source.object)) is not None
            and (second := numbers.get(item.source.second_object)) is not None
        ]

    @property
    def bodies(self) -> IntArray:
        """The bodies (2k,) of the k sources."""
        return np.array(
            [sounding.impact.objects for sounding in self._sounding], dtype=np.int64
        ).ravel()

    def sources(self, transforms: FloatArray) -> tuple[Source, ...]:
        """Return the sources, each at its place on both bodies."""
        if not self._sounding:
            return ()
        local = np.array(
            [place for sounding in self._sounding for place in sounding.local]
        ).reshape(-1, 3)
        placed = transforms[self.bodies]
        places = (
            ((placed[:, :3, :3] * local[:, None]).sum(axis=2) + placed[:, :3, 3])
            .reshape(-1, 2, 3)
            .tolist()
        )
        return tuple(
            sounding.source.moved(*place)
            for sounding, place in zip(self._sounding, places, strict=True)
        )


def _touched_poses(
    sounding: Sequence[ActiveImpact], rubbed: FrameRubbing | None, transforms: FloatArray
) -> FloatArray:
    pairs = [*(item.impact.objects for item in sounding), *(() if rubbed is None else rubbed.pairs)]
    return transforms[np.array(pairs, dtype=np.int64).reshape(-1, 2), :3]


def _to_body(transform: FloatArray, position: Sequence[float]) -> FloatArray:
    """Return a world position in the frame of a rigid transform (4, 4)."""
    return transform[:3, :3].T @ (np.asarray(position) - transform[:3, 3])
