"""The signal of a source, from its properties."""

from __future__ import annotations

import math
from typing import Any

from bpy.app.translations import pgettext_iface as iface_

from ...core.scene.impact_rule import QUIETEST
from ...core.scene.values import Listener, Source, SourceKind
from ...core.signals import (
    DEFAULT_PERSISTENT,
    LONGEST,
    Automation,
    Loop,
    Signal,
    read_wav,
)
from ...core.signals.envelopes import Decay, Keyed
from ...core.signals.limits import MIN_SECONDS
from ..blender.paths import local_path
from ..blender.single_precision import shortest
from ..properties.signal_kinds import PLAIN
from .drawings import read_drawing
from .kept_signal import signal_of_text


def read_signal(properties: Any, frequency: Automation | None = None) -> Signal:
    """The signal of a source's properties, with an animated ``frequency`` if there is one. Raises
    ValueError if its file or drawing cannot be read."""
    hertz = shortest(properties.frequency) if frequency is None else frequency
    match properties.signal:
        case kind if kind in PLAIN:
            return PLAIN[kind].make(hertz)
        case "DRAWN":
            return read_drawing(properties.drawing).to_signal()
        case "BLAST":  # with its decay (1 - t / T) exp(-t / T)
            phase = shortest(properties.decay)
            if phase < MIN_SECONDS:
                raise ValueError(iface_("its signal has no end: set a decay time"))
            return Keyed(Automation((0.0, 10.0 * phase), (1.0, -9.0)))
        case "SOUND":
            kept = signal_of_text(properties.sound.kept)
            if kept is None:
                raise ValueError(
                    iface_(
                        "its signal is made of a sound, but none is converted: press Convert Sound"
                    )
                )
            return kept.of if properties.one_shot and isinstance(kept, Loop) else kept
    if not properties.filepath:
        raise ValueError(iface_("its signal is a WAV file, but none is chosen"))
    recorded = read_wav(local_path(properties.filepath, properties.id_data))
    return recorded if properties.one_shot else Loop(recorded)


def decaying(signal: Signal | None, seconds: float) -> Signal | None:
    """A persistent source's signal with an envelope that falls to 1/e in ``seconds``, without one
    if that is 0."""
    return (
        (signal or DEFAULT_PERSISTENT) * Decay(shortest(seconds))
        if seconds >= MIN_SECONDS
        else signal
    )


def played_once(signal: Signal | None) -> Signal:
    """Check and return the signal of a source that plays once per trigger. Raises ValueError if it
    is endless, too long or silent."""
    if signal is None or signal.duration == math.inf:
        raise ValueError(iface_("its signal has no end: set a decay time"))
    if signal.duration > LONGEST:
        raise ValueError(iface_("its signal lasts longer than a minute"))
    if not signal.peak >= QUIETEST:
        raise ValueError(iface_("its signal is silent"))
    return signal


def is_audible(item: Source | Listener, now: float, duration: float) -> bool:
    """False for a temporary source that is inactive in the frame of ``duration`` seconds that ends
    ``now``."""
    if not isinstance(item, Source) or item.kind is SourceKind.PERSISTENT:
        return True
    return item.onset <= now < item.onset + item.emitted.duration + duration
