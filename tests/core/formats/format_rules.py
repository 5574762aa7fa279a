"""The rules of each format that its schema can't say, as the facts about the formats have them."""

import json
import struct
from itertools import pairwise
from pathlib import Path

import haptic_tracing
from haptic_tracing.core.formats.io.schema import load_schema, validate
from jsonschema import Draft7Validator

PLUGINS = Path(haptic_tracing.__file__).parent / "plugins"
SCHEMAS = {
    ".hjif": PLUGINS / "mpeg/hjif.schema.json",
    ".haptic": PLUGINS / "meta/haptic_v1.schema.json",
    ".haps": PLUGINS / "razer/haps_v5.schema.json",
    ".config": PLUGINS / "razer/wyvrn_haptic_config.schema.json",
    ".ahap": PLUGINS / "apple/ahap.schema.json",
    ".tact": PLUGINS / "bhaptics/tact.schema.json",
}
LARGE = 300_000  # bytes, from which on jsonschema is given a rest
VALIDATORS = {
    suffix: Draft7Validator(load_schema(path)) for suffix, path in SCHEMAS.items() if path.is_file()
}


def ascending(values):
    return all(a <= b for a, b in pairwise(values))


def check_hjif(document, listeners, duration):
    assert document["timescale"] == 1000
    assert {avatar["id"] for avatar in document["avatars"]} >= {
        perception["avatar_id"] for perception in document["perceptions"]
    }
    (perception,) = document["perceptions"]
    assert "effect_semantic_scheme" not in perception  # the reference software refuses it
    devices = [device["id"] for device in perception["reference_devices"]]
    assert len(set(devices)) == len(devices)
    for device in perception["reference_devices"]:
        assert device["minimum_frequency"] <= device["maximum_frequency"]
    channels = perception["channels"]
    assert [channel["id"] for channel in channels] == list(range(listeners))
    assert document["level"] == (1 if listeners <= 127 else 2)
    for channel in channels:
        assert channel.get("reference_device_id", devices[:1] and devices[0]) in [
            *devices,
            *([] if devices else [[]]),
        ]
        assert len(channel["bands"]) <= 7
        for band in channel["bands"]:
            assert band["band_type"] in ("VectorialWave", "Transient") and "curve_type" not in band
            assert band["lower_frequency_limit"] < band["upper_frequency_limit"]
            assert ascending([effect["position"] for effect in band["effects"]])
            for effect in band["effects"]:
                positions = [keyframe["relative_position"] for keyframe in effect["keyframes"]]
                assert (
                    ascending(positions)
                    and len(set(positions)) == len(positions)
                    and positions[-1] <= 65535
                )
                assert (
                    effect["effect_type"] == "Basis"
                    and effect["position"] + positions[-1] <= 1000 * duration + 50
                )
                if band["band_type"] == "VectorialWave":
                    first, last = effect["keyframes"][0], effect["keyframes"][-1]
                    # Players disagree on what holds before the first key and after the last: there
                    # is one at either end.
                    assert {
                        "amplitude_modulation",
                        "frequency_modulation",
                    } <= first.keys() & last.keys()
                    for keyframe in effect["keyframes"]:
                        frequency = keyframe.get(
                            "frequency_modulation", first["frequency_modulation"]
                        )
                        assert (
                            band["lower_frequency_limit"]
                            <= frequency
                            <= band["upper_frequency_limit"]
                            and frequency > 0
                        )


def check_haptic(document, duration):
    envelopes = document["signals"]["continuous"]["envelopes"]
    amplitude, frequency = envelopes["amplitude"], envelopes["frequency"]
    times = [point["time"] for point in amplitude]
    assert len(times) >= 2 and ascending(times) and 0 < times[-1] <= duration + 1e-3
    assert ascending([point["time"] for point in frequency])
    assert not frequency or frequency[-1]["time"] <= times[-1]
    for point in amplitude:
        assert point.get("emphasis", {"amplitude": 1})["amplitude"] >= point["amplitude"]
    assert {"editor", "source", "description"} <= document["metadata"].keys()


def check_haps(document, duration):
    melodies = document["m_vibration"]["m_melodies"]
    assert not document["m_texture"]["m_melodies"] and not document["m_stiffness"]["m_melodies"]
    for number, melody in enumerate(melodies):
        starts = [note["m_startingPoint"] for note in melody["m_notes"]]
        assert ascending(starts)
        for note in melody["m_notes"]:
            assert note["m_startingPoint"] + note["m_length"] <= duration + 0.05
            if number == 0:
                assert (
                    note["m_hapticEffect"] == {"m_type": 0}
                    and note["m_length"] == 0.022
                    and note["m_priority"] == 0
                )
                continue
            assert note["m_priority"] == 1
            for name in ("m_amplitudeModulation", "m_frequencyModulation"):
                keys = note["m_hapticEffect"][name]["m_keyframes"]
                assert ascending([key["m_time"] for key in keys])
                assert keys[0]["m_time"] == 0 and keys[-1]["m_time"] == note["m_length"]
            for key in note["m_hapticEffect"]["m_amplitudeModulation"]["m_keyframes"]:
                assert 0 <= key["m_value"] <= 1


def check_ahap(document, duration):
    sounding = []
    for entry in document["Pattern"]:
        if "Event" in entry:
            event = entry["Event"]
            assert 0 <= event["Time"] <= duration and event.get("EventDuration", 0) <= 30
            for parameter in event["EventParameters"]:
                assert 0 <= parameter["ParameterValue"] <= 1
            if event["EventType"] == "HapticContinuous":
                sounding.append((event["Time"], event["Time"] + event["EventDuration"]))
        else:
            points = entry["ParameterCurve"]["ParameterCurveControlPoints"]
            assert 1 <= len(points) <= 16
            assert points[0]["Time"] == 0 and ascending(
                [point["Time"] for point in points]
            )  # relative to the curve
            assert all(0 <= point["ParameterValue"] <= 1 for point in points)
            assert entry["ParameterCurve"]["Time"] + points[-1]["Time"] <= duration + 0.1
    assert all(end <= start + 1e-6 for (_, end), (start, _) in pairwise(sounding))


def check_tact(document, duration):
    assert document["intervalMillis"] == 20
    layouts = document["project"]["layout"]["layouts"]
    (track,) = document["project"]["tracks"]
    (effect,) = track["effects"]
    assert effect["modes"].keys() == layouts.keys()
    for position, mode in effect["modes"].items():
        indices = {motor["index"] for motor in layouts[position]}
        end = 0
        for feedback in mode["dotMode"]["feedback"]:
            assert (
                end
                <= feedback["startTime"]
                < feedback["endTime"]
                <= effect["offsetTime"]
                <= 1000 * duration + 20
            )
            end = feedback["endTime"]
            assert {point["index"] for point in feedback["pointList"]} <= indices


def check_wyvrn(document, folder):
    (command,) = document["ExternalCommands"]
    for event in command["Haptic_Events"]:
        assert (folder / f"{event['Haptic_Effect']}.haps").is_file()
        assert len(event["Targeting"]) == 1


def check_wav(data, channels, count, rate):
    assert (
        data[:4] == b"RIFF"
        and data[8:16] == b"WAVEfmt "
        and struct.unpack("<I", data[4:8])[0] == len(data) - 8
    )
    size, tag, wave_channels, wave_rate, bytes_a_second, frame, bits, extra = struct.unpack(
        "<IHHIIHHH", data[16:38]
    )
    assert (size, tag, wave_channels, wave_rate, extra) == (40, 0xFFFE, channels, rate, 22)
    assert frame == channels * bits // 8 and bytes_a_second == rate * frame
    code = struct.unpack("<H", data[44:46])[0]
    assert code == {16: 1, 32: 3}[bits] and data[46:60] == bytes.fromhex(
        "000000001000800000aa00389b71"
    )
    place = data.index(b"data", 60)
    assert (
        struct.unpack("<I", data[place + 4 : place + 8])[0]
        == len(data) - place - 8
        == count * frame
    )


def check_file(path, tracks):
    """Schema and rules of a written file."""
    suffix = path.suffix
    duration = tracks.duration
    if suffix in VALIDATORS:
        document = json.loads(path.read_bytes())
        if path.stat().st_size < LARGE:
            errors = [
                f"{list(error.path)}: {error.message[:200]}"
                for error in VALIDATORS[suffix].iter_errors(document)
            ]
            assert not errors, (path.name, errors[:3])
        else:
            validate(document, SCHEMAS[suffix], path)
        match suffix:
            case ".hjif":
                check_hjif(document, len(tracks.listeners), duration)
            case ".haptic":
                check_haptic(document, duration)
            case ".haps":
                check_haps(document, duration)
            case ".config":
                check_wyvrn(document, path.parent)
            case ".ahap":
                check_ahap(document, duration)
            case ".tact":
                check_tact(document, duration)
    elif suffix == ".wav":
        check_wav(path.read_bytes(), len(tracks.listeners), tracks.count, tracks.sample_rate)
