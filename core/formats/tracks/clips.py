"""Tracks as clips to play: at one gain that uses the range, of those listeners who feel something.

The gain leaves 1 dB below full scale, the headroom of EBU R 128 for the largest peak.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import BoolArray
from ...frozen import frozen
from ...perception import sensation_level
from ...render.levels import LEVEL_SECONDS
from .listener_tracks import ListenerTrack, Tracks

HEADROOM = 1.0
"""Between the largest peak and full scale [dB]."""


@frozen(eq=False)
class Clips:
    """``tracks`` at a ``gain`` [dB] that is the same for all, and the names of the listeners that
    are ``left_out``: nothing of theirs reaches the threshold of feeling at the traced level."""

    tracks: Tracks
    gain: float
    left_out: tuple[str, ...]

    def sentences(self) -> tuple[str, ...]:
        """What was changed, one sentence each."""
        said = [f"gain of all listeners: {self.gain:+.2f} dB"] if self.gain else []
        if self.left_out:
            said.append(f"left out, below the threshold of feeling: {', '.join(self.left_out)}")
        return tuple(said)


def clips_of(tracks: Tracks) -> Clips:
    """The tracks as clips. Where nobody feels anything, all listeners stay."""
    felt = _felt(tracks)
    rows = np.flatnonzero(felt if felt.any() else np.ones_like(felt)).tolist()
    peak = max(
        (float(np.abs(block[rows]).max()) for block in tracks.blocks() if block.size), default=0.0
    )
    # Of hundredths of a decibel, so that the number that is told is the gain itself.
    gain = math.floor(-100 * (20 * math.log10(peak) + HEADROOM)) / 100 if peak else 0.0
    left_out = tuple(item.name for row, item in enumerate(tracks.listeners) if row not in rows)
    return Clips(_amplified(tracks, rows, 10 ** (gain / 20)), gain, left_out)


def _felt(tracks: Tracks) -> BoolArray:
    """Of which listeners (l,) a piece of `LEVEL_SECONDS` reaches the threshold of their device."""
    devices = [listener.device for listener in tracks.listeners]
    size = max(round(LEVEL_SECONDS * tracks.sample_rate), 2)
    felt = np.zeros(len(devices), dtype=np.bool_)
    for first in range(0, tracks.count, size // 2):
        rows = np.flatnonzero(~felt)
        if not len(rows):
            break
        piece = np.asarray(tracks.samples[rows, first : first + size], dtype=np.float64)
        piece = np.pad(piece, [(0, 0), (0, size - piece.shape[1])])
        felt[rows] = sensation_level(piece, tracks.sample_rate, [devices[row] for row in rows]) >= 0
    return felt


def _amplified(tracks: Tracks, rows: Sequence[int], factor: float) -> Tracks:
    """The tracks of the listeners ``rows`` times a factor, in a temporary file, to save memory."""
    kept = tempfile.TemporaryFile(prefix="haptic-tracks-")  # noqa: SIM115
    for block in tracks.blocks():
        kept.write((np.float64(factor) * block[rows].T).astype("<f4").tobytes())
    kept.flush()
    shape = tracks.count, len(rows)
    samples = np.memmap(kept, "<f4", "r", shape=shape) if tracks.count else np.zeros(shape)
    return replace(
        tracks,
        listeners=tuple(_amplified_impacts(tracks.listeners[row], factor) for row in rows),
        samples=samples.T,
    )


def _amplified_impacts(listener: ListenerTrack, factor: float) -> ListenerTrack:
    return replace(listener, impacts=np.minimum(listener.impacts * [1.0, factor], [np.inf, 1.0]))
