"""HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31): a channel per listener, vectorial waves and transients.

Times are in milliseconds: the reference renderer counts phases in them whatever the timescale says.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...scene.body import BODY_PARTS
from ..io.atomic import write_text
from ..io.catalogue import FORMATS
from ..io.error import FormatError
from ..io.json_text import compact
from ..io.schema import validate
from ..io.strict_json import read_json
from .bands import bands_for
from .carrier import Carrier
from .fitting import Fit, fit_bands
from .listener_tracks import ListenerTrack, Tracks
from .track_export import TrackExport, body_part_of, clipped, common_losses, scene_file
from .transients import TRANSIENT_CYCLES, TRANSIENT_SECONDS, without_transients
from .vibration_file import Channel, VibrationFile

SUFFIX = FORMATS["hjif"].suffix

TIMESCALE = 1000
LONGEST_EFFECT = 65_535
"""Milliseconds: a keyframe's position has 16 bits in the binary form."""
CHANNELS_OF_LEVEL_1 = 127
HIGHEST = 1000
"""Hertz."""
EDGES = (5, 40, 80, 160, 320, 640, 860)
"""Of the bands, in hertz. With that of the transients they are as many as level 1 allows a channel."""

_DEVICES = {
    "Head": "Razer Kraken V4 Pro",
    "Hand": "Razer Wolverine V3 Pro",
    "Chest": "Razer Freyja",
    "Waist": "Razer Freyja",
    "Leg": "Razer Freyja",
}


def loss(export: TrackExport, options: Mapping[str, Any]) -> tuple[str, ...]:
    """What the file leaves out, in words."""
    tracks = export.need_tracks()
    return (
        *common_losses(tracks, body=True),
        f"what lies below {EDGES[0]} and above {EDGES[-1]} Hz",
        f"up to {options['error']:.1%} of the vibration's power, and the order of what is less than a millisecond apart",
    )


def write(export: TrackExport, folder: Path, options: Mapping[str, Any]) -> list[Path]:
    """Write ``<scene>.hjif``."""
    tracks = export.need_tracks()
    path = scene_file(export.name, folder, SUFFIX)
    return [write_text(path, _document(export, tracks, options))]


def _document(export: TrackExport, tracks: Tracks, options: Mapping[str, Any]) -> Iterator[str]:
    devices = _reference_devices(tracks)
    head = {
        "version": "2023",
        "profile": options["profile"],
        "level": 1 if len(tracks.listeners) <= CHANNELS_OF_LEVEL_1 else 2,
        "date": export.date,
        "description": f"{export.name}, by Haptic Tracing",
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
        yield (",\n" if number else "\n") + compact(_channel(number, listener, tracks, devices, options))
    yield '\n]}],"syncs":[{"timestamp":0}]}\n'


def _reference_devices(tracks: Tracks) -> list[dict[str, Any]]:
    names = dict.fromkeys(_DEVICES[part.wyvrn_target] for listener in tracks.listeners if (part := body_part_of(listener)) is not None)
    return [
        {"id": number, "name": name, "type": "VCA", "minimum_frequency": 20, "maximum_frequency": 300}
        for number, name in enumerate(names, start=1)
    ]


def _channel(
    number: int, listener: ListenerTrack, tracks: Tracks, devices: list[dict[str, Any]], options: Mapping[str, Any]
) -> dict[str, Any]:
    samples = clipped(tracks.samples[number]).astype(np.float64)
    transients = np.zeros((0, 2))
    if options["transients"]:
        samples, transients = without_transients(samples, tracks.sample_rate, listener.impacts, 1 / TIMESCALE)
    fit = Fit(error=options["error"], lowest=1, highest=HIGHEST, frequency_step=1, time_step=1 / TIMESCALE, signed=True)
    narrow = bands_for(samples, tracks.sample_rate, EDGES)
    grouped: dict[int, list[Carrier]] = {}
    for band, carriers in zip(narrow, fit_bands(samples, tracks.sample_rate, narrow, fit), strict=True):
        grouped.setdefault(min(bisect(EDGES, band.centre), len(EDGES) - 1), []).extend(carriers)
    bands = [_wave_band(EDGES[k - 1], EDGES[k], carriers) for k, carriers in sorted(grouped.items()) if carriers]
    if len(transients):
        bands.append(_transient_band(transients))
    part = body_part_of(listener)
    channel: dict[str, Any] = {
        "id": number,
        "description": listener.name,
        "gain": 1,
        "mixing_coefficient": 1,
        "body_part_mask": 0 if part is None else part.mpeg_mask,
    }
    if part is not None:
        channel["body_part_target"] = list(part.mpeg_target)
        channel["reference_device_id"] = next(device["id"] for device in devices if device["name"] == _DEVICES[part.wyvrn_target])
    return {**channel, "frequency_sampling": tracks.sample_rate, "sample_count": tracks.count, "bands": bands}


def _wave_band(low: float, high: float, carriers: list[Carrier]) -> dict[str, Any]:
    """Carriers that sound at the same time are effects that overlap: players add them up."""
    effects = [_effect(piece) for carrier in carriers for piece in _pieces(carrier)]
    effects.sort(key=lambda effect: effect["position"])
    lowest = min(float(np.min(carrier.frequencies)) for carrier in carriers)
    highest = max(float(np.max(carrier.frequencies)) for carrier in carriers)
    return {
        "band_type": "VectorialWave",
        "lower_frequency_limit": math.floor(min(low, lowest)),
        "upper_frequency_limit": math.ceil(max(high, highest)),
        "effects": effects,
    }


def _pieces(carrier: Carrier) -> Iterator[Carrier]:
    """The carrier in pieces that an effect can hold. They meet where the wave crosses zero: players add up both at that moment."""
    length = LONGEST_EFFECT / TIMESCALE
    while carrier.end - carrier.start > length:
        ticks = np.arange(LONGEST_EFFECT - 100, LONGEST_EFFECT + 1) / TIMESCALE
        cycles = carrier.phase / (2 * math.pi) + carrier.cycles(ticks)
        cut = float(ticks[np.argmin(np.abs(np.sin(2 * math.pi * cycles)))])
        yield carrier.part(0.0, cut)
        carrier = carrier.part(cut, carrier.end - carrier.start)
    yield carrier


def _effect(carrier: Carrier) -> dict[str, Any]:
    """Frequencies are keyed from the first moment to the last: what players do beyond the last key differs."""
    length = round((carrier.end - carrier.start) * TIMESCALE)
    keyframes: dict[int, dict[str, Any]] = {}

    def key(name: str, times: FloatArray, values: FloatArray) -> None:
        positions = np.rint(times * TIMESCALE).astype(np.int64)
        inside = positions < length
        ends = np.interp([0.0, length / TIMESCALE], times, values)
        for position, value in ((0, ends[0]), *zip(positions[inside].tolist(), values[inside].tolist(), strict=True), (length, ends[1])):
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


def _transient_band(transients: FloatArray) -> dict[str, Any]:
    frequency = round(TRANSIENT_CYCLES / TRANSIENT_SECONDS)
    return {
        "band_type": "Transient",
        "lower_frequency_limit": 0,
        "upper_frequency_limit": HIGHEST,
        "effects": [
            {
                "effect_type": "Basis",
                "position": round(time * TIMESCALE),
                "keyframes": [{"relative_position": 0, "amplitude_modulation": round(strength, 4), "frequency_modulation": frequency}],
            }
            for time, strength in transients.tolist()
        ],
    }


_WAVE = {"Sine": ("sine", 1), "Square": ("square", 1), "Triangle": ("triangle", 1), "SawToothUp": ("saw", 1), "SawToothDown": ("saw", -1)}


def read(path: Path) -> VibrationFile:
    """The channels of all perceptions. Raises FormatError or OSError."""
    document = read_json(path)
    validate(document, "hjif", path)
    channels: list[Channel] = []
    losses: dict[str, None] = {}
    for p, perception in enumerate(document["perceptions"]):
        library = {effect["id"]: effect for effect in perception["effect_library"] if "id" in effect}
        for c, form in enumerate(perception["channels"]):
            place = f"/perceptions/{p}/channels/{c}"
            read_bands = _BandReader(path, document["timescale"], library, losses)
            carriers = [carrier for b, band in enumerate(form["bands"]) for carrier in read_bands(band, f"{place}/bands/{b}", form["gain"])]
            end = max((carrier.end for carrier in carriers), default=0.0)
            rate = form.get("frequency_sampling", 0)
            duration = max(end, min(form.get("sample_count", 0) / rate, 1e5)) if rate else end
            channels.append(Channel(form["description"], duration, tuple(carriers), body_part=_body_part(form)))
    return VibrationFile(tuple(channels), tuple(losses))


def _body_part(channel: Mapping[str, Any]) -> str:
    """The part that we would write so, or none."""
    place = channel["body_part_mask"], tuple(channel.get("body_part_target", ()))
    return next((part.name for part in BODY_PARTS if (part.mpeg_mask, part.mpeg_target) == place), "")


class _BandReader:
    def __init__(self, path: Path, timescale: int, library: Mapping[int, Any], losses: dict[str, None]) -> None:
        self.path = path
        self.tick = 1 / timescale
        self.library = library
        self.losses = losses

    def __call__(self, band: Mapping[str, Any], place: str, gain: float) -> Iterator[Carrier]:
        kind = band["band_type"]
        if kind == "WaveletWave":
            self.losses["wavelet bands are not decoded"] = None
            return
        for e, form in enumerate(band["effects"]):
            effect = form
            if form["effect_type"] == "Reference":
                if form["id"] not in self.library:
                    raise FormatError(self.path, f"{place}/effects/{e}/id", f"the effect library has no effect {form['id']}")
                effect = {**self.library[form["id"]], "position": form["position"]}
            if effect["effect_type"] != "Basis":
                self.losses["composite effects are not taken over"] = None
                continue
            keyframes = effect.get("keyframes", [])
            positions = [keyframe.get("relative_position", 0) for keyframe in keyframes]
            if any(later < earlier for earlier, later in pairwise(positions)):
                raise FormatError(self.path, f"{place}/effects/{e}/keyframes", "relative positions must not decrease")
            yield from self._carriers(kind, effect, keyframes, gain)

    def _carriers(self, kind: str, effect: Mapping[str, Any], keyframes: list[Mapping[str, Any]], gain: float) -> Iterator[Carrier]:
        start = effect["position"] * self.tick
        amplitudes = _keys(keyframes, "amplitude_modulation", self.tick)
        if amplitudes is None:
            return
        if kind == "Transient":
            for time, strength in zip(*amplitudes, strict=True):
                yield transient(start + float(time), float(strength) * gain)
            return
        end = start + keyframes[-1].get("relative_position", 0) * self.tick
        if end <= start:
            return
        times, values = amplitudes[0], amplitudes[1] * gain
        if kind == "Curve":
            # A curve is the vibration itself: an oscillation that stands still at its crest.
            yield Carrier(start, end, math.pi / 2, times, values, np.zeros(1), np.zeros(1))
            return
        wave, sign = _WAVE[effect.get("base_signal", "Sine")]
        frequencies = _keys(keyframes, "frequency_modulation", self.tick)
        if frequencies is not None:
            yield Carrier(start, end, effect.get("phase", 0.0), times, values * sign, *frequencies, wave)


def _keys(keyframes: list[Mapping[str, Any]], name: str, tick: float) -> tuple[FloatArray, FloatArray] | None:
    keys = [(keyframe.get("relative_position", 0), keyframe[name]) for keyframe in keyframes if name in keyframe]
    if not keys:
        return None
    times, values = np.array(keys, dtype=np.float64).T
    return times * tick, values


def transient(time: float, strength: float) -> Carrier:
    """A transient as the reference renderer has it."""
    zero, frequency = np.zeros(1), np.full(1, TRANSIENT_CYCLES / TRANSIENT_SECONDS)
    return Carrier(time, time + TRANSIENT_SECONDS, 0.0, zero, np.full(1, strength), zero, frequency)
