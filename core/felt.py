"""Changes that let a listener feel what reaches it: of its gain, then of the amplitude and
frequency of its strongest source, then of materials; each only where those before are not
enough."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import field, replace
from functools import partial
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from .frozen import frozen
from .graph.haptic_graph import HapticGraph, ObjectTable
from .propagation import propagate
from .render.arrival import arriving
from .render.frame_result import FrameResult
from .render.history import still_samples
from .render.levels import margins
from .scene.choices import Mode
from .scene.coefficients import coefficients_of, transfer_coefficient
from .scene.values import Settings, Source
from .signals import Automation, Pulse, Sine

_ROUNDS = 4
"""Number of trials per change, because limiters and ceilings make margins deviate from the
gains."""
_NEAR = 0.1
"""Deviation [dB] up to which a margin counts as the wanted one."""
MOST_GAIN = 10.0
"""Largest gain of a listener, +20 dB: beyond, what others bring to it is raised too much."""
_TONES = tuple(40.0 * 2 ** (k / 3) for k in range(10))
"""Frequencies that a tone may get [Hz], 40 to 320 by thirds of an octave: outside, the skin feels
little."""
_FACTORS = tuple(math.exp(sign * 0.1 * 2**k) for k in range(6) for sign in (1, -1))
"""Factors that K of materials may get: with a function such as the paper's, both a larger and a
smaller K may pass on more."""
_LEAST_K, _MOST_K = 0.01, 0.99
_HALVINGS = 6


class ChangeKind(enum.StrEnum):
    """What is changed."""

    GAIN = "gain"
    AMPLITUDE = "amplitude"
    FREQUENCY = "frequency"
    MATERIAL = "material"


@frozen
class Change:
    """A value of the listener, source or material ``name`` that changes; of a material K = (1 -
    kappa) rho."""

    kind: ChangeKind
    name: str
    before: float
    after: float


@frozen
class Means:
    """What a plan may change.

    Attributes:
        listeners: names of those whose gain may change, up to `MOST_GAIN`.
        loud: names of the sources whose amplitude may change.
        tuned: names of the sources whose frequency may change.
        materials: names of the objects made of each material that may change, by its name.
    """

    listeners: frozenset[str] = frozenset()
    loud: frozenset[str] = frozenset()
    tuned: frozenset[str] = frozenset()
    materials: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))


@frozen
class Plan:
    """Changes that make a listener feel more or less.

    Attributes:
        listener: its name.
        before: its margin now [dB].
        after: its margin after the changes, or without any, what all means together could reach
            [dB].
        changes: in the order in which they were found.
        result: the frame after the changes.
    """

    listener: str
    before: float
    after: float
    changes: tuple[Change, ...]
    result: FrameResult


def plan(
    result: FrameResult, settings: Settings, listener: str, wanted: float, means: Means
) -> Plan:
    """The changes that bring the margin of a listener to ``wanted`` decibels, or as near as they
    can; none if all of them together leave it under the threshold of feeling.

    Args:
        result: the traced frame.
        settings: of propagation.
        listener: its name.
        wanted: the margin [dB].
        means: what may be changed.
    """
    column = [item.name for item in result.listeners].index(listener)
    before = margin_of(result, column)
    now, margin = result, before
    if math.isfinite(before) and (result.amplitudes[:, column] > 0).any():
        # Each takes the frame, the listener's number, the decibels that its margin lacks, and the
        # means; None where it can change nothing.
        steps = _with_gain, _with_amplitude, _with_frequency, partial(_with_material, settings)
        for step in steps:
            for _ in range(_ROUNDS):
                if margin >= wanted - _NEAR:
                    break
                tried = step(now, column, wanted - margin, means)
                if tried is None or (reached := margin_of(tried, column)) <= margin:
                    break
                now, margin = tried, reached
    changes = _changes(result, now, means) if margin > 0 else ()
    return Plan(listener, before, margin, changes, now if changes else result)


def margin_of(result: FrameResult, column: int) -> float:
    """The level of a listener above the threshold of feeling in the steady state of a frame
    [dB]."""
    one = slice(column, column + 1)
    return float(margins(still_samples(result)[one], result.sample_rate, result.listeners[one])[0])


def _with_gain(
    result: FrameResult, column: int, missing: float, means: Means
) -> FrameResult | None:
    """The frame with the listener's gain raised."""
    item = result.listeners[column]
    if item.name not in means.listeners or not 0 < item.gain < MOST_GAIN:
        return None
    raised = replace(item, gain=min(item.gain * 10 ** (missing / 20), MOST_GAIN))
    return replace(
        result, listeners=(*result.listeners[:column], raised, *result.listeners[column + 1 :])
    )


def _with_amplitude(
    result: FrameResult, column: int, missing: float, means: Means
) -> FrameResult | None:
    """The frame with the amplitude of the strongest source raised."""
    row = _strongest(result, column, means.loud)
    if row is None or not 0 < result.sources[row].amplitude < 1:
        return None
    source = result.sources[row]
    return _with_source(
        result, row, replace(source, amplitude=min(source.amplitude * 10 ** (missing / 20), 1.0))
    )


def _with_frequency(
    result: FrameResult, column: int, missing: float, means: Means
) -> FrameResult | None:
    """The frame with the strongest tunable source at another frequency: the one nearest to its
    present frequency that brings the ``missing`` [dB], or else the one that brings most. None
    without such a source."""
    row = _strongest(result, column, means.tuned)
    here = None if row is None else _frequency(result.sources[row])
    if row is None or here is None:
        return None
    source = result.sources[row]
    signal = cast(Any, result.sources[row].emitted)
    wanted = margin_of(result, column) + missing - _NEAR
    tones = sorted(_TONES, key=lambda tone: abs(math.log(tone / here)))
    tried = [
        _with_source(result, row, replace(source, signal=replace(signal, frequency=tone)))
        for tone in tones
    ]
    margins = [margin_of(other, column) for other in tried]
    return next(
        (other for other, margin in zip(tried, margins, strict=True) if margin >= wanted),
        tried[int(np.argmax(margins))],
    )


def _frequency(source: Source) -> float | None:
    """The frequency of a source that emits a steady tone or pulses [Hz]; None for other signals."""
    signal = source.emitted
    return (
        float(signal.frequency)
        if isinstance(signal, Sine | Pulse) and not isinstance(signal.frequency, Automation)
        else None
    )


def _with_material(
    settings: Settings, result: FrameResult, column: int, missing: float, means: Means
) -> FrameResult | None:
    """The frame in which all materials on the best path of the strongest source have another K, by
    the same factor: the one nearest to 1 that brings the ``missing`` [dB], or else the one that
    brings most.

    Args:
        settings: of propagation.
        result: the traced frame.
        column: number of the listener.
        missing: decibels that its margin lacks.
        means: what may be changed.
    """
    row = _strongest(result, column, frozenset(source.name for source in result.sources))
    if row is None or settings.mode not in (Mode.HT, Mode.SD):
        return None
    on_path = set(result.path_objects(row, column))
    names = {
        name
        for objects in means.materials.values()
        if not on_path.isdisjoint(objects)
        for name in objects
    }
    if not names:
        return None
    wanted = margin_of(result, column) + missing - _NEAR

    def at(factor: float) -> FrameResult:
        graph = _with_factor(result.graph, names, factor)
        found = propagate(graph, settings, sounding_only=True)
        return replace(
            result, graph=graph, propagation=found, amplitudes=arriving(result.sources, found)
        )

    best, most = result, -math.inf
    for factor in _FACTORS:
        tried = at(factor)
        margin = margin_of(tried, column)
        if margin >= wanted:
            return _nearest(at, column, wanted, factor)
        if margin > most:
            best, most = tried, margin
    return best


def _nearest(
    at: Callable[[float], FrameResult], column: int, wanted: float, enough: float
) -> FrameResult:
    """The frame of the factor nearest to 1 that brings the ``wanted`` margin [dB], as ``enough``
    does."""
    close, far = 0.0, math.log(enough)
    for _ in range(_HALVINGS):
        middle = (close + far) / 2
        if margin_of(at(math.exp(middle)), column) >= wanted:
            far = middle
        else:
            close = middle
    return at(math.exp(far))


def _with_factor(graph: HapticGraph, names: Collection[str], factor: float) -> HapticGraph:
    """The graph whose objects of these names have K times ``factor``, within bounds."""
    objects = list(graph.table.objects)
    for number, item in enumerate(objects):
        if item.name in names:
            k = transfer_coefficient(item.kappa, item.rho)
            k = min(max(k * factor, min(k, _LEAST_K)), max(k, _MOST_K))
            kappa, rho = coefficients_of(k, item.rho)
            objects[number] = replace(item, kappa=kappa, rho=rho)
    return replace(graph, table=ObjectTable.of(objects, graph.table.epsilon))


def _strongest(result: FrameResult, column: int, names: frozenset[str]) -> int | None:
    """The row of the source of these names that arrives with the highest amplitude."""
    rows = [
        row
        for row, source in enumerate(result.sources)
        if source.name in names and result.amplitudes[row, column] > 0
    ]
    return max(rows, key=lambda row: float(result.amplitudes[row, column]), default=None)


def _with_source(result: FrameResult, row: int, source: Source) -> FrameResult:
    sources = (*result.sources[:row], source, *result.sources[row + 1 :])
    return replace(result, sources=sources, amplitudes=arriving(sources, result.propagation))


def _changes(before: FrameResult, after: FrameResult, means: Means) -> tuple[Change, ...]:
    """The values that differ between two frames."""
    found = [
        Change(ChangeKind.GAIN, one.name, one.gain, other.gain)
        for one, other in zip(before.listeners, after.listeners, strict=True)
    ]
    for first, second in zip(before.sources, after.sources, strict=True):
        found.append(Change(ChangeKind.AMPLITUDE, first.name, first.amplitude, second.amplitude))
        if first.signal != second.signal:
            found.append(
                Change(
                    ChangeKind.FREQUENCY,
                    first.name,
                    *(_frequency(item) or 0.0 for item in (first, second)),
                )
            )
    index = before.graph.table.index()
    for name, objects in means.materials.items():
        items = [result.graph.table.objects[index[objects[0]]] for result in (before, after)]
        found.append(
            Change(
                ChangeKind.MATERIAL,
                name,
                *(transfer_coefficient(item.kappa, item.rho) for item in items),
            )
        )
    return tuple(
        change for change in found if abs(change.after - change.before) > 1e-4 * abs(change.before)
    )
