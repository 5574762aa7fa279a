"""The signal of a source, from its properties."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ...core.scene.values import Listener, Source, SourceKind
from ...core.signals import DEFAULT_IMPACT, DEFAULT_PERSISTENT, Automation, Decay, Loop, Noise, Pulse, Signal, Sine, read_wav
from ...core.signals.limits import MIN_SECONDS
from ..blender.single_precision import shortest
from .drawings import read_drawing


def read_signal(properties: Any, frequency: Automation | None = None, envelope: Automation | None = None) -> Signal:
    """The signal of a source's properties, at an animated ``frequency`` and with an animated ``envelope`` where there are any. Raises
    ValueError where its file can't be read or its drawing is none."""
    hertz = shortest(properties.frequency) if frequency is None else frequency
    match properties.signal:
        case "SINE":
            return Sine(hertz)
        case "PULSE":
            return Pulse(hertz)
        case "NOISE":
            return Noise()
        case "DRAWN":
            return read_drawing(properties.drawing, envelope, frequency).to_signal()
    if not properties.filepath:
        raise ValueError(iface_("its signal is a WAV file, but none is chosen"))
    return Loop(read_wav(bpy.path.abspath(properties.filepath)))


def decaying(signal: Signal | None, seconds: float) -> Signal | None:
    """A persistent source's signal with an envelope that falls to 1/e in ``seconds``, without one where that is 0."""
    return (signal or DEFAULT_PERSISTENT) * Decay(shortest(seconds)) if seconds >= MIN_SECONDS else signal


def is_audible(item: Source | Listener, now: float, duration: float) -> bool:
    """False for a temporary source that is not heard in the frame of ``duration`` seconds that ends ``now``."""
    if not isinstance(item, Source) or item.kind is SourceKind.PERSISTENT:
        return True
    return item.onset <= now < item.onset + (item.signal or DEFAULT_IMPACT).duration + duration
