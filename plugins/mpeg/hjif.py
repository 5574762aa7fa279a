"""HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31): a channel per listener, vectorial
waves and transients.

Times are in milliseconds: the reference renderer counts phases in them whatever the timescale says.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.atomic import write_text
from ...core.formats.io.json_text import compact
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import ListenerTrack, Row, Tracks
from ...core.formats.tracks.track_export import (
    TrackExport,
    body_part_of,
    common_losses,
    credit,
    scene_file,
)
from ...core.forms import Form, JsonObject
from ..keyframes.bands import bands_for
from ..keyframes.carrier import Carrier, CarrierPlayer
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.fitting import Fit, fit_bands
from ..keyframes.transients import (
    TRANSIENT_CYCLES,
    TRANSIENT_SECONDS,
    transient_carrier,
    without_transients,
)
from .hjif_reading import carriers_of
from .hjif_reading import read as read

TIMESCALE = 1000
CHANNELS_OF_LEVEL_1 = 127
HIGHEST = 1000
"""Highest frequency key (hertz)."""
EDGES = (5, 40, 80, 160, 320, 640, 860)
"""Edges of the bands (hertz). With the transient band, they are the number that level 1 allows per
channel."""

_DEVICES = {
    "Head": "Razer Kraken V4 Pro",
    "Hand": "Razer Wolverine V3 Pro",
    "Chest": "Razer Freyja",
    "Waist": "Razer Freyja",
    "Leg": "Razer Freyja",
}


def loss(export: TrackExport, options: Form) -> tuple[str, ...]:
    """What the file does not carry, one sentence each."""
    return (
        *common_losses(export.need_tracks(), body=True),
        f"frequencies below {EDGES[0]} and above {EDGES[-1]} Hz, and the order of events within "
        "a millisecond",
    )


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.WAVE, EDGES[0], EDGES[-1]), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.hjif``."""
    tracks = export.need_tracks()
    path = scene_file(export.name, folder, ".hjif")
    return [write_text(path, _document(export, tracks, options, measured))]


def _document(
    export: TrackExport, tracks: Tracks, options: Form, measured: Comparison
) -> Iterator[str]:
    devices = _reference_devices(tracks)
    head = {
        "version": "2023",
        "profile": options["profile"],
        "level": 1 if len(tracks.listeners) <= CHANNELS_OF_LEVEL_1 else 2,
        "date": export.date,
        "description": f"{export.name}, by {credit(export)}",
        "timescale": TIMESCALE,
        "avatars": [{"id": 1, "lod": 0, "type": "Vibration"}],
    }
    perception = {
        "id": 0,
        "avatar_id": 1,
        "description": "what the listeners feel",
        "perception_modality": "Vibrotactile",
        "unit_exponent": -3,
        "perception_unit_exponent": 0,
        "reference_devices": devices,
        "effect_library": [],
    }
    yield compact(head)[:-1] + ',"perceptions":[' + compact(perception)[:-1] + ',"channels":['
    for number, listener in enumerate(tracks.listeners):
        yield ",\n" if number else "\n"
        yield from _channel(number, listener, tracks, devices, options, measured)
    yield '\n]}],"syncs":[{"timestamp":0}]}\n'


def _reference_devices(tracks: Tracks) -> list[JsonObject]:
    names = dict.fromkeys(
        _DEVICES[part.wyvrn_target]
        for listener in tracks.listeners
        if (part := body_part_of(listener)) is not None
    )
    return [
        {
            "id": number,
            "name": name,
            "type": "VCA",
            "minimum_frequency": 20,
            "maximum_frequency": 300,
        }
        for number, name in enumerate(names, start=1)
    ]


def _channel(
    number: int,
    listener: ListenerTrack,
    tracks: Tracks,
    devices: list[JsonObject],
    options: Form,
    measured: Comparison,
) -> Iterator[str]:
    """The lines of a listener's channel.

    Args:
        number: of the listener.
        listener: the listener.
        tracks: of all listeners.
        devices: reference devices in the file.
        options: of the export.
        measured: takes over the decoded signal.
    """
    part = body_part_of(listener)
    channel: JsonObject = {
        "id": number,
        "description": listener.name,
        "gain": 1,
        "mixing_coefficient": 1,
        "body_part_mask": 0 if part is None else part.mpeg_mask,
    }
    if part is not None:
        channel["body_part_target"] = list(part.mpeg_target)
        channel["reference_device_id"] = next(
            device["id"] for device in devices if device["name"] == _DEVICES[part.wyvrn_target]
        )
    yield (
        compact(
            {**channel, "frequency_sampling": tracks.sample_rate, "sample_count": tracks.count}
        )[:-1]
        + ',"bands":['
    )
    row = tracks.row(number)
    transients = np.zeros((0, 2))
    if options["transients"]:
        row, transients = without_transients(row, listener.impacts, 1 / TIMESCALE)
    bands = _bands(row, options["error"], number, transients, measured)
    texts = [band.text() for _, band in sorted(bands.items())]
    if len(transients):
        texts.append(compact(_transient_band(transients)))
    yield ",".join(texts) + "]}"


def _bands(
    row: Row,
    error: float,
    listener: int,
    transients: FloatArray,
    measured: Comparison,
) -> dict[int, _Band]:
    """The vectorial bands of a channel by their place among `EDGES`.

    Args:
        row: the samples without transients.
        error: of the fit.
        listener: its number.
        transients: (k, 2) times and strengths.
        measured: takes the comparison.
    """
    fit = Fit(
        error=error,
        lowest=1,
        highest=HIGHEST,
        frequency_step=1,
        time_step=1 / TIMESCALE,
        signed=True,
    )
    found: dict[int, _Band] = {}
    narrow = bands_for(row, EDGES)
    player = CarrierPlayer(listener, measured)
    player.add(transient_carrier(time, strength) for time, strength in transients.tolist())
    for complete, fitted in fit_bands(row, narrow, fit):
        for band, carriers in zip(narrow, fitted, strict=True):
            place = min(bisect(EDGES, band.centre), len(EDGES) - 1)
            for carrier in carriers:
                effect = _effect(carrier)
                found.setdefault(place, _Band(EDGES[place - 1], EDGES[place])).add(carrier, effect)
                player.add(carriers_of("VectorialWave", effect, 1 / TIMESCALE))
        player.play_until(complete)
    return found


class _Band:
    """The effects of a band as text. Carriers that sound at the same time are effects that overlap:
    players add them up."""

    def __init__(self, low: float, high: float) -> None:
        self._low, self._high = low, high
        self._effects: list[tuple[int, str]] = []

    def add(self, carrier: Carrier, effect: Form) -> None:
        """Add a carrier as this effect."""
        self._low = min(self._low, float(np.min(carrier.frequencies)))
        self._high = max(self._high, float(np.max(carrier.frequencies)))
        self._effects.append((effect["position"], compact(effect)))

    def text(self) -> str:
        """The JSON text of the band, with its effects in the order of time."""
        limits = {
            "lower_frequency_limit": math.floor(self._low),
            "upper_frequency_limit": math.ceil(self._high),
        }
        effects = sorted(self._effects, key=lambda effect: effect[0])
        head = compact({"band_type": "VectorialWave", **limits})[:-1]
        return f'{head},"effects":[{",".join(text for _, text in effects)}]}}'


def _effect(carrier: Carrier) -> JsonObject:
    """The effect of a carrier. Frequency keys reach from its start to its end, since players differ
    beyond the last key.

    It lasts less than 65.535 s, so that positions of keyframes have 16 bits in the binary form.
    """
    length = round((carrier.end - carrier.start) * TIMESCALE)
    keyframes: dict[int, JsonObject] = {}

    def key(name: str, times: FloatArray, values: FloatArray) -> None:
        positions = np.rint(times * TIMESCALE).astype(np.int64)
        inside = positions < length
        ends = np.interp([0.0, length / TIMESCALE], times, values)
        for position, value in (
            (0, ends[0]),
            *zip(positions[inside].tolist(), values[inside].tolist(), strict=True),
            (length, ends[1]),
        ):
            number = round(value) if name == "frequency_modulation" else round(float(value), 5)
            keyframes.setdefault(position, {"relative_position": position})[name] = number

    key("amplitude_modulation", carrier.amplitude_times, carrier.amplitudes)
    key("frequency_modulation", carrier.frequency_times, carrier.frequencies)
    return {
        "effect_type": "Basis",
        "position": round(carrier.start * TIMESCALE),
        "phase": min(round(carrier.phase, 5), 6.28318),
        "base_signal": "Sine",
        "keyframes": [keyframes[position] for position in sorted(keyframes)],
    }


def _transient_band(transients: FloatArray) -> JsonObject:
    frequency = round(TRANSIENT_CYCLES / TRANSIENT_SECONDS)
    return {
        "band_type": "Transient",
        "lower_frequency_limit": 0,
        "upper_frequency_limit": HIGHEST,
        "effects": [
            {
                "effect_type": "Basis",
                "position": round(time * TIMESCALE),
                "keyframes": [
                    {
                        "relative_position": 0,
                        "amplitude_modulation": round(strength, 4),
                        "frequency_modulation": frequency,
                    }
                ],
            }
            for time, strength in transients.tolist()
        ],
    }
