"""``haptic-tracing propagate``: listeners with a radius, and who is felt."""

import json
import math

import pytest
from haptic_tracing.command_line import main

SCENE = {
    "format": "haptic-scene",
    "version": "1.1",
    "objects": [
        {
            "name": "plate",
            "kappa": 0,
            "rho": 1,
            "propagation": {"function": "exponential", "alpha": 0.2},
        }
    ],
    "sources": [
        {
            "name": name,
            "object": "plate",
            "position": [4, 0, 3],
            "amplitude": amplitude,
            "signal": {"signal": "sine", "frequency": hertz},
        }
        for name, amplitude, hertz in (("saw", 1.0, 250.0), ("fan", 0.1, 240.0), ("hum", 1.0, 40.0))
    ],
    "listeners": [
        {
            "name": name,
            "object": "plate",
            "position": [0, 0, 0],
            "radius": radius,
            "gain": 2 if name == "palm" else 1,
        }
        for name, radius in (
            ("point", 0.0),
            ("palm", 2.0),
            ("belly", 50.0),
        )
    ],
}


@pytest.fixture
def printed(tmp_path, capsys):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(SCENE))
    assert main(["propagate", str(path), "--felt"]) == 0
    return json.loads(capsys.readouterr().out)


def test_distances_count_from_the_nearest_point_of_the_volume(printed):
    gains = {pair["listener"]: pair["gain"] for pair in printed["gains"] if pair["source"] == "saw"}
    assert gains == {
        name: pytest.approx(math.exp(-0.2 * away), rel=1e-12)
        for name, away in (("point", 5), ("palm", 3), ("belly", 0))
    }


def test_gain_includes_the_amplitude_path_gain_does_not_and_level_is_what_is_played(printed):
    """The levels of the tones are those of sines: 3 dB below their amplitudes, and 6 dB higher
    where the listener has a gain of 2."""
    for pair in printed["gains"]:
        amplitude = 0.1 if pair["source"] == "fan" else 1.0
        factor = 2.0 if pair["listener"] == "palm" else 1.0
        assert pair["path_gain"] == pytest.approx(pair["gain"] / amplitude, rel=1e-12)
        assert pair["level"] == pytest.approx(
            20 * math.log10(pair["gain"] * factor / math.sqrt(2)), abs=1e-3
        )


def test_a_listener_that_nothing_reaches_has_no_level(tmp_path, capsys):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps({**SCENE, "listeners": [{**SCENE["listeners"][0], "gain": 0}]}))
    assert main(["propagate", str(path)]) == 0
    assert {pair["level"] for pair in json.loads(capsys.readouterr().out)["gains"]} == {None}


def test_who_is_felt_and_who_is_hidden(printed):
    """A fan 20 dB below a saw of nearly the same frequency is hidden; the hum is not, at a
    frequency of its own."""
    felt = {
        item["source"]: (item["state"], item["masked_by"])
        for item in printed["felt"]
        if item["listener"] == "belly"
    }
    assert felt == {"saw": ("felt", None), "hum": ("felt", None), "fan": ("masked", "saw")}
    assert [item["margin"] for item in printed["felt"] if item["listener"] == "belly"] == [
        pytest.approx(45, abs=0.2), pytest.approx(13.5, abs=0.3), pytest.approx(25, abs=0.3),
    ]  # fmt: skip
