"""AHAP (Apple Core Haptics): a pattern per listener, and another one of its impacts and pulses,
since curves change every event of their pattern; these alone need no other one.

Both are played together: the continuous pattern has the power that the transients leave. Intensity
is the square root of the amplitude, sharpness that of the frequency's relative position between 65
and 300 Hz.

It is read as Apple's loader does: unknown keys are ignored, missing ones have their defaults. An
event's amplitude is the square of its intensity times the value of the intensity curves, its
frequency goes from 65 to 300 Hz with the square of sharpness plus the value of the sharpness
curves. Curves are interpolated before these laws. ``AttackTime``, ``DecayTime`` and ``ReleaseTime``
are taken as seconds: Apple's reference gives 0 to 1 as their range, its headers say that they act
exponentially, and no public document gives the mapping.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.budget import Budget
from ...core.formats.io.error import FormatError, errors_in
from ...core.formats.io.json_text import write_compact
from ...core.formats.io.strict_json import parse_json, read_bytes
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit
from ...core.formats.tracks.vibration_file import VibrationFile
from ...core.forms import Form, JsonObject
from ...core.scene.references import Place, PlacedError
from ...core.signals.drawn import EMPHASIS_SECONDS, HIGHEST, LOWEST
from ...core.signals.keys import needed_keys
from ..keyframes.carrier import Carrier, compare_carriers
from ..keyframes.channel import KeyframedChannel
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.envelopes import WithoutBursts, bursts_of, vibration_envelope
from ..keyframes.files import json_points, listener_files, without_trailing_commas
from ..keyframes.left_out import without_damaged

TRANSIENTS_SUFFIX = ".transients.ahap"

LONGEST_EVENT = 30.0
"""Longest continuous event (seconds)."""
MOST_POINTS = 16
"""Control points of a curve."""
SILENCE = 0.003
"""Amplitude that counts as silence, relative to the largest."""

Keys = tuple[FloatArray, FloatArray]

MAX_BYTES = 32 * 2**20

_PARTS = 16
"""Linear pieces of amplitude or frequency over a change of intensity or sharpness by 1: an error
below 0.001."""
_ENVELOPE = ("AttackTime", "DecayTime", "ReleaseTime", "Sustained")
_KNOWN = ("HapticIntensity", "HapticSharpness", *_ENVELOPE)
_CONTROLS = ("HapticIntensityControl", "HapticSharpnessControl")


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: a phone has one actuator; the file name gives the listener"
    yield (
        f"the wave itself: intensity and sharpness every {options['step'] * 1000:g} ms remain, "
        f"within {LOWEST:g} to {HIGHEST:g} Hz"
    )


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.SPECTRUM, LOWEST, HIGHEST), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.ahap`` and, for impacts beside continuous vibration,
    ``.transients.ahap``."""
    files = []
    for number, listener, row, path in listener_files(export, folder, ".ahap"):
        bursts = bursts_of(row, listener.impacts, lambda frequency: (EMPHASIS_SECONDS, 0.5))
        clicks = [
            _event("HapticTransient", burst.time, burst.amplitude, burst.frequency)
            for burst in bursts
        ]
        continuous = list(
            _continuous(
                *vibration_envelope(WithoutBursts(row, bursts), options["step"]),
                options["step"],
                row.duration,
                options["error"],
            )
        )
        if not continuous and not clicks:  # players refuse an empty pattern
            continuous = [
                _event("HapticContinuous", 0.0, 0.0, LOWEST, min(row.duration, LONGEST_EVENT))
            ]
        compare_carriers(number, carriers_of(continuous, {}) + carriers_of(clicks, {}), measured)
        files.append(_write(path, export, listener, continuous or clicks))
        if continuous and clicks:
            files.append(_write(path.with_suffix(TRANSIENTS_SUFFIX), export, listener, clicks))
    return files


def _write(
    path: Path, export: TrackExport, listener: ListenerTrack, pattern: list[JsonObject]
) -> Path:
    metadata = {
        "Project": export.name,
        "Created": export.date,
        "Description": f"{listener.name}, by {credit(export)}",
    }
    return write_compact(path, {"Version": 1.0, "Metadata": metadata, "Pattern": pattern})


def _continuous(
    amplitude: FloatArray, frequency: FloatArray, step: float, duration: float, error: float
) -> Iterator[JsonObject]:
    """Events of full intensity wherever there is vibration, each with its curves.

    Args:
        amplitude: of the vibration (n,).
        frequency: of the vibration (n,) [Hz].
        step: seconds between two values.
        duration: of the pattern [s].
        error: tolerance within which keys of curves are redundant.
    """
    largest = float(np.max(amplitude))
    sounding = np.append(amplitude > SILENCE * largest, False)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], sounding])))
    centres = (np.arange(len(amplitude)) + 0.5) * step
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        start = first * step
        stop = min(last * step, duration)
        while start < stop:
            end = min(start + LONGEST_EVENT, stop)
            yield _event("HapticContinuous", start, 1.0, LOWEST, end - start)
            inside = (centres > start) & (centres < end)
            times = np.concatenate([[start], centres[inside], [end]])
            for name, values, tolerance in (
                (
                    "HapticIntensityControl",
                    intensity(amplitude),
                    error * math.sqrt(min(largest, 1.0)),
                ),
                ("HapticSharpnessControl", sharpness(frequency), error),
            ):
                levels = np.interp(times, centres[first:last], values[first:last])
                kept = needed_keys(times, levels, np.full(len(times), tolerance))
                yield from _curves(name, times[kept], levels[kept])
            start = end


def _event(
    kind: str, time: float, amplitude: float, frequency: float, duration: float | None = None
) -> JsonObject:
    """An event of a pattern.

    Args:
        kind: its type in the file.
        time: at which it begins [s].
        amplitude: 0 to 1.
        frequency: [Hz].
        duration: [s], None for a transient.
    """
    parameters = [
        {
            "ParameterID": "HapticIntensity",
            "ParameterValue": round(float(intensity(np.array(amplitude))), 4),
        },
        {
            "ParameterID": "HapticSharpness",
            "ParameterValue": round(float(sharpness(np.array(frequency))), 4),
        },
    ]
    length = {} if duration is None else {"EventDuration": round(duration, 6)}
    return {
        "Event": {
            "Time": round(time, 6),
            "EventType": kind,
            **length,
            "EventParameters": parameters,
        }
    }


def _curves(name: str, times: FloatArray, values: FloatArray) -> Iterator[JsonObject]:
    """Curves of at most 16 points, each starting with the last point of the one before. Times of
    points are relative to their curve."""
    for first in range(0, max(len(times) - 1, 1), MOST_POINTS - 1):
        part = slice(first, first + MOST_POINTS)
        points = json_points(
            "Time", "ParameterValue", (times[part] - times[first]).round(6), values[part].round(4)
        )
        yield {
            "ParameterCurve": {
                "ParameterID": name,
                "Time": round(float(times[first]), 6),
                "ParameterCurveControlPoints": points,
            }
        }


def read(path: Path) -> VibrationFile:
    """The vibration of a pattern. Raises FormatError or OSError."""
    data = read_bytes(path, MAX_BYTES)
    losses: dict[str, None] = {}
    corrected = without_trailing_commas(data)
    if corrected != data:
        losses["commas before closing brackets are ignored"] = None
    document = parse_json(corrected, path)
    pattern = document.get("Pattern") if isinstance(document, dict) else None
    if not isinstance(pattern, list):
        raise FormatError(
            path,
            "/Pattern" if isinstance(document, dict) else "/",
            "must be an array" if document else "is required",
        )

    def read_pattern() -> tuple[Carrier, ...]:
        with errors_in(path):
            return carriers_of(pattern, losses, Budget(path, is_json=True).take)

    carriers = without_damaged(document, (("Pattern", "*"),), losses, read_pattern)
    end = max((carrier.end for carrier in carriers), default=0.0)
    return VibrationFile((KeyframedChannel(path.stem, end, carriers=carriers),), tuple(losses))


def carriers_of(
    pattern: list[Any], losses: dict[str, None], take: Callable[[float], None] = lambda size: None
) -> tuple[Carrier, ...]:
    """The oscillations of a pattern; ignored entries are added to ``losses``. take: is told the
    bytes of each oscillation."""
    controls = {
        name: _control(pattern, name, default)
        for name, default in zip(_CONTROLS, (1.0, 0.0), strict=True)
    }
    carriers = []
    for place, kind, body in _entries(pattern):
        if kind != "Event":
            if kind not in ("Parameter", "ParameterCurve"):
                losses[f"the pattern entry {kind} is not known"] = None
            elif body.get("ParameterID") not in _CONTROLS:
                losses[f"the control {body.get('ParameterID')} is not read"] = None
            continue
        event = body.get("EventType")
        if event not in ("HapticTransient", "HapticContinuous"):
            losses[
                "audio is not read"
                if str(event).startswith("Audio")
                else f"the event type {event} is not known"
            ] = None
            continue
        values = dict(_parameters(body, place, losses))
        start = _number(body, "Time", 0.0, place)
        duration = _number(body, "EventDuration", 0.0, place)
        envelope = (
            _envelope(values, duration)
            if event == "HapticContinuous"
            else (np.array([0.0, EMPHASIS_SECONDS]), np.ones(2))
        )
        if envelope[0][-1] > 0 and start >= 0:
            carriers.append(_carrier(start, values, envelope, controls))
            take(carriers[-1].size)
        else:
            losses["events without a duration are not read"] = None
    return tuple(carriers)


def _entries(pattern: list[Any]) -> Iterator[tuple[Place, str, Form]]:
    """Place, kind and content of each entry."""
    for i, entry in enumerate(pattern):
        if not isinstance(entry, dict):
            raise PlacedError(("Pattern", i), "must be an object")
        for kind, body in entry.items():
            if kind in ("Event", "Parameter", "ParameterCurve") and not isinstance(body, dict):
                raise PlacedError(("Pattern", i, kind), "must be an object")
            yield ("Pattern", i, kind), kind, body if isinstance(body, dict) else {}


def _number(form: Form, key: str, default: float, place: Place) -> float:
    value = form.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e6:
        raise PlacedError((*place, key), "must be a number from -1e6 to 1e6")
    return float(value)


def _list(form: Form, key: str, place: Place) -> list[Form]:
    values = form.get(key, [])
    if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
        raise PlacedError((*place, key), "must be an array of objects")
    return values


def _parameters(event: Form, place: Place, losses: dict[str, None]) -> Iterator[tuple[str, float]]:
    for k, parameter in enumerate(_list(event, "EventParameters", place)):
        name = parameter.get("ParameterID")
        if name in _KNOWN:
            yield (
                str(name),
                _number(parameter, "ParameterValue", 0.0, (*place, "EventParameters", k)),
            )
        else:
            losses[f"the event parameter {name} is not read"] = None


def _envelope(values: Mapping[str, float], duration: float) -> Keys:
    """Times (seconds from the start) and shares of the intensity."""
    attack, decay, release = (max(values.get(name, 0.0), 0.0) for name in _ENVELOPE[:3])
    keys = [(0.0, 0.0 if attack else 1.0)]
    if values.get("Sustained", 1.0) < 0.5:
        keys += [(attack, 1.0), (attack + max(decay, EMPHASIS_SECONDS), 0.0)]
    else:
        level = min(duration / attack, 1.0) if attack else 1.0
        keys += [(min(attack, duration), level), (duration, level)]
        if release:
            keys.append((duration + release, 0.0))
    times, shares = np.array(keys).T
    return times, shares


def _control(pattern: list[Any], name: str, default: float) -> Keys:
    """Times and values of one control: it holds its default before the first curve or parameter,
    and each last value until the next."""
    pieces: list[tuple[float, list[tuple[float, float]]]] = []
    for place, kind, body in _entries(pattern):
        if body.get("ParameterID") != name:
            continue
        start = _number(body, "Time", 0.0, place)
        if kind == "Parameter":
            pieces.append((start, [(start, _number(body, "ParameterValue", default, place))]))
        elif kind == "ParameterCurve":
            points = _list(body, "ParameterCurveControlPoints", place)
            named = [(*place, "ParameterCurveControlPoints", k) for k in range(len(points))]
            keys = [
                (
                    start + _number(point, "Time", 0.0, own),
                    _number(point, "ParameterValue", default, own),
                )
                for point, own in zip(points, named, strict=True)
            ]
            pieces += [(start, sorted(keys, key=lambda key: key[0]))] if keys else []
    keys = [(0.0, default)]
    for _, piece in sorted(pieces, key=lambda piece: piece[0]):
        keys += [(piece[0][0], keys[-1][1]), *piece]
    times, values = np.array(keys).T
    return np.maximum.accumulate(times), values


def _carrier(
    start: float, values: Mapping[str, float], envelope: Keys, controls: Mapping[str, Keys]
) -> Carrier:
    times, shares = _product(
        envelope, _within(controls["HapticIntensityControl"], start, envelope[0][-1])
    )
    times, intensities = _refined(_limited(times, values.get("HapticIntensity", 1.0) * shares))
    key_times, offsets = _within(controls["HapticSharpnessControl"], start, envelope[0][-1])
    key_times, sharpness = _refined(
        _limited(key_times, values.get("HapticSharpness", 0.5) + offsets)
    )
    frequencies = LOWEST + (HIGHEST - LOWEST) * sharpness**2
    return Carrier(
        start, start + float(envelope[0][-1]), 0.0, times, intensities**2, key_times, frequencies
    )


def _limited(times: FloatArray, values: FloatArray) -> Keys:
    """The curve within 0 to 1, with keys where it reaches these limits."""
    if values.min() >= 0 and values.max() <= 1:
        return times, values
    for limit in (0.0, 1.0):
        crossed = np.flatnonzero(
            ((values[:-1] - limit) * (values[1:] - limit) < 0) & (times[:-1] < times[1:])
        )
        share = (limit - values[crossed]) / (values[crossed + 1] - values[crossed])
        times = np.insert(
            times, crossed + 1, times[crossed] + share * (times[crossed + 1] - times[crossed])
        )
        values = np.insert(values, crossed + 1, limit)
    return times, np.clip(values, 0.0, 1.0)


def _within(keys: Keys, start: float, length: float) -> Keys:
    """The keys from ``start`` for ``length`` seconds, with times from the start."""
    times, values = keys
    first, last = np.searchsorted(times, [start, start + length], side="right")
    before = (
        values[max(first - 1, 0)]
        if first == len(times)
        else np.interp(start, times[first - 1 : first + 1], values[first - 1 : first + 1])
    )
    after = np.interp(start + length, times, values)
    return np.concatenate(
        [[0.0], np.minimum(times[first:last] - start, length), [length]]
    ), np.concatenate([[before], values[first:last], [after]])


def _product(first: Keys, second: Keys) -> Keys:
    """The product of two curves at the keys of both; between them it is refined, since it is not
    linear."""
    times = np.unique(np.concatenate([first[0], second[0]]))
    times = np.unique(
        np.concatenate([times, *(times[:-1] + np.diff(times) * k / 4 for k in (1, 2, 3))])
    )
    if len(second[0]) == 2 and second[1][0] == second[1][1]:
        return first[0], first[1] * second[1][0]
    if (first[1] == 1.0).all():
        return second
    return times, np.interp(times, *first) * np.interp(times, *second)


def _refined(keys: Keys) -> Keys:
    """More keys where the value changes, so that its square is linear between them up to an error
    of 0.001."""
    times, values = keys
    if (values == values[0]).all():
        return keys
    parts = np.maximum(np.ceil(np.abs(np.diff(values)) * _PARTS), 1).astype(np.int64)
    parts[np.diff(times) <= 0] = 1
    owner = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[owner]
    moved = np.diff(times)[owner]
    risen = np.diff(values)[owner]
    return np.append(times[owner] + share * moved, times[-1]), np.append(
        values[owner] + share * risen, values[-1]
    )


def intensity(amplitude: FloatArray) -> FloatArray:
    """The intensity that plays an amplitude."""
    return np.sqrt(np.clip(amplitude, 0.0, 1.0))


def sharpness(frequency: FloatArray) -> FloatArray:
    """The sharpness that plays a frequency (hertz)."""
    return np.sqrt(np.clip((frequency - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0))
