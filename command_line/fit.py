"""``haptic-tracing fit``: the loss of one object and one contact from two recordings of an event, at its source and at a listener.

The transfer between the recordings is the logarithm of ``|S_xy / S_xx|`` (the estimator H1 of Bendat and Piersol, *Random Data*), averaged
over half-overlapping windows. Along the best path it is a sum: what is known of the other objects, ``-s alpha(f) d`` of the object that is
fitted, which damps by s times what its material does, and a number c of the contact. Both follow by least squares, each frequency weighed
by its coherence; their standard deviations say what the recordings do not determine.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import FloatArray
from ..core.contacts.scene_contacts import contacts_of_scene
from ..core.formats.io.strict_json import read_json
from ..core.formats.scene.scene_json import current_document, scene_of, write_scene
from ..core.formats.tracks import wav
from ..core.graph.haptic_graph import HapticGraph, graph_of_scene
from ..core.propagation import objects_on, propagate
from ..core.scene.bands import BAND_COUNT, BAND_EDGES
from ..core.scene.coefficients import coefficients_of, transfer_coefficient
from ..core.scene.functions import Constant, Physical
from ..core.scene.values import HapticScene, Settings
from . import say, warn_of_unknown

DECIBELS = 20 / math.log(10)
LONGEST = 120.0
"""Seconds that are read of a recording."""
COHERENT = 0.5
"""Coherence below which a frequency is left out."""
AUDIBLE_LOSS = 3.0
"""Decibels that the object must take at the highest frequency for its loss to be determined."""
SURE = 0.2
"""Relative standard deviation up to which a value counts as determined."""
_WINDOW = 0.5


@dataclass(frozen=True, slots=True)
class Transfer:
    """``level`` (n,): natural logarithm of the gain at ``frequency`` (n,) [Hz], ``coherence`` (n,) in [0, 1], over ``windows``."""

    frequency: FloatArray
    level: FloatArray
    coherence: FloatArray
    windows: int


@dataclass(frozen=True, slots=True)
class Fit:
    """``damping``: times what the material does; ``contact``: logarithm of its gain; each with its standard deviation. ``left``: root mean
    square of what the fit leaves [dB], ``before`` the same of the scene as it was. ``doubts``: what the recordings do not determine."""

    damping: float
    damping_error: float
    contact: float
    contact_error: float
    before: float
    left: float
    doubts: tuple[str, ...]


def transfer(source: FloatArray, listener: FloatArray, rate: float) -> Transfer:
    """The transfer from samples at a source to those at a listener."""
    size = round(_WINDOW * rate)
    count = min(len(source), len(listener))
    starts = range(0, count - size + 1, size // 2)
    if len(starts) < 4:
        raise ValueError(f"the recordings are too short: {count / rate:.2f} s together, at least {2.5 * _WINDOW:g} s are needed")
    window = np.hanning(size)
    spectra = [np.fft.rfft(np.stack([x[k : k + size] for k in starts]) * window, axis=1) for x in (source, listener)]
    own, other = ((np.abs(x) ** 2).mean(axis=0) for x in spectra)
    cross = (spectra[0].conj() * spectra[1]).mean(axis=0)
    frequency = np.fft.rfftfreq(size, 1 / rate)
    used = (frequency >= BAND_EDGES[0]) & (frequency <= BAND_EDGES[-1]) & (own > own.max() * 1e-12) & (np.abs(cross) > 0)
    coherence = np.abs(cross[used]) ** 2 / np.maximum(own[used] * other[used], 1e-300)
    return Transfer(frequency[used], np.log(np.abs(cross[used]) / own[used]), np.minimum(coherence, 1 - 1e-9), len(starts))


def path_levels(graph: HapticGraph, path: tuple[int, ...], fitted: int, frequency: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Along a path: the logarithm of the gain (n,) at each frequency without the damping of the object ``fitted``, that damping (n,) as its
    material has it, and the metres inside that object."""
    known, damped, inside = np.zeros(len(frequency)), np.zeros(len(frequency)), 0.0
    band = np.clip(np.searchsorted(BAND_EDGES, frequency, side="right") - 1, 0, BAND_COUNT - 1)
    for a, b in pairwise(path):
        if graph.partner[a] == b:
            contact = graph.contact[a]
            known -= graph.transmission_loss[contact]
            if graph.contact_band_gains is not None:
                known += np.log(np.maximum(graph.contact_band_gains[contact], 1e-300))[band]
            continue
        number = int(graph.node_object[a])
        item, distance = graph.table.objects[number], float(graph.node_distances(np.array([a]), np.array([b]))[0])
        function = item.propagation
        if isinstance(function, Physical):
            known += math.log(float(function.spreading(np.array(distance))))
            alpha = np.array([function.material_damping(f) for f in frequency])
            scale = math.log(transfer_coefficient(item.kappa, item.rho)) / math.log(function.material_k)
            damped, known = (damped + alpha * distance, known) if number == fitted else (damped, known - scale * alpha * distance)
            inside += distance if number == fitted else 0.0
        else:
            known += np.log(graph.table.gain(number, np.array(distance)))
            decays, gains = function.band_decays(item.kappa, item.rho), function.band_gains()
            known -= np.array(decays or (0.0,) * BAND_COUNT)[band] * distance
            known += np.log(np.maximum(np.array(gains or (1.0,) * BAND_COUNT), 1e-300))[band]
    return known, damped, inside


def fit(measured: Transfer, known: FloatArray, damped: FloatArray, now: float, with_contact: bool) -> Fit:
    """Damping (times the material's; ``now``: as the scene has it) and contact that bring the model nearest to what was measured."""
    used = measured.coherence >= COHERENT
    if used.sum() < 4:
        raise ValueError("the recordings have nothing in common: no frequency is coherent")
    columns = [-damped[used], np.ones(int(used.sum()))][: 2 if with_contact else 1]
    matrix, target = np.stack(columns, axis=1), (measured.level - known)[used]
    coherence = measured.coherence[used]
    deviation = np.sqrt((1 - coherence) / (2 * coherence * measured.windows)) + 1e-6
    weighed, aimed = matrix / deviation[:, None], target / deviation
    size = np.maximum(np.linalg.norm(weighed, axis=0), 1e-300)
    values = np.linalg.lstsq(weighed / size, aimed, rcond=1e-12)[0] / size
    noise = max(1.0, float(((weighed @ values - aimed) ** 2).sum()) / max(len(aimed) - len(values), 1))
    covariance = np.linalg.pinv((weighed / size).T @ (weighed / size), rcond=1e-12) * noise
    errors = np.sqrt(np.diag(covariance)) / size
    alone = np.linalg.matrix_rank(weighed / size, tol=1e-6) < len(values)
    value, error = float(values[0]), float(errors[0])
    loss = DECIBELS * value * float(damped[used].max(initial=0.0))
    doubts = []
    if alone:
        doubts.append("the object takes the same of all frequencies, so it can't be told from the contact")
    elif loss < AUDIBLE_LOSS:
        doubts.append(f"the object takes {max(loss, 0.0):.1f} dB at most: its loss is not determined below {AUDIBLE_LOSS:g} dB")
    elif error > SURE * abs(value):
        doubts.append(f"the loss of the object is uncertain by {100 * error / abs(value):.0f} %")
    contact, contact_error = (float(values[1]), float(errors[1])) if with_contact else (0.0, 0.0)
    if with_contact and DECIBELS * contact_error > 1.0:
        doubts.append(f"the gain of the contact is uncertain by {DECIBELS * contact_error:.1f} dB")
    if with_contact and contact > 3 * contact_error + 0.1:
        doubts.append(f"the contact would have to amplify by {DECIBELS * contact:.1f} dB: the recordings are not calibrated alike")
    left = [np.sqrt(np.average((target - m) ** 2, weights=deviation**-2)) * DECIBELS for m in (-now * damped[used], matrix @ values)]
    return Fit(value, error, contact, contact_error, float(left[0]), float(left[1]), tuple(doubts))


def run(args: argparse.Namespace) -> int:
    """Read scene and recordings, fit, print, and write the scene with the fitted values."""
    document, unknown = current_document(read_json(args.scene), args.scene)
    warn_of_unknown(args.scene, unknown)
    scene = scene_of(document, args.scene)
    if not scene.contacts and sum(item.shape is not None for item in scene.objects) > 1:
        scene = replace(scene, contacts=contacts_of_scene(scene).to_contacts([item.name for item in scene.objects]))
    graph = graph_of_scene(scene)
    path = _path(graph, args)
    fitted = graph.table.index()[args.object]
    item = graph.table.objects[fitted]
    if not isinstance(item.propagation, Physical):
        raise ValueError(f"{args.object}: only objects with the function physical have a loss that depends on frequency")
    measured = transfer(*_recordings(args.recorded_source, args.recorded_listener))
    known, damped, inside = path_levels(graph, path, fitted, measured.frequency)
    if inside == 0:
        raise ValueError(f"{args.object}: the path leads through {', '.join(objects_on(graph, path))}")
    contact = _contact(scene, args.contact)
    if contact is not None:
        old = scene.contacts[contact].transmission
        if not isinstance(old, Constant):
            scene = _with_transmission(scene, contact, 1.0)
            known, damped, _ = path_levels(graph_of_scene(scene), path, fitted, measured.frequency)
        else:
            known = known - math.log(old.gain_value)
    now = math.log(transfer_coefficient(item.kappa, item.rho)) / math.log(item.propagation.material_k)
    found = fit(measured, known, damped, now, contact is not None)
    k = item.propagation.material_k ** max(found.damping, 0.0)
    kappa, rho = coefficients_of(k, item.rho)
    gain = min(1.0, math.exp(found.contact))
    printed: dict[str, Any] = {
        "object": {"name": args.object, "damping": found.damping, "standard_deviation": found.damping_error, "kappa": kappa, "rho": rho},
        "difference_before": found.before,
        "difference_after": found.left,
        "coherent_part": float((measured.coherence >= COHERENT).mean()),
        "not_determined": list(found.doubts),
    }
    if contact is not None:
        printed["contact"] = {"objects": list(scene.contacts[contact].objects), "gain": gain, "standard_deviation": found.contact_error}
    print(json.dumps(printed, indent=1, ensure_ascii=False))
    if args.out is not None:
        objects = tuple(replace(o, kappa=kappa, rho=rho) if o.name == args.object else o for o in scene.objects)
        scene = replace(scene, objects=objects)
        write_scene(scene if contact is None else _with_transmission(scene, contact, gain), args.out)
        say([f"wrote {args.out}"])
    return 0


def _path(graph: HapticGraph, args: argparse.Namespace) -> tuple[int, ...]:
    """The best path from the source to the listener. Raises ValueError where names are wrong or nothing arrives."""
    for names, name, what in (
        ([s.name for s in graph.sources], args.source, "source"),
        (list(graph.listeners), args.listener, "listener"),
        (list(graph.table.names), args.object, "object"),
    ):
        if name not in names:
            raise ValueError(f"{name}: there is no such {what}; {what}s: {', '.join(names)}")
    pair = [s.name for s in graph.sources].index(args.source), graph.listeners.index(args.listener)
    path = propagate(graph, Settings(threshold=0.0)).best_path.get(pair)
    if path is None:
        raise ValueError(f"nothing leads from {args.source} to {args.listener}")
    return path


def _contact(scene: HapticScene, objects: list[str] | None) -> int | None:
    """The number of the contact between two objects."""
    if objects is None:
        return None
    for number, contact in enumerate(scene.contacts):
        if set(contact.objects) == set(objects):
            return number
    raise ValueError(f"{' and '.join(objects)}: they do not touch")


def _with_transmission(scene: HapticScene, number: int, gain: float) -> HapticScene:
    contacts = list(scene.contacts)
    contacts[number] = replace(contacts[number], transmission=Constant(gain_value=gain))
    return replace(scene, contacts=tuple(contacts))


def _recordings(source: Path, listener: Path) -> tuple[FloatArray, FloatArray, float]:
    """The first channel of both files, at most `LONGEST` seconds, and their sample rate [Hz]."""
    found = [wav.read(path).channels[0] for path in (source, listener)]
    rates = {channel.sample_rate for channel in found}
    if len(rates) != 1:
        raise ValueError(f"{listener}: the recordings have different sample rates")
    rate = float(rates.pop())
    first, second = (np.asarray(channel.samples[: round(LONGEST * rate)], dtype=np.float64) for channel in found)
    return first, second, rate
