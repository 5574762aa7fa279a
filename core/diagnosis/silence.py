"""Why a listener feels nothing: one message per source, the loudest sources first."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cache

import numpy as np

from ..arrays import FloatArray
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Decibels, Hertz, Message, Seconds, sentence
from ..perception import dominant_frequency, sensation_level
from ..propagation.modes import nearest_listener
from ..render.arrival import are_unfelt
from ..render.frame_result import FrameResult
from ..render.history import still_samples
from ..render.levels import vibration_rms
from ..scene.values import Mode, Settings, Source
from .gaps import Surroundings, complete_graph, gap_message
from .losses import NEPER, loss_message, straight_line_message

_MOST_SOURCES = 8


def reasons(
    result: FrameResult,
    settings: Settings,
    listener: int,
    surroundings: Surroundings | None = None,
    muted: Collection[str] = (),
    recent: FloatArray | None = None,
    waiting: Sequence[str] = (),
) -> tuple[Message, ...]:
    """Why listener number ``listener`` of ``result`` feels nothing.

    Args:
        settings: those that ``result`` was traced with.
        surroundings: the bodies of the frame, to measure gaps between them.
        muted: names of muted sources, as opposed to those with amplitude 0.
        recent: (n,) the last samples of the listener at the result's rate; None for those of the
            frame.
        waiting: names of sources that have not been triggered.

    Returns:
        One message per cause; () if the listener feels something.
    """
    if not result.sources:
        return (
            Message.of(Cause.WAITING, waiting[0], source=waiting[0])
            if waiting
            else Message.of(Cause.NO_SOURCE),
        )
    arriving = [
        row
        for row in range(len(result.sources))
        if result.amplitudes[row, listener] > 0 and not _is_over(result, row)
    ]
    if arriving:
        return _arrival_messages(result, listener, arriving, recent)
    loudest = sorted(range(len(result.sources)), key=lambda row: -result.sources[row].amplitude)[
        :_MOST_SOURCES
    ]
    # Once, for the first source that needs it.
    graph = cache(lambda: complete_graph(result, settings, surroundings))
    found = [
        _source_message(result, settings, row, listener, muted)
        or _interruption(result, settings, row, listener, surroundings, graph)
        for row in loudest
    ]
    return tuple(dict.fromkeys(found))


def silence_of(
    last: FrameResult, settings: Settings, row: int, recent: FloatArray | None = None
) -> str:
    """Why listener number ``row`` feels nothing in a frame; ``recent``: its last samples."""
    why = reasons(last, settings, row, recent=recent)
    words = "; ".join(map(sentence, why)) or "no reason was found"
    return f"'{last.listeners[row].name}' feels nothing: {words}"


def _arrival_messages(
    result: FrameResult, listener: int, arriving: Sequence[int], recent: FloatArray | None
) -> tuple[Message, ...]:
    """Why the signals of the sources ``arriving`` at the listener are not felt."""
    item = result.listeners[listener]
    if item.gain == 0:
        return (Message.of(Cause.LISTENER_GAIN, item.name, listener=item.name),)
    if recent is None:
        recent = None if result.block is None else result.block[listener]
    if recent is None or len(recent) < 2:
        return (Message.of(Cause.NOT_RENDERED),)
    strongest = max(arriving, key=lambda row: float(result.amplitudes[row, listener]))
    name = result.sources[strongest].name
    gain = Decibels(NEPER * np.log(float(result.gains[strongest, listener])))
    unfelt = are_unfelt(result.sources, result.listeners, result.propagation)
    if unfelt[arriving, listener].all():  # so nothing was rendered
        recent = still_samples(result)[listener]
    if not np.any(recent):
        return (Message.of(Cause.PAUSE, name, source=name, gain=gain),)
    margin = float(sensation_level(recent, result.sample_rate, [item.device]))
    if margin > 0:
        return ()
    frequency = Hertz(dominant_frequency(recent, result.sample_rate, item.device))
    with np.errstate(divide="ignore"):
        level = Decibels(NEPER * np.log(vibration_rms(recent, result.sample_rate)))
    return (
        Message.of(
            Cause.NOT_FELT,
            name,
            source=name,
            gain=gain,
            level=level,
            frequency=frequency,
            margin=Decibels(-margin),
        ),
    )


def _interruption(
    result: FrameResult,
    settings: Settings,
    row: int,
    listener: int,
    surroundings: Surroundings | None,
    graph: Callable[[], HapticGraph],
) -> Message:
    """Why nothing of a source arrives.

    Args:
        result: the traced frame.
        settings: of propagation.
        row: number of the source.
        listener: number of the listener.
        surroundings: poses and shapes of the bodies, None where they are unknown.
        graph: returns the complete graph.
    """
    if settings.mode in (Mode.MD, Mode.MN):
        return straight_line_message(result, settings, row, listener)
    return loss_message(graph(), settings, row, listener) or gap_message(
        result, graph(), row, listener, surroundings
    )


def _source_message(
    result: FrameResult, settings: Settings, row: int, listener: int, muted: Collection[str]
) -> Message | None:
    """Why a source emits nothing, or nothing for this listener; None if neither holds.

    Args:
        result: the traced frame.
        settings: of propagation.
        row: number of the source.
        listener: number of the listener.
        muted: names of the sources that are muted.
    """
    source = result.sources[row]
    if source.amplitude == 0:
        return Message.of(
            Cause.MUTED if source.name in muted else Cause.ZERO_AMPLITUDE,
            source.name,
            source=source.name,
        )
    if _is_over(result, row):
        return Message.of(
            Cause.FINISHED, source.name, source=source.name, end=Seconds(_signal_end(source))
        )
    if settings.mode is Mode.SD:
        nearest = int(np.flatnonzero(nearest_listener(result.graph)[row])[0])
        if nearest != listener:
            name = result.listeners[nearest].name
            return Message.of(Cause.NEAREST_LISTENER_ONLY, name, listener=name, source=source.name)
    return None


def _is_over(result: FrameResult, row: int) -> bool:
    """True if the signal of source ``row`` ended before the frame."""
    return _signal_end(result.sources[row]) <= result.time


def _signal_end(source: Source) -> float:
    """Time [s] after which the source is silent."""
    return source.onset + source.emitted.duration
