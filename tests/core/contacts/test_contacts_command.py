"""``haptic-tracing propagate --contacts`` on files: closed forms, the form of the scene file again, and errors
on one line."""

from __future__ import annotations

import json

import pytest
from haptic_tracing.command_line import main

SHAPES = {
    "floor": ({"type": "box", "size": [10, 10, 1]}, [0, 0, -0.5]),
    "ball": ({"type": "sphere", "radius": 0.5}, [1, 2, 0.505]),
    "cone": ({"type": "cone", "radius": 0.5, "height": 1, "margin": 0.04}, [-2, 2, 0.54]),
    "crate": ({"type": "box", "size": [1, 2, 1]}, [3, -2, 0.498]),
    "high": ({"type": "capsule", "radius": 0.1, "height": 1}, [0, 0, 0.6111]),
}


@pytest.fixture
def scene_file(tmp_path):
    """Writes a scene file of some of the shapes; its path."""

    def written(names=tuple(SHAPES), tolerance=0.01, **changes):
        objects = [
            {
                "name": name,
                "kappa": 0.1,
                "rho": 0.9,
                "shape": {**SHAPES[name][0], **changes.get(name, {})},
                "pose": {"position": SHAPES[name][1], "rotation": [1, 0, 0, 0]},
            }
            for name in names
        ]
        path = tmp_path / "scene.json"
        empty = {"contacts": [], "sources": [], "listeners": []}
        path.write_text(
            json.dumps(
                {
                    "format": "haptic-scene",
                    "version": "1.1",
                    "rules": {"tolerance": tolerance},
                    "objects": objects,
                    **empty,
                }
            )
        )
        return path

    return written


def test_contacts_with_their_distances(scene_file, capsys):
    assert main(["propagate", str(scene_file()), "--contacts"]) == 0
    found = {
        contact["objects"][1]: contact
        for contact in json.loads(capsys.readouterr().out)["contacts"]
    }
    distances = {name: contact["distance"] for name, contact in found.items()}
    assert distances == pytest.approx({"ball": 0.005, "cone": 0.0, "crate": -0.002}, abs=1e-9)
    assert found["crate"]["area"] == pytest.approx(2.0) and found["crate"][
        "depth"
    ] == pytest.approx(0.002)
    assert found["crate"]["normal"] == pytest.approx([0, 0, 1])
    assert found["ball"]["positions"] == [pytest.approx([1, 2, 0]), pytest.approx([1, 2, 0.005])]
    assert all(contact["transmission"] == {"function": "identity"} for contact in found.values())


def test_tolerance_decides_what_touches(scene_file, capsys):
    for tolerance, count in ((0.0, 1), (0.004, 2), (0.005001, 3), (0.02, 4)):
        assert main(["propagate", str(scene_file(tolerance=tolerance)), "--contacts"]) == 0
        # The cone stands exactly on the floor, up to rounding.
        assert len(json.loads(capsys.readouterr().out)["contacts"]) - count in (
            (0, 1) if tolerance == 0 else (0,)
        )


def test_output_is_a_scene_file(scene_file, capsys, tmp_path):
    path = scene_file()
    main(["propagate", str(path), "--contacts"])
    contacts = json.loads(capsys.readouterr().out)["contacts"]
    document = json.loads(path.read_text())
    document["contacts"] = [
        {key: value for key, value in contact.items() if key != "distance"} for contact in contacts
    ]
    (tmp_path / "again.json").write_text(json.dumps(document))
    assert main(["propagate", str(tmp_path / "again.json")]) == 0


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"ball": {"radius": -1}}, "/objects/1/shape/radius"),
        ({"ball": {"type": "blob"}}, "/objects/1/shape"),
        ({"floor": {"size": [1, 2]}}, "/objects/0/shape/size"),
        ({"tolerance": -1}, "/rules/tolerance"),
    ],
)
def test_errors_are_one_line_and_code_2(scene_file, capsys, changes, word):
    try:
        code = main(["propagate", str(scene_file(**changes)), "--contacts"])
    except SystemExit as exit_:
        code = exit_.code
    output, error = capsys.readouterr()
    assert code == 2 and output == ""
    assert word in error and error.count("\n") == 1 and "Traceback" not in error
