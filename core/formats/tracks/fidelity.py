"""What files keep of the tracks: how it is told, and its measurement where they keep samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...frozen import frozen
from .listener_tracks import Tracks

LOST_LIMIT = 0.25
"""Share of the power that may be lost before replacing a file needs consent."""
SILENT = 1e-12
"""Power relative to all power, or to full scale, that counts as none."""

Progress = Callable[[float], None] | None
"""Called with the share that is written; what it raises ends the writing."""


@frozen
class ListenerFidelity:
    """The measured losses of one listener.

    lost: share of its power that is not reproduced, None unless waves are kept. level: change of
    its level (dB). missing, invented: times (seconds) of onsets that are not played, and of onsets
    that are played without having been there.
    """

    name: str
    lost: float | None
    level: float
    missing: tuple[float, ...] = ()
    invented: tuple[float, ...] = ()


class Fidelity(Protocol):
    """The measured losses of all listeners, those who lose most first. ``is_poor``: replacing a
    file by this one needs consent."""

    @property
    def listeners(self) -> tuple[ListenerFidelity, ...]: ...
    @property
    def is_poor(self) -> bool: ...
    def sentences(self) -> Iterator[str]:
        """The losses, one sentence each."""
        ...


@frozen
class SampleFidelity:
    """The losses of files that keep samples. ``lost``: share of all power that is not
    reproduced."""

    lost: float
    listeners: tuple[ListenerFidelity, ...]

    @property
    def is_poor(self) -> bool:
        return self.lost > LOST_LIMIT

    def sentences(self) -> Iterator[str]:
        """The loss."""
        if self.lost:
            yield f"{percent(self.lost)} of the power, by rounding"


class SampleComparison:
    """Collects the losses while samples of ``tracks`` are written. ``add`` is called for each
    listener with consecutive pieces of the samples that are read back."""

    def __init__(self, tracks: Tracks, progress: Progress) -> None:
        self.tracks = tracks
        self._progress = progress
        self._done = [0] * len(tracks.listeners)
        self._powers = np.zeros((len(tracks.listeners), 3))

    def add(self, listener: int, decoded: FloatArray) -> None:
        """Add the decoded next samples (n,) of a listener."""
        first = self._done[listener]
        self._done[listener] = last = first + len(decoded)
        original = np.asarray(self.tracks.samples[listener, first:last], dtype=np.float64)
        signals = original, decoded, original - decoded
        self._powers[listener] += [np.dot(signal, signal) for signal in signals]
        if self._progress is not None:
            self._progress(sum(self._done) / max(self.tracks.samples.size, 1))

    def result(self) -> SampleFidelity | None:
        """The losses in all added samples; None for silence."""
        total, _, lost = self._powers.sum(axis=0).tolist()
        if total <= SILENT:
            return None
        names = [listener.name for listener in self.tracks.listeners]
        return SampleFidelity(
            lost / total, by_listener(names, self._powers, [()] * len(names), has_error=True)
        )


def by_listener(
    names: Sequence[str],
    powers: FloatArray,
    onsets: Sequence[tuple[tuple[float, ...], ...]],
    *,
    has_error: bool,
) -> tuple[ListenerFidelity, ...]:
    """The losses of each listener, those who lose most first; none of silent ones.

    Args:
        names: of the n listeners.
        powers: of the original, of the decoded signal and of the error, (n, 3).
        onsets: missing and invented ones.
        has_error: the files keep waves.
    """
    least = SILENT * float(powers[:, 0].sum())
    found = [
        ListenerFidelity(
            name, lost / max(own, least) if has_error else None, decibels(played, own), *changed
        )
        for name, (own, played, lost), changed in zip(names, powers.tolist(), onsets, strict=True)
        if own > least
    ]
    return tuple(sorted(found, key=lambda item: (item.lost or 0.0, abs(item.level)), reverse=True))


def decibels(power: float, reference: float) -> float:
    """A power relative to another, in dB."""
    return 10 * math.log10(max(power, SILENT * reference, 1e-300) / max(reference, 1e-300))


def percent(share: float) -> str:
    """A share as text."""
    return f"{share:.1%}" if share >= 0.001 else f"{100 * share:.1g} %"
