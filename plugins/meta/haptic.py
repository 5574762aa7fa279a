"""``.haptic`` 1.0 (Meta Haptics Studio): one file per listener, with the actuator configuration
(ACF) that its numbers refer to.

Players synthesise the oscillation from an amplitude and a frequency, so breakpoints follow these,
not the wave; their density is that of published files. An impact or a pulse is an emphasis that has
the power of its beginning, which the envelope leaves out. Players duck the envelope meanwhile, and
a new emphasis ends the one before. With ``points`` 0 the envelope follows
the wave, with the impacts in it, and there is no emphasis.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.error import FormatError
from ...core.formats.io.json_text import json_points, write_compact, write_json
from ...core.formats.io.left_out import without_damaged
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import (
    parse_json,
    read_bytes,
    read_json,
    without_trailing_commas,
)
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit, listener_files
from ...core.formats.tracks.vibration_file import VibrationFile
from ...core.forms import Form, JsonObject
from ..keyframes.carrier import Carrier, compare_carriers
from ..keyframes.channel import KeyframedChannel
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.envelopes import (
    Burst,
    WithoutBursts,
    bursts_of,
    single_carrier,
    thinned_carrier,
)
from ..keyframes.fitting import Fit
from .json5 import as_json

SLIGHT = 0.05
"""Amount by which amplitudes may exceed their range to be clipped instead of refused."""
_EMPHASIS = {"frequency_min": (55.0, 36.4, "sine"), "frequency_max": (165.0, 12.1, "square")}
"""Frequency [Hz], duration [ms] and wave of an emphasis of frequency 0, and of 1, in the
configuration of Quest's actuator; between them all three are mixed linearly."""
_DUCKING = 0.5
"""Factor of the continuous signal while an emphasis sounds."""
_ENVELOPES = ("signals", "continuous", "envelopes")
_SCHEMA = Path(__file__).with_name("haptic_v1.schema.json")
_PARTS = ((*_ENVELOPES, "frequency"), (*_ENVELOPES, "amplitude", "*", "emphasis"))
_QUEST = (55.0, 200.0)


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    low, high = _range(options)
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: the format has none; the file name gives the listener"
    yield f"all but one oscillation at a time, between {low:g} and {high:g} Hz"
    yield "the strength of players: amplitude and frequency are shares of what an actuator can do"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(
        tracks,
        Measures(Kind.SPECTRUM if options["points"] else Kind.WAVE, *_range(options)),
        progress,
    )


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.haptic`` and ``.acf`` for each listener."""
    low, high = _range(options)
    files = []
    for number, listener, row, path in listener_files(export, folder, ".haptic"):
        bursts: list[Burst] = []
        if options["points"]:
            bursts = bursts_of(row, listener.impacts, _burst_form) if options["emphasis"] else []
            carrier = thinned_carrier(WithoutBursts(row, bursts), low, high, options["points"])
        else:
            carrier = single_carrier(row, Fit(error=options["error"], lowest=low, highest=high))
        document = _document(export, listener, carrier, low, high, bursts)
        played = _carriers(document["signals"]["continuous"]["envelopes"], low, high, str(path))
        compare_carriers(number, played, measured)
        files.append(write_compact(path, document))
        files.append(
            write_json(path.with_suffix(".acf"), _configuration(export, listener, low, high))
        )
    return files


def _range(options: Form) -> tuple[float, float]:
    low = options["frequency_min"]
    high = options["frequency_max"]
    if low >= high:
        raise ValueError(f"frequency_max: must be above frequency_min ({low:g}), not {high:g}")
    return low, high


def _document(
    export: TrackExport,
    listener: ListenerTrack,
    carrier: Carrier,
    low: float,
    high: float,
    bursts: Sequence[Burst],
) -> JsonObject:
    """The document of a listener's file.

    Args:
        export: what is exported.
        listener: the listener.
        carrier: its vibration as a tone of changing amplitude and frequency.
        low: frequency of the value 0 [Hz].
        high: frequency of the value 1 [Hz].
        bursts: its impacts.
    """
    shares = np.clip((carrier.frequencies - low) / (high - low), 0.0, 1.0)
    envelopes = {
        "amplitude": _amplitude_points(carrier, bursts),
        "frequency": json_points(
            "time", "frequency", carrier.frequency_times.round(6), shares.round(6)
        ),
    }
    metadata = {
        "editor": credit(export),
        "source": export.name,
        "project": export.name,
        "tags": [listener.body_part] if listener.body_part else [],
        "description": listener.name,
    }
    version = {"major": 1, "minor": 0, "patch": 0}
    return {
        "version": version,
        "metadata": metadata,
        "signals": {"continuous": {"envelopes": envelopes}},
    }


def _amplitude_points(carrier: Carrier, bursts: Sequence[Burst]) -> list[JsonObject]:
    """The breakpoints of the amplitude, and one with an emphasis for each burst: it has the power
    of the burst and that by which players duck the envelope meanwhile, and at least the amplitude
    of the envelope, as the format demands."""
    times, levels = carrier.amplitude_times, carrier.amplitudes
    if len(times) < 2:
        times = np.array([0.0, max(carrier.end, 1e-3)])
        levels = np.zeros(2)
    every = np.unique(np.concatenate([times, [burst.time for burst in bursts]]))
    points = json_points(
        "time", "amplitude", every.round(6), np.interp(every, times, levels).round(6)
    )
    for burst in bursts:
        point = points[int(np.searchsorted(every, burst.time))]
        level, sharpness = point["amplitude"], _sharpness(burst.frequency)
        lost = (1 - _DUCKING**2) * level**2 / 2
        strength = math.sqrt(burst.amplitude**2 + lost / _power(sharpness))
        point["emphasis"] = {
            "amplitude": round(min(max(strength, level), 1.0), 6),
            "frequency": round(sharpness, 4),
        }
    return points


def _sharpness(frequency: float) -> float:
    """The emphasis frequency, from 0 to 1, that plays a frequency (hertz)."""
    (low, *_), (high, *_) = _EMPHASIS.values()
    return min(max((frequency - low) / (high - low), 0.0), 1.0)


def _burst_form(frequency: float) -> tuple[float, float]:
    """Seconds of the burst of an emphasis, and its power at amplitude 1, by frequency (hertz)."""
    sharpness = _sharpness(frequency)
    return float(_seconds(np.asarray(sharpness))), _power(sharpness)


def _configuration(
    export: TrackExport, listener: ListenerTrack, low: float, high: float
) -> JsonObject:
    emphasis = {
        key: {"output_frequency": frequency, "duration_ms": milliseconds, "shape": shape}
        for key, (frequency, milliseconds, shape) in _EMPHASIS.items()
    }
    return {
        "metadata": {
            "version": "1.0.0",
            "device": f"{export.name}, {listener.name}",
            "date": export.date,
            "author": credit(export),
        },
        "continuous": {
            "gain": 1.0,
            "emphasis_ducking": _DUCKING,
            "frequency_min": low,
            "frequency_max": high,
        },
        "emphasis": {"gain": 1.0, "fade_out_percent": 0.0, **emphasis},
    }


def read(path: Path) -> VibrationFile:
    """The vibration, with the frequency range of the ``.acf`` beside the file, or of Quest
    controllers if there is none.

    Raises FormatError or OSError.
    """
    document = read_json(path)
    losses: dict[str, None] = {}
    if _clip_slight_excess(document):
        losses[f"amplitudes up to {1 + SLIGHT:g} are clipped to 1"] = None
    metadata = _without_unplayed_parts(document)
    low, high = _range_beside(path, losses)

    def carriers_of() -> tuple[Carrier, ...]:
        validate(document, _SCHEMA, path)
        return _carriers(document["signals"]["continuous"]["envelopes"], low, high, path)

    carriers = without_damaged(document, _PARTS, losses, carriers_of)
    name = metadata.get("description") if isinstance(metadata, dict) else None
    return VibrationFile(
        (
            KeyframedChannel(
                name if name and isinstance(name, str) else path.stem,
                max(carrier.end for carrier in carriers),
                carriers=carriers,
            ),
        ),
        tuple(losses),
    )


def _without_unplayed_parts(document: Any) -> Any:
    """Remove the metadata and complete the version number, so that their faults do not matter;
    returns the metadata."""
    if not isinstance(document, dict):
        return None
    if isinstance(version := document.get("version"), dict):
        document["version"] = {"minor": 0, "patch": 0, **version}
    return document.pop("metadata", None)


def _clip_slight_excess(document: Any) -> bool:
    """Limit amplitudes that exceed [0, 1] by at most ``SLIGHT``, as some tools write them; whether
    there are any."""
    clipped = False
    try:
        points = document["signals"]["continuous"]["envelopes"]["amplitude"]
        for point in [*points, *(point["emphasis"] for point in points if "emphasis" in point)]:
            value = point["amplitude"]
            if -SLIGHT <= value < 0 or 1 < value <= 1 + SLIGHT:
                point["amplitude"] = min(max(value, 0), 1)
                clipped = True
    except (TypeError, KeyError, AttributeError):
        pass  # not a valid file, as validation tells
    return clipped


def _carriers(envelopes: Form, low: float, high: float, path: str | Path) -> tuple[Carrier, ...]:
    """The oscillation of the envelopes, and the carriers of emphases. Raises FormatError for times
    that decrease."""
    place = "/signals/continuous/envelopes"
    times, amplitudes = _points(path, envelopes["amplitude"], f"{place}/amplitude", "amplitude")
    if times[-1] <= 0:
        raise FormatError(path, f"{place}/amplitude", "the last breakpoint must be after time 0")
    if envelopes.get("frequency"):
        key_times, shares = _points(path, envelopes["frequency"], f"{place}/frequency", "frequency")
    else:
        key_times = np.zeros(1)
        shares = np.full(1, 0.5)
    accented = [point for point in envelopes["amplitude"] if "emphasis" in point]
    begins = np.array([point["time"] for point in accented], dtype=np.float64)
    sharpness = np.array([point["emphasis"]["frequency"] for point in accented])
    ends = np.minimum(begins + _seconds(sharpness), np.append(begins[1:], math.inf)[: len(begins)])
    ducked_times, ducked = _ducked(times, amplitudes, np.stack([begins, ends], axis=1))
    continuous = Carrier(
        0.0, float(times[-1]), 0.0, ducked_times, ducked, key_times, low + shares * (high - low)
    )
    emphases = (
        wave
        for begin, end, point in zip(begins.tolist(), ends.tolist(), accented, strict=True)
        for wave in _emphasis(begin, end, **point["emphasis"])
    )
    return (continuous, *emphases)


def _ducked(
    times: FloatArray, amplitudes: FloatArray, emphases: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The keys of the continuous signal, ducked between begin and end of each of ``emphases``
    (n, 2), which do not overlap."""
    edges = emphases.ravel()
    inside = np.searchsorted(edges, times, "left") % 2 & np.searchsorted(edges, times, "right") % 2
    places = np.stack(
        [np.searchsorted(times, emphases[:, 0], "right"), np.searchsorted(times, emphases[:, 1])]
    ).T
    jumps = np.interp(edges, times, amplitudes).repeat(2)
    jumps *= np.tile([1.0, _DUCKING, _DUCKING, 1.0], len(emphases))
    places = places.ravel().repeat(2)
    return (
        np.insert(times, places, edges.repeat(2)),
        np.insert(amplitudes * np.where(inside, _DUCKING, 1.0), places, jumps),
    )


def _points(
    path: str | Path, points: list[Form], place: str, key: str
) -> tuple[FloatArray, FloatArray]:
    times = np.array([point["time"] for point in points], dtype=np.float64)
    backwards = np.flatnonzero(np.diff(times) < 0)
    if len(backwards):
        raise FormatError(path, f"{place}/{backwards[0] + 1}/time", "times must not decrease")
    return times, np.array([point[key] for point in points], dtype=np.float64)


def _range_beside(path: Path, losses: dict[str, None]) -> tuple[float, float]:
    beside = path.with_suffix(".acf")
    if not beside.is_file():
        losses["there is no .acf beside the file: frequencies are those of Quest controllers"] = (
            None
        )
        return _QUEST
    try:
        text = as_json(read_bytes(beside).decode("utf-8", "replace"))
        configuration = parse_json(without_trailing_commas(text.encode()), beside)
    except FormatError as error:
        losses[f"{beside.name} is not used: {error.reason}"] = None
        return _QUEST
    continuous = configuration.get("continuous") if isinstance(configuration, dict) else None
    if isinstance(continuous, dict):
        low = continuous.get("frequency_min")
        high = continuous.get("frequency_max")
        if (
            isinstance(low, int | float)
            and isinstance(high, int | float)
            and 0 < low < high <= 20_000
        ):
            return float(low), float(high)
    losses[f"{beside.name} gives no range of frequencies: they are those of Quest controllers"] = (
        None
    )
    return _QUEST


def _seconds(sharpness: FloatArray) -> FloatArray:
    """Duration of emphases of frequencies from 0 to 1."""
    (_, long, _), (_, short, _) = _EMPHASIS.values()
    return np.asarray((long + (short - long) * sharpness) / 1000)


def _power(sharpness: float) -> float:
    """Mean square of an emphasis of amplitude 1: of ``(1 - s) sin + s sgn(sin)``."""
    sine, square = 1 - sharpness, sharpness
    return sine**2 / 2 + 4 / math.pi * sine * square + square**2


def _emphasis(begin: float, end: float, amplitude: float, frequency: float) -> Iterator[Carrier]:
    """The waves of an emphasis: a sine that fades into a square as its frequency, from 0 to 1,
    rises."""
    (low, _, dull), (high, _, sharp) = _EMPHASIS.values()
    zero, hertz = np.zeros(1), np.full(1, low + (high - low) * frequency)
    for wave, share in ((dull, 1 - frequency), (sharp, frequency)):
        if share * amplitude > 0 and end > begin:
            yield Carrier(begin, end, 0.0, zero, np.full(1, share * amplitude), zero, hertz, wave)
