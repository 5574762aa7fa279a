"""AHAP (Apple Core Haptics): a pattern per listener, and one of its impacts, since curves change every event of their pattern.

Intensity and sharpness are the square roots of amplitude and of the frequency's place between 65 and 300 Hz.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ..io.atomic import write_text
from ..io.catalogue import FORMATS
from ..io.schema import validate
from ..io.strict_json import read_json
from .carrier import Carrier
from .envelopes import coarse_envelope
from .fitting import needed_keys
from .listener_tracks import ListenerTrack
from .track_export import EDITOR, TrackExport, clipped, common_losses, listener_files
from .vibration_file import Channel, VibrationFile

Keys = tuple[FloatArray, FloatArray]

SUFFIX = FORMATS["ahap"].suffix
TRANSIENTS_SUFFIX = ".transients.ahap"

LONGEST_EVENT = 30.0
"""Seconds."""
MOST_POINTS = 16
"""Of a curve."""
LOWEST, HIGHEST = 65.0, 300.0
"""Hertz, of sharpness 0 and 1."""
SILENCE = 0.003
"""Amplitude below which a listener feels nothing."""
TRANSIENT_SECONDS = 0.02
"""About how long a transient event sounds."""


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the files leave out, in words."""
    return (
        *common_losses(export.need_tracks(), body=False),
        "the place on the body: a phone has one actuator, the file name says whose it is",
        f"the wave itself: intensity and sharpness every {options['step'] * 1000:g} ms remain, within {LOWEST:g} to {HIGHEST:g} Hz",
    )


def write(export: TrackExport, folder: Path, options: Mapping[str, Any]) -> list[Path]:
    """Write ``<scene>.<listener>.ahap`` and, for impacts, ``.transients.ahap``."""
    tracks = export.need_tracks()
    files = []
    for listener, samples, path in zip(tracks.listeners, tracks.samples, listener_files(export, folder, SUFFIX), strict=True):
        amplitude, frequency = coarse_envelope(clipped(samples), tracks.sample_rate, options["step"])
        pattern = list(_continuous(amplitude, frequency, options["step"], tracks.duration, options["error"]))
        files.append(_write(path, export, listener, pattern))
        if len(listener.impacts):
            sharp = np.interp(listener.impacts[:, 0], (np.arange(len(frequency)) + 0.5) * options["step"], frequency)
            pattern = [
                _event("HapticTransient", time, math.sqrt(strength), float(_sharpness(np.array(pitch))))
                for (time, strength), pitch in zip(listener.impacts.tolist(), sharp.tolist(), strict=True)
            ]
            files.append(_write(path.with_name(path.name.removesuffix(SUFFIX) + TRANSIENTS_SUFFIX), export, listener, pattern))
    return files


def _write(path: Path, export: TrackExport, listener: ListenerTrack, pattern: list[dict[str, Any]]) -> Path:
    metadata = {"Project": export.name, "Created": export.date, "Description": f"{listener.name}, by {EDITOR}"}
    document = {"Version": 1.0, "Metadata": metadata, "Pattern": pattern}
    return write_text(path, [json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":")), "\n"])


def _sharpness(frequency: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.clip((frequency - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0)))


def _continuous(amplitude: FloatArray, frequency: FloatArray, step: float, duration: float, error: float) -> Iterator[dict[str, Any]]:
    """Events of full intensity where anything is felt, each with its curves."""
    sounding = np.append(amplitude > SILENCE, False)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], sounding])))
    intensity, sharpness = np.sqrt(np.minimum(amplitude, 1.0)), _sharpness(frequency)
    centres = (np.arange(len(amplitude)) + 0.5) * step
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        start, stop = first * step, min(last * step, duration)
        while start < stop:
            end = min(start + LONGEST_EVENT, stop)
            yield _event("HapticContinuous", start, 1.0, 0.0, end - start)
            inside = (centres > start) & (centres < end)
            times = np.concatenate([[start], centres[inside], [end]]) if end > start else np.array([start])
            for name, values in (("HapticIntensityControl", intensity), ("HapticSharpnessControl", sharpness)):
                levels = np.interp(times, centres[first:last], values[first:last])
                kept = needed_keys(times, levels, np.full(len(times), error))
                yield from _curves(name, times[kept], levels[kept])
            start = end


def _event(kind: str, time: float, intensity: float, sharpness: float, duration: float | None = None) -> dict[str, Any]:
    parameters = [
        {"ParameterID": "HapticIntensity", "ParameterValue": round(intensity, 4)},
        {"ParameterID": "HapticSharpness", "ParameterValue": round(sharpness, 4)},
    ]
    length = {} if duration is None else {"EventDuration": round(duration, 6)}
    return {"Event": {"Time": round(time, 6), "EventType": kind, **length, "EventParameters": parameters}}


def _curves(name: str, times: FloatArray, values: FloatArray) -> Iterator[dict[str, Any]]:
    """Curves of at most 16 points, each beginning with the last point of the one before. The times of points count from their curve's."""
    for first in range(0, max(len(times) - 1, 1), MOST_POINTS - 1):
        part = slice(first, first + MOST_POINTS)
        points = [
            {"Time": time, "ParameterValue": value}
            for time, value in zip((times[part] - times[first]).round(6).tolist(), values[part].round(4).tolist(), strict=True)
        ]
        yield {"ParameterCurve": {"ParameterID": name, "Time": round(float(times[first]), 6), "ParameterCurveControlPoints": points}}


def read(path: Path) -> VibrationFile:
    """The vibration of a pattern. Raises FormatError or OSError."""
    document = read_json(path)
    validate(document, "ahap", path)
    losses: dict[str, None] = {}
    intensity = _control(document["Pattern"], "HapticIntensityControl", 1.0)
    sharpness = _control(document["Pattern"], "HapticSharpnessControl", 0.0)
    carriers = []
    for entry in document["Pattern"]:
        if "Event" not in entry:
            if "Parameter" in entry:
                losses["dynamic parameters are not taken over"] = None
            continue
        event = entry["Event"]
        if not event["EventType"].startswith("Haptic"):
            losses["audio is not taken over"] = None
            continue
        values = {p["ParameterID"]: p["ParameterValue"] for p in event.get("EventParameters", [])}
        length = TRANSIENT_SECONDS if event["EventType"] == "HapticTransient" else event.get("EventDuration", 0.0)
        if length > 0:
            level, pitch = values.get("HapticIntensity", 1.0), values.get("HapticSharpness", 0.5)
            carriers.append(_carrier(event["Time"], length, level, pitch, intensity, sharpness))
    end = max((carrier.end for carrier in carriers), default=0.0)
    return VibrationFile((Channel(path.stem, end, tuple(carriers)),), tuple(losses))


def _control(pattern: list[Mapping[str, Any]], name: str, default: float) -> Keys:
    """Times and values of all curves of one parameter; before the first it has its default, which changes nothing."""
    keys = [
        (curve["Time"] + point["Time"], point["ParameterValue"])
        for curve in sorted((e["ParameterCurve"] for e in pattern if "ParameterCurve" in e), key=lambda curve: curve["Time"])
        if curve["ParameterID"] == name
        for point in curve["ParameterCurveControlPoints"]
    ]
    if not keys:
        return np.zeros(1), np.full(1, default)
    times, values = np.array(keys, dtype=np.float64).T
    times = np.maximum.accumulate(times)
    return np.append(times[0], times), np.append(default, values)


def _carrier(start: float, length: float, level: float, pitch: float, intensity: Keys, sharpness: Keys) -> Carrier:
    def within(keys: Keys) -> Keys:
        inside = (keys[0] > start) & (keys[0] < start + length)
        times = np.concatenate([[start], keys[0][inside], [start + length]])
        return times - start, np.concatenate([np.interp([start], *keys), keys[1][inside], np.interp([start + length], *keys)])

    times, gains = within(intensity)
    key_times, offsets = within(sharpness)
    amplitudes = np.clip(level * gains, 0.0, 1.0) ** 2
    frequencies = LOWEST + (HIGHEST - LOWEST) * np.clip(pitch + offsets, 0.0, 1.0) ** 2
    return Carrier(start, start + length, 0.0, times, amplitudes, key_times, frequencies)
