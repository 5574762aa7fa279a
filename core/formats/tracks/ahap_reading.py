"""Reading AHAP (Apple Core Haptics) as Apple's loader does: unknown keys are ignored, missing ones have their defaults.

An event's amplitude is the square of its intensity times the value of the intensity curves, its frequency goes from 65 to 300 Hz with the
square of sharpness plus the value of the sharpness curves. Curves are interpolated before these laws. ``AttackTime``, ``DecayTime`` and
``ReleaseTime`` are taken as seconds: Apple's reference gives 0 to 1 as their range, its headers say that they act exponentially, and no
public document gives the mapping.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...scene.references import Place, PlacedError
from ...signals.drawn import EMPHASIS_SECONDS, HIGHEST, LOWEST
from ..io.error import FormatError, errors_in
from ..io.strict_json import parse_json, read_bytes, without_trailing_commas
from .carrier import Carrier
from .vibration_file import Channel, VibrationFile

Keys = tuple[FloatArray, FloatArray]

MAX_BYTES = 32 * 2**20

_PARTS = 16
"""Linear pieces of amplitude or frequency over a change of intensity or sharpness by 1: an error below 0.001."""
_ENVELOPE = ("AttackTime", "DecayTime", "ReleaseTime", "Sustained")
_KNOWN = ("HapticIntensity", "HapticSharpness", *_ENVELOPE)
_CONTROLS = ("HapticIntensityControl", "HapticSharpnessControl")


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
        raise FormatError(path, "/Pattern" if isinstance(document, dict) else "/", "must be an array" if document else "is required")
    with errors_in(path):
        carriers = carriers_of(pattern, losses)
    end = max((carrier.end for carrier in carriers), default=0.0)
    return VibrationFile((Channel(path.stem, end, carriers),), tuple(losses))


def carriers_of(pattern: list[Any], losses: dict[str, None]) -> tuple[Carrier, ...]:
    """The oscillations of a pattern; ignored entries are added to ``losses``."""
    controls = {name: _control(pattern, name, default) for name, default in zip(_CONTROLS, (1.0, 0.0), strict=True)}
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
            losses["audio is not read" if str(event).startswith("Audio") else f"the event type {event} is not known"] = None
            continue
        values = dict(_parameters(body, place, losses))
        start = _number(body, "Time", 0.0, place)
        duration = _number(body, "EventDuration", 0.0, place)
        envelope = _envelope(values, duration) if event == "HapticContinuous" else _flat(EMPHASIS_SECONDS)
        if envelope[0][-1] > 0 and start >= 0:
            carriers.append(_carrier(start, values, envelope, controls))
        else:
            losses["events without a duration are not read"] = None
    return tuple(carriers)


def _entries(pattern: list[Any]) -> Iterator[tuple[Place, str, Mapping[str, Any]]]:
    """Place, kind and content of each entry."""
    for i, entry in enumerate(pattern):
        if not isinstance(entry, dict):
            raise PlacedError(("Pattern", i), "must be an object")
        for kind, body in entry.items():
            if kind in ("Event", "Parameter", "ParameterCurve") and not isinstance(body, dict):
                raise PlacedError(("Pattern", i, kind), "must be an object")
            yield ("Pattern", i, kind), kind, body if isinstance(body, dict) else {}


def _number(form: Mapping[str, Any], key: str, default: float, place: Place) -> float:
    value = form.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e6:
        raise PlacedError((*place, key), "must be a number from -1e6 to 1e6")
    return float(value)


def _list(form: Mapping[str, Any], key: str, place: Place) -> list[Mapping[str, Any]]:
    values = form.get(key, [])
    if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
        raise PlacedError((*place, key), "must be an array of objects")
    return values


def _parameters(event: Mapping[str, Any], place: Place, losses: dict[str, None]) -> Iterator[tuple[str, float]]:
    for k, parameter in enumerate(_list(event, "EventParameters", place)):
        name = parameter.get("ParameterID")
        if name in _KNOWN:
            yield str(name), _number(parameter, "ParameterValue", 0.0, (*place, "EventParameters", k))
        else:
            losses[f"the event parameter {name} is not read"] = None


def _flat(duration: float) -> Keys:
    return np.array([0.0, duration]), np.ones(2)


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
    """Times and values of one control: it holds its default before the first curve or parameter, and each last value until the next."""
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
                (start + _number(point, "Time", 0.0, own), _number(point, "ParameterValue", default, own))
                for point, own in zip(points, named, strict=True)
            ]
            pieces += [(start, sorted(keys, key=lambda key: key[0]))] if keys else []
    keys = [(0.0, default)]
    for _, piece in sorted(pieces, key=lambda piece: piece[0]):
        keys += [(piece[0][0], keys[-1][1]), *piece]
    times, values = np.array(keys).T
    return np.maximum.accumulate(times), values


def _carrier(start: float, values: Mapping[str, float], envelope: Keys, controls: Mapping[str, Keys]) -> Carrier:
    times, shares = _refined(_product(envelope, _within(controls["HapticIntensityControl"], start, envelope[0][-1])))
    amplitudes = np.clip(values.get("HapticIntensity", 1.0) * shares, 0.0, 1.0) ** 2
    key_times, offsets = _refined(_within(controls["HapticSharpnessControl"], start, envelope[0][-1]))
    sharpness = np.clip(values.get("HapticSharpness", 0.5) + offsets, 0.0, 1.0)
    frequencies = LOWEST + (HIGHEST - LOWEST) * sharpness**2
    return Carrier(start, start + float(envelope[0][-1]), 0.0, times, amplitudes, key_times, frequencies)


def _within(keys: Keys, start: float, length: float) -> Keys:
    """The keys from ``start`` for ``length`` seconds, with times from the start."""
    times, values = keys
    first, last = np.searchsorted(times, [start, start + length], side="right")
    before = (
        values[max(first - 1, 0)] if first == len(times) else np.interp(start, times[first - 1 : first + 1], values[first - 1 : first + 1])
    )
    after = np.interp(start + length, times, values)
    return np.concatenate([[0.0], np.minimum(times[first:last] - start, length), [length]]), np.concatenate(
        [[before], values[first:last], [after]]
    )


def _product(first: Keys, second: Keys) -> Keys:
    """The product of two curves at the keys of both; between them it is refined, since it is not linear."""
    times = np.unique(np.concatenate([first[0], second[0]]))
    times = np.unique(np.concatenate([times, *(times[:-1] + np.diff(times) * k / 4 for k in (1, 2, 3))]))
    if len(second[0]) == 2 and second[1][0] == second[1][1]:
        return first[0], first[1] * second[1][0]
    if (first[1] == 1.0).all():
        return second
    return times, np.interp(times, *first) * np.interp(times, *second)


def _refined(keys: Keys) -> Keys:
    """More keys where the value changes, so that its square is linear between them up to an error of 0.001."""
    times, values = keys
    parts = np.maximum(np.ceil(np.abs(np.diff(values)) * _PARTS), 1).astype(np.int64)
    parts[np.diff(times) <= 0] = 1
    owner = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[owner]
    moved, risen = np.diff(times)[owner], np.diff(values)[owner]
    return np.append(times[owner] + share * moved, times[-1]), np.append(values[owner] + share * risen, values[-1])


def intensity(amplitude: FloatArray) -> FloatArray:
    """The intensity that plays an amplitude."""
    return np.asarray(np.sqrt(np.clip(amplitude, 0.0, 1.0)))


def sharpness(frequency: FloatArray) -> FloatArray:
    """The sharpness that plays a frequency (hertz)."""
    return np.asarray(np.sqrt(np.clip((frequency - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0)))
