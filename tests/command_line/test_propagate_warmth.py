"""``haptic-tracing propagate`` on a file with warmth: what its listeners feel of it, against the
closed form."""

import json
import math

import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.modalities.thermal import JOINT

STONE = {"conductivity": 2.8, "thickness": 0.3}
SCENE = {
    "format": "haptic-scene",
    "version": "1.1",
    "objects": [
        {"name": "hearth", "kappa": 0.2, "rho": 0.9},
        {"name": "bench", "kappa": 0.1, "rho": 0.8},
    ],
    "contacts": [{"objects": ["hearth", "bench"], "positions": [[0.4, 0, 0], [0.4, 0, 0]]}],
    "listeners": [{"name": "seat", "object": "bench", "position": [1.2, 0, 0]}],
    "modalities": {
        "thermal": {
            "objects": [
                {"object": "hearth", "values": STONE},
                {"object": "bench", "values": STONE},
            ],
            "sources": [{"name": "fire", "object": "hearth", "position": [0, 0, 0], "value": 60}],
        }
    },
}


def test_what_is_felt_is_printed(tmp_path, capsys):
    path = tmp_path / "fire.json"
    path.write_text(json.dumps(SCENE))
    assert main(["propagate", str(path)]) == 0
    printed = json.loads(capsys.readouterr().out)
    m = math.sqrt(20 / (2.8 * 0.3))
    expected = 60 * math.exp(-m * 1.2) * JOINT / (JOINT + 2.8 * m)
    assert printed["modalities"] == {
        "thermal": {
            "unit": "K",
            "felt": [{"listener": "seat", "value": pytest.approx(expected, rel=1e-12)}],
        }
    }
    assert printed["gains"] == []


def test_nothing_is_added_where_it_is_off_or_not_there(tmp_path, capsys):
    path = tmp_path / "cold.json"
    for section in (
        {},
        {"modalities": {"thermal": {**SCENE["modalities"]["thermal"], "enabled": False}}},
    ):
        path.write_text(
            json.dumps(
                {key: value for key, value in SCENE.items() if key != "modalities"} | section
            )
        )
        assert main(["propagate", str(path)]) == 0
        assert json.loads(capsys.readouterr().out).keys() == {"gains", "strategy", "statistics"}


def test_a_bad_section_is_one_line_with_its_place(tmp_path, capsys):
    path = tmp_path / "bad.json"
    path.write_text(
        json.dumps({**SCENE, "modalities": {"thermal": {"sources": [{"name": "fire"}]}}})
    )
    assert main(["propagate", str(path)]) == 2
    assert (
        capsys.readouterr()
        .err.strip()
        .endswith("/modalities/thermal/sources/0/object: is required")
    )
