"""The loss of one material and the gain of one contact, from recordings of an event at its source
and at a listener.

The transfer between the recordings is the logarithm of ``|S_xy / S_xx|`` (the estimator H1 of
Bendat and Piersol, *Random Data*), averaged over half-overlapping windows. Along the best path it
is a sum: the known terms of the other objects, ``-s alpha(f) d`` of the fitted objects, whose
damping is s times that of their material, and a constant c of the contact. Least squares with the
coherence of each frequency as its weight gives s and c; their standard deviations show what the
recordings do not determine.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Decibels, Message
from ..propagation import objects_on, propagate
from ..scene.bands import BAND_COUNT, BAND_EDGES
from ..scene.coefficients import transfer_coefficient
from ..scene.functions import Physical
from ..scene.values import Settings
from ..signals.wav import read_wav
from .wishes import DECIBELS

RATE = 4000.0
"""Sample rate [Hz] at which recordings are compared."""
COHERENT = 0.5
"""Coherence below which a frequency is left out."""
AUDIBLE_LOSS = 3.0
"""Least loss of the object at the highest frequency for which its damping is determined [dB]."""
SURE = 0.2
"""Relative standard deviation up to which a value counts as determined."""
_WINDOW = 0.5


@frozen
class Transfer:
    """``level`` (n,): natural logarithm of the gain at ``frequency`` (n,) [Hz], ``coherence`` (n,)
    in [0, 1], over ``windows``."""

    frequency: FloatArray
    level: FloatArray
    coherence: FloatArray
    windows: int

    @property
    def used(self) -> BoolArray:
        """(n,) the frequencies that are coherent."""
        return self.coherence >= COHERENT

    @property
    def deviation(self) -> FloatArray:
        """(n,) standard deviation of ``level``."""
        return np.asarray(
            np.sqrt((1 - self.coherence) / (2 * np.maximum(self.coherence, 1e-9) * self.windows))
            + 1e-6
        )


class Recordings:
    """Spectra of two recordings of rate `RATE`, made simultaneously at the source and at the
    listener, averaged over windows."""

    def __init__(self, source: FloatArray, listener: FloatArray) -> None:
        self._samples = source, listener
        self._size = round(_WINDOW * RATE)
        count = min(len(source), len(listener))
        self.starts = range(0, count - self._size + 1, self._size // 2)
        if len(self.starts) < 4:
            raise ValueError(
                f"the recordings are too short: {count / RATE:.2f} s together, at least "
                f"{2.5 * _WINDOW:g} s are needed"
            )

    def steps(self) -> Iterator[None]:
        """Add one window per step."""
        window = np.hanning(self._size)
        bins = self._size // 2 + 1
        self._own = np.zeros(bins)
        self._other = np.zeros(bins)
        self._cross = np.zeros(bins, dtype=np.complex128)
        for start in self.starts:
            first, second = (
                np.fft.rfft(x[start : start + self._size] * window) for x in self._samples
            )
            self._own += np.abs(first) ** 2
            self._other += np.abs(second) ** 2
            self._cross += first.conj() * second
            yield

    def transfer(self) -> Transfer:
        """The transfer over the windows added so far."""
        frequency = np.fft.rfftfreq(self._size, 1 / RATE)
        cross = np.abs(self._cross)
        used = (
            (frequency >= BAND_EDGES[0])
            & (frequency <= BAND_EDGES[-1])
            & (self._own > self._own.max() * 1e-12)
            & (cross > 0)
        )
        own = self._own[used]
        other = self._other[used]
        cross = cross[used]
        coherence = np.minimum(cross**2 / np.maximum(own * other, 1e-300), 1 - 1e-9)
        return Transfer(frequency[used], np.log(cross / own), coherence, len(self.starts))


def read_recordings(source: Path, listener: Path) -> Recordings:
    """Recordings from two WAV files, their channels averaged."""
    return Recordings(read_wav(source, RATE).samples, read_wav(listener, RATE).samples)


@frozen
class Question:
    """The parameters to fit: the loss of ``objects``, which share a material, and the gain of the
    ``contact`` between two objects, on the path from a source to a listener. Without
    ``calibrated``, the recordings differ by an unknown factor, and no contact can be fitted."""

    source: str
    listener: str
    objects: tuple[str, ...]
    contact: tuple[str, ...] = ()
    calibrated: bool = True


@frozen
class FittedLoss:
    """``damping``: multiple of the material's; ``contact``: logarithm of its gain; each with its
    standard deviation. ``k``: the resulting (1 - kappa) rho of the objects, and ``gain`` of the
    contact, in [0, 1]. ``before``, ``after``: root mean square difference of model and recording
    [dB] for the current and for the fitted values. ``bands`` (bands, 4): measured transfer, the
    model's before and after [dB], and coherence; NaN for bands without coherent frequencies.
    ``doubts``: parameters that the recordings do not determine."""

    damping: float
    damping_error: float
    contact: float
    contact_error: float
    k: float
    gain: float
    before: float
    after: float
    bands: FloatArray
    doubts: tuple[Message, ...]


@frozen
class _Levels:
    """Logarithms of gains (n,) by frequency along a path: of its ``known`` parts, and of the
    ``contact`` before the fit. ``damped`` (n,): damping of the fitted objects by their material,
    over ``inside`` metres. ``crossed``: the contact is on the path."""

    known: FloatArray
    damped: FloatArray
    contact: FloatArray
    inside: float
    crossed: bool


def fit(graph: HapticGraph, measured: Transfer, asked: Question) -> FittedLoss:
    """Fit the model to the measured transfer. Raises ValueError if names or the path do not match
    ``asked``."""
    if asked.contact and not asked.calibrated:
        raise ValueError(
            "recordings that are not calibrated alike don't tell the gain of a contact"
        )
    path = _path(graph, asked)
    numbers = [graph.table.index()[name] for name in asked.objects]
    item = graph.table.objects[numbers[0]]
    function, name = item.propagation, item.name
    if not isinstance(function, Physical):
        raise ValueError(
            f"{name}: only objects with the function physical have a loss that depends on frequency"
        )
    levels = _levels(graph, path, numbers, asked.contact, measured.frequency)
    if levels.inside == 0:
        raise ValueError(f"{name}: the path leads through {', '.join(objects_on(graph, path))}")
    if asked.contact and not levels.crossed:
        raise ValueError(
            f"{' and '.join(asked.contact)}: the path does not lead through a contact between them"
        )
    now = math.log(transfer_coefficient(item.kappa, item.rho)) / math.log(function.material_k)
    values, errors, alone = _solved(measured, levels, bool(asked.contact) or not asked.calibrated)
    contact, contact_error = (float(values[1]), float(errors[1])) if asked.contact else (0.0, 0.0)
    damping = max(float(values[0]), 0.0)
    gain = min(1.0, math.exp(contact))
    models = np.stack(
        [
            levels.known + levels.contact - now * levels.damped,
            levels.known
            + (math.log(gain) if asked.contact else levels.contact)
            - damping * levels.damped,
        ]
    )
    used = measured.used
    weights = measured.deviation**-2 * measured.used
    if not asked.calibrated:
        models += np.average(measured.level - models, axis=1, weights=weights)[:, None]
    before, after = (
        np.sqrt(np.average((measured.level - models) ** 2, axis=1, weights=weights)) * DECIBELS
    )
    doubts = _doubts(
        name,
        values,
        errors,
        float(levels.damped[used].max(initial=0.0)),
        alone,
        bool(asked.contact),
    )
    k = function.material_k**damping
    bands = _by_band(measured, models)
    return FittedLoss(
        float(values[0]),
        float(errors[0]),
        contact,
        contact_error,
        k,
        gain,
        float(before),
        float(after),
        bands,
        doubts,
    )


def _path(graph: HapticGraph, asked: Question) -> tuple[int, ...]:
    """The best path from the source to the listener. Raises ValueError for unknown names, or if
    nothing arrives."""
    sources = [source.name for source in graph.sources]
    for names, wanted, what in (
        (sources, (asked.source,), "source"),
        (graph.listeners, (asked.listener,), "listener"),
        (graph.table.names, (*asked.objects, *asked.contact), "object"),
    ):
        for name in wanted:
            if name not in names:
                raise ValueError(f"{name}: there is no such {what}; {what}s: {', '.join(names)}")
    path = propagate(graph, Settings(threshold=0.0)).best_path.get(
        (sources.index(asked.source), graph.listeners.index(asked.listener))
    )
    if path is None:
        raise ValueError(f"nothing leads from {asked.source} to {asked.listener}")
    return path


def _levels(
    graph: HapticGraph,
    path: Sequence[int],
    fitted: Sequence[int],
    contact: Sequence[str],
    frequency: FloatArray,
) -> _Levels:
    """The gains of a path by frequency.

    Args:
        graph: the scene.
        path: nodes of the path.
        fitted: numbers of the objects whose loss is fitted.
        contact: names of the objects of the contact whose gain is fitted, or none.
        frequency: (f,) [Hz].
    """
    known, damped, free = np.zeros((3, len(frequency)))
    inside, crossed = 0.0, False
    band = _bands_of(frequency)
    for a, b in pairwise(path):
        number = int(graph.node_object[a])
        if graph.partner[a] == b:
            passed = np.full(len(frequency), -graph.transmission_loss[graph.contact[a]])
            if graph.contact_band_gains is not None:
                passed += np.log(np.maximum(graph.contact_band_gains[graph.contact[a]], 1e-300))[
                    band
                ]
            if contact and {
                graph.table.names[int(graph.node_object[node])] for node in (a, b)
            } == set(contact):
                crossed = True
                weight = math.log(graph.weight[graph.contact[a]])
                free = free + passed - weight
                known = known + weight
            else:
                known += passed
            continue
        item = graph.table.objects[number]
        distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
        function = item.propagation
        if isinstance(function, Physical):
            if graph.table.spreading is not None:
                ends = graph.ends(np.array([a]), np.array([b]))
                known -= graph.table.spreading.cost(number, np.array([distance]), ends)
            alpha = np.array([function.material_damping(f) for f in frequency]) * distance
            scale = math.log(transfer_coefficient(item.kappa, item.rho)) / math.log(
                function.material_k
            )
            damped, known = (
                (damped + alpha, known) if number in fitted else (damped, known - scale * alpha)
            )
            inside += distance if number in fitted else 0.0
        else:
            known += np.log(graph.table.gain(number, np.array(distance)))
            decays = function.band_decays(item.kappa, item.rho)
            gains = function.band_gains()
            known -= np.array(decays or (0.0,) * BAND_COUNT)[band] * distance
            known += np.log(np.maximum(np.array(gains or (1.0,) * BAND_COUNT), 1e-300))[band]
    return _Levels(known, damped, free, inside, crossed)


def _solved(
    measured: Transfer, levels: _Levels, with_offset: bool
) -> tuple[FloatArray, FloatArray, bool]:
    """The damping and, ``with_offset``, the logarithm of a gain: both, their standard deviations,
    and whether they are not separable."""
    used = measured.used
    if used.sum() < 4:
        raise ValueError("the recordings have nothing in common: no frequency is coherent")
    columns = [-levels.damped[used], np.ones(int(used.sum()))][: 2 if with_offset else 1]
    known = levels.known if with_offset else levels.known + levels.contact
    deviation = measured.deviation[used]
    weighed = np.stack(columns, axis=1) / deviation[:, None]
    aimed = (measured.level - known)[used] / deviation
    size = np.maximum(np.linalg.norm(weighed, axis=0), 1e-300)
    values = np.linalg.lstsq(weighed / size, aimed, rcond=1e-12)[0] / size
    noise = max(
        1.0, float(((weighed @ values - aimed) ** 2).sum()) / max(len(aimed) - len(values), 1)
    )
    covariance = np.linalg.pinv((weighed / size).T @ (weighed / size), rcond=1e-12) * noise
    alone = np.linalg.matrix_rank(weighed / size, tol=1e-6) < len(values)
    return values, np.sqrt(np.diag(covariance)) / size, bool(alone)


def _doubts(
    name: str, values: FloatArray, errors: FloatArray, most: float, alone: bool, with_contact: bool
) -> tuple[Message, ...]:
    """Warnings of parameters that the recordings do not determine.

    Args:
        name: of the object.
        values: as of `_solved`.
        errors: their standard deviations.
        most: loss of the path in the object at the highest frequency, for a damping of 1 [Np].
        alone: whether the recordings can't tell damping and gain apart.
        with_contact: whether the gain is that of a contact.
    """
    doubts = []
    loss = DECIBELS * float(values[0]) * most
    if alone:
        doubts.append(Message.of(Cause.FIT_ALIKE, object=name))
    elif loss < AUDIBLE_LOSS:
        doubts.append(Message.of(Cause.FIT_SMALL, object=name, loss=f"{max(loss, 0.0):.1f}"))
    elif errors[0] > SURE * abs(values[0]):
        doubts.append(
            Message.of(
                Cause.FIT_UNCERTAIN, object=name, percent=f"{100 * errors[0] / abs(values[0]):.0f}"
            )
        )
    if with_contact and DECIBELS * errors[1] > 1.0:
        doubts.append(Message.of(Cause.FIT_CONTACT_UNCERTAIN, error=Decibels(DECIBELS * errors[1])))
    if with_contact and values[1] > 3 * errors[1] + 0.1:
        doubts.append(Message.of(Cause.FIT_AMPLIFIES, gain=Decibels(DECIBELS * values[1])))
    return tuple(doubts)


def _by_band(measured: Transfer, models: FloatArray) -> FloatArray:
    """The ``bands`` of `FittedLoss`."""
    rows = np.full((BAND_COUNT, 4), math.nan)
    band = _bands_of(measured.frequency)
    for number in range(BAND_COUNT):
        inside = (band == number) & measured.used
        if inside.any():
            levels = np.stack([measured.level, *models])[:, inside] * DECIBELS
            rows[number, :3] = np.average(levels, axis=1, weights=measured.deviation[inside] ** -2)
        if (band == number).any():
            rows[number, 3] = measured.coherence[band == number].mean()
    return rows


def _bands_of(frequency: FloatArray) -> IntArray:
    return np.clip(np.searchsorted(BAND_EDGES, frequency, side="right") - 1, 0, BAND_COUNT - 1)
