"""Integers written with a point, the least times and the largest samples that files can hold, and
side-cars that are no files."""

import json
import os
import wave

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.motion import encoded
from haptic_tracing.core.formats.scene.recording import RecordedFrame, Recording, traced
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Pose

TETRAHEDRON = {
    "type": "mesh",
    "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}


def with_points(value):
    """Every integer of a document as a number with a point, as some programs write all numbers."""
    if isinstance(value, dict):
        return {key: with_points(member) for key, member in value.items()}
    if isinstance(value, list):
        return [with_points(member) for member in value]
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def test_integers_may_be_written_with_a_point(tmp_path):
    crate = HapticObject("crate", 0.3, 0.8, pose=Pose())
    frames = [RecordedFrame(number) for number in (1, 2, 3)]
    tracks = Tracks((ListenerTrack("hand", "hand.L"),), 8000, np.zeros((1, 80)))
    write_export(
        Export("a", HapticScene((crate,)), tracks, Recording(24, 1, tuple(frames))),
        tmp_path / "a.json",
        tracks="inline",
    )
    document = json.loads((tmp_path / "a.json").read_text())
    poses = encoded(np.array([[k, 0, 0, 100_000, 0, 0, 0] for k in range(3)]))
    document["motions"] = [{"object": "crate", "frame": 1, "count": 3, "poses": poses}]
    document["settings"]["max_connections"] = 7
    document["objects"].append({"name": "rock", "kappa": 0, "rho": 1, "shape": TETRAHEDRON})
    looped = {"signal": "loop", "of": {"signal": "impulse", "width": 1}, "count": 3}
    document["sources"] = [
        {"name": "drum", "object": "rock", "position": [0, 0, 0], "signal": looped}
    ]
    (tmp_path / "b.json").write_text(json.dumps(document))
    (tmp_path / "c.json").write_text(json.dumps(with_points(document)))
    expected, found = read_export(tmp_path / "b.json"), read_export(tmp_path / "c.json")
    assert found.scene == expected.scene and found.recording == expected.recording
    for export, name in ((expected, "d.json"), (found, "e.json")):
        write_export(export, tmp_path / name, tracks="inline")
    assert json.loads((tmp_path / "d.json").read_text()) == json.loads(
        (tmp_path / "e.json").read_text()
    )
    first, second = (
        next(iter(traced(export.scene, export.recording))) for export in (expected, found)
    )
    assert [source.signal for source in first.sources] == [
        source.signal for source in second.sources
    ]


LEAST_TIME = 5e-324
KEYS = [LEAST_TIME, 0.5]


def haptic(times):
    points = [{"time": time, "amplitude": 0.5} for time in (0.0, *times)]
    envelopes = {
        "amplitude": points,
        "frequency": [{"time": time, "frequency": 0.5} for time in (0.0, *times)],
    }
    return {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "metadata": {},
        "signals": {"continuous": {"envelopes": envelopes}},
    }


def ahap(times):
    points = [{"Time": time, "ParameterValue": 0.5} for time in (0.0, *times)]
    curve = {
        "ParameterCurve": {
            "ParameterID": "HapticIntensityControl",
            "Time": 0.0,
            "ParameterCurveControlPoints": points,
        }
    }
    event = {
        "Time": LEAST_TIME,
        "EventType": "HapticContinuous",
        "EventDuration": 0.5,
        "EventParameters": [],
    }
    return {"Version": 1.0, "Pattern": [{"Event": event}, curve]}


def haps(times):
    keys = [{"m_time": time, "m_value": 0.5} for time in (0.0, *times)]
    effect = {
        "m_amplitudeModulation": {"m_extrapolationStrategy": 0, "m_keyframes": keys},
        "m_frequencyModulation": {
            "m_extrapolationStrategy": 0,
            "m_keyframes": [{**key, "m_value": 90.0} for key in keys],
        },
    }
    note = {
        "m_startingPoint": LEAST_TIME,
        "m_length": 0.5,
        "m_priority": 1,
        "m_gain": 1.0,
        "m_hapticEffect": effect,
    }
    melody = {"m_mute": 0, "m_gain": 1.0, "m_notes": [note]}
    vibration = {
        "m_loop": 0,
        "m_maximum": 1.0,
        "m_gain": 1.0,
        "m_signalEvaluationMethod": 3,
        "m_melodies": [melody],
    }
    return {"m_version": "5", "m_gain": 1.0, "m_length_unit": 7, "m_vibration": vibration}


@pytest.mark.parametrize(
    ("suffix", "make"), [(".haptic", haptic), (".ahap", ahap), (".haps", haps)]
)
@pytest.mark.plugins
def test_keys_at_the_least_time_give_numbers(tmp_path, suffix, make):
    path = tmp_path / f"least{suffix}"
    path.write_text(json.dumps(make(KEYS)))
    (channel,) = registry.read(path).channels
    samples = channel.at_rate(8000)
    assert len(samples) >= 3999 and np.isfinite(samples).all() and np.abs(samples).max() > 0.05


@pytest.mark.parametrize("value", [6e37, -3.4e38, np.inf, np.nan])
def test_samples_of_any_size_are_no_vibration_or_are_cut(tmp_path, value):
    samples = np.full(800, 0.25, dtype="<f4")
    samples[400] = value
    data = samples.tobytes()
    head = (
        b"RIFF" + (36 + len(data)).to_bytes(4, "little") + b"WAVEfmt " + (16).to_bytes(4, "little")
    )
    head += (
        (3).to_bytes(2, "little")
        + (1).to_bytes(2, "little")
        + (8000).to_bytes(4, "little")
        + (32000).to_bytes(4, "little")
    )
    head += (
        (4).to_bytes(2, "little")
        + (32).to_bytes(2, "little")
        + b"data"
        + len(data).to_bytes(4, "little")
    )
    (tmp_path / "loud.wav").write_bytes(head + data)
    try:
        (channel,) = registry.read(tmp_path / "loud.wav").channels
        found = channel.at_rate(3000)
        resampled = channel.to_signal().sample(0, 100, 11025.0)
    except FormatError as error:
        assert "finite" in str(error) or "sample" in str(error)
        return
    assert np.isfinite(found).all() and np.isfinite(resampled).all()
    assert np.isfinite(np.float32(found)).all()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such files")
@pytest.mark.parametrize(
    "name", ["scene.json", pytest.param("hand.haptic", marks=pytest.mark.plugins), "take.wav"]
)
def test_a_pipe_beside_a_file_does_not_hang(tmp_path, name):
    """Readers look for side-cars by themselves; a pipe that nobody writes to never ends."""
    path = tmp_path / name
    if name == "scene.json":
        tracks = {"sample_rate": 8000, "file": "scene.tracks.wav", "listeners": [{"name": "hand"}]}
        path.write_text(
            json.dumps(
                {"format": "haptic-scene", "version": "1.1", "objects": [], "tracks": tracks}
            )
        )
        os.mkfifo(tmp_path / "scene.tracks.wav")
        with pytest.raises(FormatError, match="not a regular file"):
            read_export(path)
        return
    if name == "hand.haptic":
        path.write_text(json.dumps(haptic([0.5])))
        os.mkfifo(tmp_path / "hand.acf")
    else:
        with wave.open(str(path), "wb") as file:
            file.setnchannels(1)
            file.setsampwidth(2)
            file.setframerate(8000)
            file.writeframes(bytes(1600))
        os.mkfifo(tmp_path / "take.wav.json")
    assert len(registry.read(path).channels) == 1
