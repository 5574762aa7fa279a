"""Causes of silence that lie with a source or with the mode."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..message import Cause, Message, Seconds
from ..propagation.modes import nearest_listener
from ..render.frame_result import FrameResult
from ..scene.values import Mode, Settings, Source, SourceKind
from ..signals import DEFAULT_IMPACT, DEFAULT_PERSISTENT


def source_message(result: FrameResult, settings: Settings, row: int, listener: int, muted: Collection[str]) -> Message | None:
    """Why source ``row`` emits nothing, or nothing for this listener; None where neither holds."""
    source = result.sources[row]
    if source.amplitude == 0:
        return Message.of(Cause.MUTED if source.name in muted else Cause.ZERO_AMPLITUDE, source.name, source=source.name)
    if is_over(result, row):
        return Message.of(Cause.FINISHED, source.name, source=source.name, end=Seconds(_signal_end(source)))
    if settings.mode is Mode.SD or (settings.mode is Mode.HT and settings.localise == 1):
        nearest = int(np.flatnonzero(nearest_listener(result.graph)[row])[0])
        if nearest != listener:
            name = result.listeners[nearest].name
            cause = Cause.NEAREST_LISTENER_ONLY if settings.mode is Mode.SD else Cause.LOCALISED
            return Message.of(cause, name, listener=name, source=source.name)
    return None


def is_over(result: FrameResult, row: int) -> bool:
    """True where the signal of source ``row`` has ended before the frame."""
    return _signal_end(result.sources[row]) <= result.time


def _signal_end(source: Source) -> float:
    """Time [s] after which the source is silent."""
    default = DEFAULT_PERSISTENT if source.kind is SourceKind.PERSISTENT else DEFAULT_IMPACT
    return source.onset + (source.signal or default).duration
