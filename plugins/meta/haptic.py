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
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.error import FormatError
from ...core.formats.io.json_text import write_compact, write_json
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import read_json
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit
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
from ..keyframes.files import json_points, listener_files
from ..keyframes.fitting import Fit
from ..keyframes.left_out import without_damaged
from .actuator import ACTUATORS, DUCKING, Actuator, actuator_beside, power

SLIGHT = 0.05
"""Amount by which amplitudes may exceed their range to be clipped instead of refused."""
_ENVELOPES = ("signals", "continuous", "envelopes")
_SCHEMA = Path(__file__).with_name("haptic_v1.schema.json")
_PARTS = ((*_ENVELOPES, "frequency"), (*_ENVELOPES, "amplitude", "*", "emphasis"))


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    actuator = _actuator(options)
    low, high = actuator.low, actuator.high
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: the format has none; the file name gives the listener"
    yield f"all but one oscillation at a time, between {low:g} and {high:g} Hz"
    yield f"the pitch below {low:g} and above {high:g} Hz: played as {low:g} and {high:g} Hz"
    yield "the strength of players: amplitude and frequency are shares of what an actuator can do"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    kind, actuator = Kind.SPECTRUM if options["points"] else Kind.WAVE, _actuator(options)
    return Comparison(tracks, Measures(kind, actuator.low, actuator.high), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.haptic`` and ``.acf`` for each listener."""
    actuator = _actuator(options)
    low, high = actuator.low, actuator.high
    files = []
    for number, listener, row, path in listener_files(export, folder, ".haptic"):
        bursts: list[Burst] = []
        if options["points"]:
            if options["emphasis"]:
                bursts = bursts_of(row, listener.impacts, actuator.burst_form)
            carrier = thinned_carrier(WithoutBursts(row, bursts), low, high, options["points"])
        else:
            carrier = single_carrier(row, Fit(error=options["error"], lowest=low, highest=high))
        document = _document(export, listener, carrier, actuator, bursts)
        played = _carriers(document["signals"]["continuous"]["envelopes"], actuator, str(path))
        compare_carriers(number, played, measured)
        files.append(write_compact(path, document))
        metadata = {
            "version": "1.0.0",
            "device": f"{export.name}, {listener.name}",
            "date": export.date,
            "author": credit(export),
        }
        configuration = {"metadata": metadata, **actuator.configuration()}
        files.append(write_json(path.with_suffix(".acf"), configuration))
    return files


def _actuator(options: Form) -> Actuator:
    """The actuator that the options name, with the frequencies that they set instead of its own."""
    chosen = ACTUATORS[options["actuator"]]
    low = options["frequency_min"] or chosen.low
    high = options["frequency_max"] or chosen.high
    if low >= high:
        raise ValueError(f"frequency_max: must be above frequency_min ({low:g}), not {high:g}")
    return replace(chosen, low=low, high=high)


def _document(
    export: TrackExport,
    listener: ListenerTrack,
    carrier: Carrier,
    actuator: Actuator,
    bursts: Sequence[Burst],
) -> JsonObject:
    """The document of a listener's file.

    Args:
        export: what is exported.
        listener: the listener.
        carrier: its vibration as a tone of changing amplitude and frequency.
        actuator: what plays the file.
        bursts: its impacts.
    """
    low, high = actuator.low, actuator.high
    shares = np.clip((carrier.frequencies - low) / (high - low), 0.0, 1.0)
    envelopes = {
        "amplitude": _amplitude_points(carrier, actuator, bursts),
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


def _amplitude_points(
    carrier: Carrier, actuator: Actuator, bursts: Sequence[Burst]
) -> list[JsonObject]:
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
        level, sharpness = point["amplitude"], actuator.sharpness(burst.frequency)
        lost = (1 - DUCKING**2) * level**2 / 2
        strength = math.sqrt(burst.amplitude**2 + lost / power(sharpness))
        point["emphasis"] = {
            "amplitude": round(min(max(strength, level), 1.0), 6),
            "frequency": round(sharpness, 4),
        }
    return points


def read(path: Path) -> VibrationFile:
    """The vibration, as the actuator of the ``.acf`` beside the file plays it, or that of Quest
    controllers if there is none.

    Raises FormatError or OSError.
    """
    document = read_json(path)
    losses: dict[str, None] = {}
    if _clip_slight_excess(document):
        losses[f"amplitudes up to {1 + SLIGHT:g} are clipped to 1"] = None
    metadata = _without_unplayed_parts(document)
    actuator = actuator_beside(path, losses)

    def carriers_of() -> tuple[Carrier, ...]:
        validate(document, _SCHEMA, path)
        return _carriers(document["signals"]["continuous"]["envelopes"], actuator, path)

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


def _carriers(envelopes: Form, actuator: Actuator, path: str | Path) -> tuple[Carrier, ...]:
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
    ends = np.minimum(
        begins + actuator.seconds(sharpness), np.append(begins[1:], math.inf)[: len(begins)]
    )
    ducked_times, ducked = _ducked(times, amplitudes, np.stack([begins, ends], axis=1))
    hertz = actuator.low + shares * (actuator.high - actuator.low)
    continuous = Carrier(0.0, float(times[-1]), 0.0, ducked_times, ducked, key_times, hertz)
    emphases = (
        wave
        for begin, end, point in zip(begins.tolist(), ends.tolist(), accented, strict=True)
        for wave in actuator.emphasis(begin, end, **point["emphasis"])
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
    jumps *= np.tile([1.0, DUCKING, DUCKING, 1.0], len(emphases))
    places = places.ravel().repeat(2)
    return (
        np.insert(times, places, edges.repeat(2)),
        np.insert(amplitudes * np.where(inside, DUCKING, 1.0), places, jumps),
    )


def _points(
    path: str | Path, points: list[Form], place: str, key: str
) -> tuple[FloatArray, FloatArray]:
    times = np.array([point["time"] for point in points], dtype=np.float64)
    backwards = np.flatnonzero(np.diff(times) < 0)
    if len(backwards):
        raise FormatError(path, f"{place}/{backwards[0] + 1}/time", "times must not decrease")
    return times, np.array([point[key] for point in points], dtype=np.float64)
