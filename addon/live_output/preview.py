"""The preview: the listeners' signals as sound through Blender's audio system.

Listeners on the left are heard on the left. Blocks are divided into
pieces that cross-fade, because Blender's sequencer sometimes starts a sound a sample too late.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...core.arrays import FloatArray
from ...core.devices.resampling import Resampler
from ...core.scene.body import stereo_gains
from ...core.scene.values import Listener
from ...core.signals import Signal
from ..properties.live_output import HapticLiveOutputProperties

RATE = 48_000
PIECE = 480
"""Samples from one piece to the next: 10 ms."""
_FADE = 96
_ENVELOPE = np.ones(PIECE + _FADE)
_ENVELOPE[:_FADE] = (np.arange(_FADE) + 0.5) / _FADE
_ENVELOPE[PIECE:] = _ENVELOPE[:_FADE][::-1]
LEAD = 0.060
"""Seconds between a block and its sound, so that a frame may be late without a gap."""
_LATE = 0.300
LONGEST_HEARD = 4.0
"""Longest part of a signal that `hear` plays [s]."""


OLDEST = (5, 2, 0)
"""Blender 5.0 and earlier play only the end of a piece that begins between two of their audio
buffers."""


class AudioUnavailable(OSError):
    """No audio output is available; the text gives the reason in one line."""


class _AudioStream:
    """A sequence that plays, and grows while it does."""

    def __init__(self, sample_rate: float) -> None:
        aud, device = _audio()
        self.sample_rate = sample_rate
        self._aud = aud
        self._sequence = aud.Sequence(channels=aud.CHANNELS_STEREO, rate=RATE, fps=RATE / PIECE)
        self.handle = device.play(self._sequence)
        self._resampler = Resampler(2, round(sample_rate), RATE)
        self._pending = np.zeros((2, 0))
        self._next = -1  # number of the next piece; none before the first
        self._entries: deque[tuple[int, Any]] = deque()

    def append(self, stereo: FloatArray) -> None:
        """The next samples, (2, n)."""
        position = float(self.handle.position)
        now = int(max(position, 0.0) * RATE / PIECE)
        if self._next < now or self._next > now + _LATE * RATE / PIECE:
            self._drop(now)
            self._next = now + round(LEAD * RATE / PIECE)
        samples = np.concatenate([self._pending, self._resampler.process(stereo)], axis=1)
        count = max((samples.shape[1] - _FADE) // PIECE, 0)
        for start in range(0, count * PIECE, PIECE):
            self._add(_ENVELOPE * samples[:, start : start + PIECE + _FADE])
        self._pending = samples[:, count * PIECE :]
        while self._entries and self._entries[0][0] < now - 1:
            self._sequence.remove(self._entries.popleft()[1])

    def silence(self) -> None:
        """Drop everything after the piece that is being played."""
        self._drop(int(max(float(self.handle.position), 0.0) * RATE / PIECE) + 2)
        self._next = -1
        self._pending = self._pending[:, :0]
        self._resampler.reset()

    def _add(self, piece: FloatArray) -> None:
        begin = self._next * PIECE / RATE
        sound = self._aud.Sound.buffer(np.ascontiguousarray(piece.T, dtype=np.float32), RATE)
        self._entries.append(
            (self._next, self._sequence.add(sound, begin, begin + 2 * PIECE / RATE, 0.0))
        )
        self._next += 1

    def _drop(self, first: int) -> None:
        """Remove the pieces from number ``first`` on."""
        while self._entries and self._entries[-1][0] >= first:
            self._sequence.remove(self._entries.pop()[1])


@dataclass(slots=True)
class _PreviewState:
    """Switch, volume and audio objects of the preview; ``heard``: the signal that is played by
    `hear`."""

    on: bool = False
    volume: float = 0.5
    stream: _AudioStream | None = None
    heard: Any = None


_state = _PreviewState()


def is_on() -> bool:
    """True if the preview is switched on."""
    return _state.on


def switch_on() -> None:
    """Begin to play frames as sound. Raises AudioUnavailable."""
    _audio()
    _state.on = True


def switch_off() -> None:
    """Stop the preview, and the signal of `hear`."""
    _state.on = False
    if _state.heard is not None:
        _state.heard.stop()
        _state.heard = None
    if _state.stream is not None:
        _state.stream.handle.stop()
        _state.stream = None


def adjust(settings: HapticLiveOutputProperties) -> None:
    """Take over a scene's settings."""
    _state.volume = settings.preview_volume
    if _state.stream is not None:
        _state.stream.handle.volume = _state.volume


def hear(signal: Signal) -> None:
    """Play a single signal, at most `LONGEST_HEARD` seconds of it; an earlier one ends. Raises
    AudioUnavailable."""
    aud, device = _device()
    samples = signal.sample(0, max(round(min(signal.duration, LONGEST_HEARD) * RATE), 1), RATE)
    samples[-_FADE:] *= _ENVELOPE[-min(_FADE, len(samples)) :]
    if _state.heard is not None:
        _state.heard.stop()
    _state.heard = device.play(aud.Sound.buffer(np.tanh(samples).astype(np.float32)[:, None], RATE))
    _state.heard.volume = _state.volume


def silence() -> None:
    """Drop what was sent so far."""
    if _state.stream is not None:
        _state.stream.silence()


def play(listeners: Sequence[Listener], samples: FloatArray, sample_rate: float) -> None:
    """Play the next block, ``samples`` (listeners, n). Does nothing while the preview is off."""
    if not _state.on:
        return
    if _state.stream is None or _state.stream.sample_rate != sample_rate:
        _state.stream = _AudioStream(sample_rate)
        _state.stream.handle.volume = _state.volume
    _state.stream.append(stereo_mix([item.body_part for item in listeners], samples))


def stereo_mix(body_parts: list[str], samples: FloatArray) -> FloatArray:
    """(listeners, n) as (2, n): left parts of the body on the left, right ones on the right, the
    rest on both, at equal power, and limited to [-1, 1]."""
    gains = np.array([stereo_gains(part) for part in body_parts]).reshape(-1, 2)
    return np.tanh(gains.T @ samples)


def _audio() -> tuple[Any, Any]:
    """Blender's audio module and its output, for the preview. Raises AudioUnavailable."""
    if bpy.app.version < OLDEST:
        raise AudioUnavailable(
            "the preview needs Blender 5.2: the audio system of earlier ones leaves out short "
            "sounds"
        )
    return _device()


def _device() -> tuple[Any, Any]:
    """Blender's audio module and its output. Raises AudioUnavailable."""
    try:
        import aud
    except ImportError:
        raise AudioUnavailable("this Blender is built without audio") from None
    try:
        device = aud.Device()
    except aud.error as error:
        raise AudioUnavailable(f"there is no audio device: {error}") from None
    if not device.rate > 0:
        raise AudioUnavailable("there is no audio device: see Preferences > System > Sound")
    return aud, device
