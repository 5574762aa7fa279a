"""Small files whose content would be large: read or refused within 64 MB and 50 times their
size."""

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from carriers import values_at
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.io.error import FormatError

CORPUS = Path(__file__).parents[2] / "core" / "formats" / "corpus"


def read(path):
    """What is in a file, None if it is refused in one line that names it; within the memory for its
    size."""
    tracemalloc.start()
    try:
        return registry.read(path)
    except FormatError as error:
        assert str(error).startswith(f"{path}: ") and len(str(error)) < 600
        return None
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak <= 64 * 2**20 + 50 * path.stat().st_size


def ahap(path, points, events):
    curve = {"ParameterID": "HapticIntensityControl", "Time": 0.0}
    curve["ParameterCurveControlPoints"] = [
        {"Time": time, "ParameterValue": value} for time, value in points
    ]
    pattern = [{"ParameterCurve": curve}]
    pattern += [
        {
            "Event": {
                "EventType": "HapticContinuous",
                "Time": start,
                "EventDuration": length,
                "EventParameters": [],
            }
        }
        for start, length in events
    ]
    path.write_text(json.dumps({"Version": 1.0, "Pattern": pattern}))
    return path


def test_a_curve_between_huge_values_is_that_within_the_limits(tmp_path):
    """700 bytes that took gigabytes: the curve is of use only where it is between 0 and 1."""
    path = ahap(
        tmp_path / "x.ahap",
        [(0, -1e6), (1, 1e6), (2, -1e6), (3, 0.25), (4, 0.75), (5, 3.0)],
        [(0, 6)],
    )
    (channel,) = read(path).channels
    times = np.array([0.4, 0.6, 1.0, 1.4, 1.6, 2.5, 3.0, 3.5, 4.0, 4.05, 4.2, 5.0])
    expected = (
        np.clip(np.interp(times, [0, 1, 2, 3, 4, 5], [-1e6, 1e6, -1e6, 0.25, 0.75, 3.0]), 0, 1) ** 2
    )
    (carrier,) = channel.carriers
    assert np.interp(times, carrier.amplitude_times, carrier.amplitudes) == pytest.approx(
        expected, abs=0.001
    )


def test_many_events_that_share_a_long_curve_are_refused(tmp_path):
    points = [(k, k % 2) for k in range(5000)]
    assert read(ahap(tmp_path / "x.ahap", points, [(0, 5000)] * 2000)) is None


def changed(document, **values):
    """Replace every value that has one of these keys."""
    for key, value in document.items() if isinstance(document, dict) else enumerate(document):
        if key in values:
            document[key] = values[key]
        elif isinstance(value, dict | list):
            changed(value, **values)
    return document


@pytest.mark.parametrize(
    "values",
    [
        {"block_length": 1},
        {"block_length": 8, "upper_frequency_limit": 1000},
        {"block_length": 16, "upper_frequency_limit": 1000},
        {"position": 1_000_000_000},
        {"position": 30_000_000, "upper_frequency_limit": 10_000},
    ],
)
def test_wavelets_of_any_block_and_place(tmp_path, values):
    document = changed(json.loads((CORPUS / "good-wavelet.hjif").read_bytes()), **values)
    path = tmp_path / "x.hjif"
    path.write_text(json.dumps(document))
    read(path)


@pytest.mark.slow
def test_an_effect_of_many_keys_that_is_referred_to_often_is_refused(tmp_path):
    document = json.loads((CORPUS / "good.hjif").read_bytes())
    (perception, *_) = document["perceptions"]
    keys = [
        {"relative_position": k, "amplitude_modulation": k % 2, "frequency_modulation": 100}
        for k in range(5000)
    ]
    perception["effect_library"] = [
        {
            "id": 1,
            "effect_type": "Basis",
            "position": 0,
            "phase": 0,
            "base_signal": "Sine",
            "keyframes": keys,
        }
    ]
    (band, *_) = perception["channels"][0]["bands"]
    band |= {
        "band_type": "VectorialWave",
        "effects": [{"id": 1, "effect_type": "Reference", "position": k} for k in range(5000)],
    }
    path = tmp_path / "x.hjif"
    path.write_text(json.dumps(document))
    assert read(path) is None


def tact(path, feedback, length, positions=("VestFront", "VestBack"), kind="dotMode"):
    document = json.loads((CORPUS / "good.tact").read_bytes())
    modes = {"mode": "DOT_MODE", "dotMode": {"feedback": []}, "pathMode": {"feedback": []}} | {
        kind: {"feedback": feedback}
    }
    modes["mode"] = "DOT_MODE" if kind == "dotMode" else "PATH_MODE"
    effect = {
        "name": "x",
        "startTime": 0,
        "offsetTime": length,
        "modes": dict.fromkeys(positions, modes),
    }
    document["project"]["tracks"] = [{"enable": True, "effects": [effect]}]
    path.write_text(json.dumps(document))
    return path


def dots(start, end, index=0):
    return {
        "startTime": start,
        "endTime": end,
        "playbackType": "FADE_IN",
        "pointList": [{"index": index, "intensity": 0.5}],
    }


def test_the_index_of_a_motor_may_be_a_whole_number_with_a_point(tmp_path):
    one, other = (
        read(tact(tmp_path / "x.tact", [dots(0, 400, index)], 400)).channels for index in (2, 2.0)
    )
    assert [channel.name for channel in one] == [channel.name for channel in other] != []
    times = np.arange(0.0, 0.4, 0.001)
    for a, b in zip(one, other, strict=True):
        assert (values_at(a.carriers[0], times) == values_at(b.carriers[0], times)).all()


def test_an_hour_of_a_vest_is_read(tmp_path):
    assert read(tact(tmp_path / "x.tact", [dots(0, 3_600_000)], 3_600_000)).channels
    path = [
        {"x": 0.1, "y": 0.2, "intensity": 1, "time": 0},
        {"x": 0.9, "y": 0.2, "intensity": 1, "time": 3_600_000},
    ]
    moved = [{"movingPattern": "CONST_TDM", "playbackType": "NONE", "pointList": path}]
    assert read(tact(tmp_path / "x.tact", moved, 3_600_000, kind="pathMode")).channels


def test_many_short_effects_in_an_hour_are_read_at_once(tmp_path):
    """Each looks at its own steps alone."""
    assert read(
        tact(tmp_path / "x.tact", [dots(20 * k, 20 * k + 40) for k in range(500)], 3_600_000)
    ).channels
