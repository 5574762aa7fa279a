"""WYVRN: a folder for its players with a configuration and a ``.haps`` clip (version 5) per
listener, all played by one event."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.error import FormatError
from ...core.formats.io.file_names import file_stem, file_stems
from ...core.formats.io.json_text import write_compact, write_json
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import read_json
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import ListenerTrack, Row, Tracks
from ...core.formats.tracks.track_export import TrackExport, body_part_of, common_losses
from ...core.formats.tracks.vibration_file import VibrationFile
from ...core.forms import Form, JsonObject
from ..keyframes.bands import wide_bands
from ..keyframes.carrier import Carrier, compare_carriers
from ..keyframes.channel import KeyframedChannel
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.files import json_points
from ..keyframes.fitting import Fit, fit_bands
from ..keyframes.left_out import without_damaged
from ..keyframes.transients import TRANSIENT_SECONDS, transient_carrier, without_transients

BANDS = wide_bands((5, 90, 430))
"""The bands of the melodies: published clips have at most three, and frequencies up to 366 Hz."""
SHORTEST = 0.01
"""Minimum time between keys (seconds): the densest published clip has 169 keys a second."""
CONFIGURATIONS = ("haptic.config", "Wyvrn.config")
"""Names of the configuration that players look for: the second one is that of newer development
kits. Both have the same content."""


_VERSION_5 = Path(__file__).with_name("haps_v5.schema.json")
_VERSION_6 = Path(__file__).with_name("haps_v6.schema.json")
_PARTS = (
    ("m_vibration", "m_melodies", "*"),
    ("m_vibration", "m_melodies", "*", "m_notes", "*"),
    ("vibration", "melodies", "*"),
    ("vibration", "melodies", "*", "notes", "*"),
)


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the folder does not carry, one sentence each."""
    tracks = export.need_tracks()
    shared: dict[tuple[str, str], list[str]] = {}
    for listener in tracks.listeners:
        shared.setdefault(_target(listener), []).append(listener.name)
    yield from common_losses(tracks, body=True)
    yield (
        f"frequencies below {BANDS[0].low:.0f} and above {BANDS[-1].high:.0f} Hz, and more "
        "than two oscillations at a time"
    )
    yield f"changes within {SHORTEST * 1000:g} ms"
    for (target, side), names in shared.items():
        if len(names) > 1:
            yield f"that {', '.join(names)} are different places: {target}, {side} is one target"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.WAVE, BANDS[0].low, BANDS[-1].high), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>/haptic.config``, ``<scene>/Wyvrn.config`` and
    ``<scene>/<scene>.<listener>.haps``."""
    tracks = export.need_tracks()
    inside = folder / file_stem(export.name)
    inside.mkdir(parents=True, exist_ok=True)
    stems = file_stems(f"{export.name}.{listener.name}" for listener in tracks.listeners)
    files = []
    for number, (listener, stem) in enumerate(zip(tracks.listeners, stems, strict=True)):
        clip = _clip(tracks.row(number), listener, options)
        compare_carriers(number, _carriers_of(clip, {}), measured)
        files.append(write_compact(inside / f"{stem}.haps", clip))
    events = [
        {
            "Haptic_Effect": stem,
            "Loop": 1,
            "Mixing": "Merge",
            "Targeting": [
                dict(
                    zip(
                        ("Target", "Spatialization", "Gain"), (*_target(listener), 1.0), strict=True
                    )
                )
            ],
        }
        for listener, stem in zip(tracks.listeners, stems, strict=True)
    ]
    configuration = {
        "ExternalCommands": [
            {"External_Command_ID": file_stem(export.name), "Haptic_Events": events}
        ]
    }
    return [*files, *(write_json(inside / name, configuration) for name in CONFIGURATIONS)]


def _target(listener: ListenerTrack) -> tuple[str, str]:
    part = body_part_of(listener)
    return ("All", "Global") if part is None else (part.wyvrn_target, part.wyvrn_side)


def _clip(row: Row, listener: ListenerTrack, options: Form) -> JsonObject:
    """A melody of transients, and one for each band."""
    transients = np.zeros((0, 2))
    if options["transients"]:
        row, transients = without_transients(row, listener.impacts, 1e-6)
    fit = Fit(
        error=options["error"], lowest=BANDS[0].low, highest=BANDS[-1].high, shortest=SHORTEST
    )
    melodies = [
        [_burst(time, strength) for time, strength in transients.tolist()],
        *([] for _ in BANDS),
    ]
    for _, fitted in fit_bands(row, BANDS, fit):
        for notes, carriers in zip(melodies[1:], fitted, strict=True):
            notes += [_note(note) for carrier in carriers if (note := from_zero_phase(carrier))]
    return {
        "m_version": "5",
        "m_description": listener.name,
        "m_HDFlag": 0,
        "m_time_unit": 0,
        "m_length_unit": 7,
        "m_gain": 1.0,
        "m_stiffness": {**_MELODIES, "m_melodies": []},
        "m_texture": {**_MELODIES, "m_melodies": []},
        "m_vibration": {
            **_MELODIES,
            "m_melodies": [{"m_mute": 0, "m_gain": 1.0, "m_notes": notes} for notes in melodies],
        },
    }


_MELODIES = {"m_loop": 0, "m_maximum": 1.0, "m_gain": 1.0, "m_signalEvaluationMethod": 3}


def _burst(time: float, strength: float) -> JsonObject:
    note = {
        "m_startingPoint": round(time, 6),
        "m_length": TRANSIENT_SECONDS,
        "m_priority": 0,
        "m_gain": strength,
    }
    return {**note, "m_hapticEffect": {"m_type": 0}}


def from_zero_phase(carrier: Carrier) -> Carrier | None:
    """The carrier from the beginning of its first whole cycle on, because notes have no phase; None
    if there is none."""
    missing = (-carrier.phase / (2 * math.pi)) % 1.0
    if missing < 1e-6:
        return carrier
    times = np.linspace(0.0, carrier.end - carrier.start, 4001)[
        : 2 + int(4000 * min(1.0, 1.0 / (carrier.end - carrier.start)))
    ]
    cycles = carrier.cycles(times)
    begin = float(np.interp(missing, cycles, times))
    return carrier.part(begin, carrier.end - carrier.start) if cycles[-1] > missing else None


def _note(carrier: Carrier) -> JsonObject:
    length = round(carrier.end - carrier.start, 6)

    def modulation(times: FloatArray, values: FloatArray, digits: int) -> JsonObject:
        inside = times < length
        first = times[:1] > 0
        every = np.concatenate([np.zeros(1)[first], times[inside], [length]])
        levels = np.concatenate(
            [values[:1][first], values[inside], [np.interp(length, times, values)]]
        )
        keys = json_points("m_time", "m_value", every.round(6), levels.round(digits))
        return {"m_extrapolationStrategy": 0, "m_keyframes": keys}

    amplitude = modulation(carrier.amplitude_times, carrier.amplitudes, 5)
    frequency = modulation(carrier.frequency_times, carrier.frequencies, 3)
    effect = {"m_amplitudeModulation": amplitude, "m_frequencyModulation": frequency}
    return {
        "m_startingPoint": round(carrier.start, 6),
        "m_length": length,
        "m_priority": 1,
        "m_gain": 1.0,
        "m_hapticEffect": effect,
    }


def read(path: Path) -> VibrationFile:
    """The vibration of a ``.haps`` clip of version 5 or 6; texture and stiffness are ignored.
    Raises FormatError or OSError."""
    document = read_json(path)
    losses: dict[str, None] = {}
    version = str(document.get("version", "5")) if isinstance(document, dict) else "5"
    if version == "6":
        without_damaged(document, _PARTS, losses, lambda: validate(document, _VERSION_6, path))
        document = _as_version_5(document, losses)
    elif version != "5":
        raise FormatError(path, "/version", f"this reads versions 5 and 6, not {version[:20]}")
    else:
        if isinstance(document, dict):
            for part in ("texture", "stiffness"):
                ignored = document.pop(f"m_{part}", None)
                if isinstance(ignored, dict) and ignored.get("m_melodies"):
                    losses[f"{part} is not read"] = None
        without_damaged(document, _PARTS, losses, lambda: validate(document, _VERSION_5, path))
    carriers = tuple(_carriers_of(document, losses))
    end = max((carrier.end for carrier in carriers), default=0.0)
    name = document.get("m_description") or path.stem
    return VibrationFile((KeyframedChannel(name, end, carriers=carriers),), tuple(losses))


def _as_version_5(document: Form, losses: dict[str, None]) -> JsonObject:
    """A clip of version 6, whose pitch is a share of a range of frequencies, in the form of version
    5."""
    vibration = document["vibration"]
    low = vibration["frequency_range"]["min"]
    high = vibration["frequency_range"]["max"]
    if vibration.get("transients"):
        losses["transients of version 6 are not read: no published clip has one"] = None

    def modulation(curve: Form, least: float, scale: float) -> JsonObject:
        if curve["interpolation_function"] != "Linear":
            losses[f"{curve['interpolation_function'][:20]} curves are read as straight lines"] = (
                None
            )
        keys = [
            {"m_time": key["position"], "m_value": least + scale * curve["gain"] * key["value"]}
            for key in curve["keyframes"]
        ]
        return {"m_keyframes": keys}

    def note(form: Form) -> JsonObject:
        effect = {
            "m_amplitudeModulation": modulation(form["amplitude"], 0.0, 1.0),
            "m_frequencyModulation": modulation(form["pitch"], low, high - low),
        }
        return {
            "m_startingPoint": form["position"],
            "m_length": form["length"],
            "m_gain": form["m_gain"],
            "m_hapticEffect": effect,
        }

    melodies = [
        {
            "m_mute": melody["mute"],
            "m_gain": melody["gain"],
            "m_notes": [note(form) for form in melody["notes"]],
        }
        for melody in vibration["melodies"]
    ]
    vibrations = {"m_gain": vibration["gain"], "m_melodies": melodies}
    return {
        "m_description": document.get("description"),
        "m_gain": document["gain"],
        "m_vibration": vibrations,
    }


def _carriers_of(document: Form, losses: dict[str, None]) -> Iterator[Carrier]:
    """The oscillations and transients of a clip."""
    gain = document["m_gain"] * document["m_vibration"]["m_gain"]
    for melody in document["m_vibration"]["m_melodies"]:
        if not melody["m_mute"]:
            for note in melody["m_notes"]:
                yield from _carriers(note, gain * melody["m_gain"] * note["m_gain"], losses)


def _carriers(note: Form, gain: float, losses: dict[str, None]) -> Iterator[Carrier]:
    start = note["m_startingPoint"]
    effect = note["m_hapticEffect"]
    if "m_type" in effect:
        yield transient_carrier(start, gain)
        return
    keys = []
    for name in ("m_amplitudeModulation", "m_frequencyModulation"):
        keyframes: Sequence[Mapping[str, float]] = effect[name]["m_keyframes"]
        if not keyframes:
            return
        times, values = (
            np.array([key[name] for key in keyframes], dtype=np.float64)
            for name in ("m_time", "m_value")
        )
        if (times[1:] < times[:-1]).any():
            losses["keyframes that are not in the order of time are sorted"] = None
            order = np.argsort(times, kind="stable")
            times = times[order]
            values = values[order]
        keys.append((times, values))
    if note["m_length"] > 0:
        (times, values), frequencies = keys
        yield Carrier(start, start + note["m_length"], 0.0, times, values * gain, *frequencies)
