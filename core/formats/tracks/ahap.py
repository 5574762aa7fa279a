"""AHAP (Apple Core Haptics): a pattern per listener, and another one of its impacts, since curves change every event of their pattern.

Both are played together: the continuous pattern has the power that the transients leave. Intensity is the square root of the amplitude,
sharpness that of the frequency's relative position between 65 and 300 Hz.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...signals.drawn import EMPHASIS_SECONDS, HIGHEST, LOWEST
from ...signals.keys import needed_keys
from ..io.atomic import write_text
from ..io.json_text import compact
from .ahap_reading import carriers_of, intensity, sharpness
from .ahap_reading import read as read
from .carrier import compare_carriers
from .comparison import Comparison, Kind, Measures
from .envelopes import mean_frequency, powers, smoothed
from .listener_tracks import ListenerTrack, Row
from .track_export import EDITOR, TrackExport, common_losses, listener_files

TRANSIENTS_SUFFIX = ".transients.ahap"

LONGEST_EVENT = 30.0
"""Longest continuous event (seconds)."""
MOST_POINTS = 16
"""Control points of a curve."""
SILENCE = 0.003
"""Amplitude that counts as silence."""


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the files do not carry, one sentence each."""
    return (
        *common_losses(export.need_tracks(), body=False),
        "the place on the body: a phone has one actuator; the file name gives the listener",
        f"the wave itself: intensity and sharpness every {options['step'] * 1000:g} ms remain, within {LOWEST:g} to {HIGHEST:g} Hz",
    )


def keeps(options: Mapping[str, Any]) -> Measures:
    """What the files keep."""
    return Measures(Kind.SPECTRUM, LOWEST, HIGHEST)


def write(export: TrackExport, folder: Path, options: Mapping[str, Any], measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.ahap`` and, for impacts, ``.transients.ahap``."""
    files = []
    for number, listener, row, path in listener_files(export, folder, "ahap"):
        transients = _transients(row, listener.impacts)
        power, change, width = powers(row, options["step"])
        _subtract(power, change, transients, row, options["step"])
        amplitude, frequency = smoothed(power, change, width, row.sample_rate)
        continuous = list(_continuous(amplitude, frequency, options["step"], row.duration, options["error"]))
        clicks = [_event("HapticTransient", time, strength, pitch) for time, strength, pitch in transients.tolist()]
        compare_carriers(row, number, carriers_of(continuous, {}) + carriers_of(clicks, {}), measured)
        files.append(_write(path, export, listener, continuous))
        if clicks:
            files.append(_write(path.with_suffix(TRANSIENTS_SUFFIX), export, listener, clicks))
    return files


def _transients(row: Row, impacts: FloatArray) -> FloatArray:
    """A transient per impact, (k, 3): time, amplitude and frequency (hertz), with at most the power of the samples while it sounds."""
    length = math.ceil(EMPHASIS_SECONDS * row.sample_rate)
    result = []
    for time, strength in impacts.tolist():
        samples = row.read(math.ceil(time * row.sample_rate), math.ceil(time * row.sample_rate) + length)
        mean, change = float(np.mean(samples**2)), float(np.mean(np.diff(samples, append=0.0) ** 2))
        pitch = mean_frequency(np.array([mean]), np.array([change]), row.sample_rate)[0]
        if time < row.duration and mean > 0:
            result.append((time, min(strength, math.sqrt(2 * mean)), pitch))
    return np.array(result).reshape(-1, 3)


def _subtract(power: FloatArray, change: FloatArray, transients: FloatArray, row: Row, step: float) -> None:
    """Take the power of the transients, and as much of the change of the samples, from the sums of every ``step`` seconds."""
    taken = np.zeros(len(power) + 1)
    for time, strength, _ in transients.tolist():
        for first in range(int(time / step), min(int((time + EMPHASIS_SECONDS) / step), len(power) - 1) + 1):
            overlap = min(time + EMPHASIS_SECONDS, (first + 1) * step) - max(time, first * step)
            taken[first] += max(overlap, 0.0) * row.sample_rate * strength**2 / 2
    rest = np.maximum(power - taken[:-1], 0.0)
    change *= np.divide(rest, power, out=np.zeros_like(power), where=power > 0)
    power[:] = rest


def _write(path: Path, export: TrackExport, listener: ListenerTrack, pattern: list[dict[str, Any]]) -> Path:
    metadata = {"Project": export.name, "Created": export.date, "Description": f"{listener.name}, by {EDITOR}"}
    return write_text(path, [compact({"Version": 1.0, "Metadata": metadata, "Pattern": pattern}), "\n"])


def _continuous(amplitude: FloatArray, frequency: FloatArray, step: float, duration: float, error: float) -> Iterator[dict[str, Any]]:
    """Events of full intensity wherever there is vibration, each with its curves."""
    sounding = np.append(amplitude > SILENCE, False)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], sounding])))
    centres = (np.arange(len(amplitude)) + 0.5) * step
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        start, stop = first * step, min(last * step, duration)
        while start < stop:
            end = min(start + LONGEST_EVENT, stop)
            yield _event("HapticContinuous", start, 1.0, LOWEST, end - start)
            inside = (centres > start) & (centres < end)
            times = np.concatenate([[start], centres[inside], [end]])
            for name, values in (("HapticIntensityControl", intensity(amplitude)), ("HapticSharpnessControl", sharpness(frequency))):
                levels = np.interp(times, centres[first:last], values[first:last])
                kept = needed_keys(times, levels, np.full(len(times), error))
                yield from _curves(name, times[kept], levels[kept])
            start = end


def _event(kind: str, time: float, amplitude: float, frequency: float, duration: float | None = None) -> dict[str, Any]:
    parameters = [
        {"ParameterID": "HapticIntensity", "ParameterValue": round(float(intensity(np.array(amplitude))), 4)},
        {"ParameterID": "HapticSharpness", "ParameterValue": round(float(sharpness(np.array(frequency))), 4)},
    ]
    length = {} if duration is None else {"EventDuration": round(duration, 6)}
    return {"Event": {"Time": round(time, 6), "EventType": kind, **length, "EventParameters": parameters}}


def _curves(name: str, times: FloatArray, values: FloatArray) -> Iterator[dict[str, Any]]:
    """Curves of at most 16 points, each starting with the last point of the one before. Times of points are relative to their curve."""
    for first in range(0, max(len(times) - 1, 1), MOST_POINTS - 1):
        part = slice(first, first + MOST_POINTS)
        points = [
            {"Time": time, "ParameterValue": value}
            for time, value in zip((times[part] - times[first]).round(6).tolist(), values[part].round(4).tolist(), strict=True)
        ]
        yield {"ParameterCurve": {"ParameterID": name, "Time": round(float(times[first]), 6), "ParameterCurveControlPoints": points}}
