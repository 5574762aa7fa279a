"""Temporary sources: the impact templates that still sound, each carried along by the two bodies that hit each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..scene.values import Source, SourceKind
from ..signals import Signal, impact_template
from .impacts import Impact


@dataclass(frozen=True, slots=True)
class _Sounding:
    """An impact's source between two ``bodies``, its position in the frame of either body, and the time [s] at which its template ends."""

    source: Source
    bodies: tuple[int, int]
    local: tuple[FloatArray, FloatArray]
    end: float


class ImpactSources:
    """The sources of impacts while their templates sound. Impacts play ``signal`` unless the materials of both bodies are known."""

    def __init__(self, signal: Signal) -> None:
        self._signal = signal
        self._sounding: list[_Sounding] = []

    def clear(self) -> None:
        """Drop all sources."""
        self._sounding.clear()

    def end_before(self, time: float) -> None:
        """Drop the sources whose templates have ended by ``time`` [s]."""
        self._sounding = [sounding for sounding in self._sounding if sounding.end > time]

    def add(self, impacts: Sequence[Impact], names: Sequence[str], transforms: FloatArray, materials: Mapping[str, str]) -> None:
        """Add sources for ``impacts`` of bodies called ``names`` (n,) at rigid world ``transforms`` (n, 4, 4).

        materials: by body, a key of `IMPACT_MATERIALS`.
        """
        for impact in impacts:
            first, second = (names[body] for body in impact.objects)
            known = first in materials and second in materials
            signal = impact_template(materials[first], materials[second]) if known else self._signal
            source = Source(
                name=f"impact of {first} and {second} at {impact.time:.4f} s",
                object=first,
                position=impact.positions[0],
                second_object=second,
                second_position=impact.positions[1],
                amplitude=impact.amplitude,
                kind=SourceKind.TEMPORARY,
                signal=signal,
                onset=impact.time,
            )
            on_first, on_second = (
                _to_body(transforms[body], position) for body, position in zip(impact.objects, impact.positions, strict=True)
            )
            self._sounding.append(_Sounding(source, impact.objects, (on_first, on_second), impact.time + signal.duration))

    def places(self, transforms: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the bodies (2k,) of the k sources and the world positions (2k, 3) of the sources on them."""
        if not self._sounding:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        bodies = np.array([sounding.bodies for sounding in self._sounding], dtype=np.int64).ravel()
        local = np.array([sounding.local for sounding in self._sounding]).reshape(-1, 3)
        placed = transforms[bodies]
        return bodies, (placed[:, :3, :3] * local[:, None]).sum(axis=2) + placed[:, :3, 3]

    def sources(self, transforms: FloatArray) -> tuple[Source, ...]:
        """Return the sources, each at its place on both bodies."""
        places = self.places(transforms)[1].reshape(-1, 2, 3).tolist()
        return tuple(sounding.source.moved(*place) for sounding, place in zip(self._sounding, places, strict=True))


def _to_body(transform: FloatArray, position: Sequence[float]) -> FloatArray:
    """Return a world position in the frame of a rigid transform (4, 4)."""
    return np.asarray(transform[:3, :3].T @ (np.asarray(position) - transform[:3, 3]))
