"""Numbers of a file that have more digits than Blender's properties: they count while the
properties hold them."""

import json

import bpy
import numpy as np
import pytest
from scene_files import exported, imported

KAPPA, RHO, ALPHA, AMPLITUDE, RADIUS, THRESHOLD = (
    0.123456789012,
    0.876543210987,
    0.345678901234,
    0.765432109876,
    0.0456789012345,
    0.00123456789,
)
SCENE = {
    "format": "haptic-scene",
    "version": "1.1",
    "settings": {"mode": "HT", "strategy": "auto", "threshold": THRESHOLD},
    "objects": [
        {
            "name": "bar",
            "kappa": KAPPA,
            "rho": RHO,
            "shape": {"type": "box", "size": [2, 1, 1]},
            "pose": {"position": [0, 0, 0], "rotation": [1, 0, 0, 0]},
            "propagation": {"function": "exponential", "alpha": ALPHA},
        }
    ],
    "sources": [
        {"name": "shaker", "object": "bar", "position": [0.5, 0, 0], "amplitude": AMPLITUDE}
    ],
    "listeners": [{"name": "hand", "object": "bar", "position": [-0.5, 0, 0], "radius": RADIUS}],
}


@pytest.fixture
def bar(scene, tmp_path):
    path = tmp_path / "bar.json"
    path.write_text(json.dumps(SCENE), encoding="utf-8")
    imported(path)
    return bpy.data.objects["bar"]


def in_single_precision(value):
    return float(str(np.float32(value)))


def written(tmp_path):
    """What the scene in Blender is exported as."""
    return json.loads(exported(tmp_path / "out.json"))


PLACES = {
    "kappa": (
        lambda: bpy.data.objects["bar"].haptics,
        lambda form: form["objects"][0]["kappa"],
        KAPPA,
    ),
    "rho": (lambda: bpy.data.objects["bar"].haptics, lambda form: form["objects"][0]["rho"], RHO),
    "alpha": (
        lambda: bpy.data.objects["bar"].haptics,
        lambda form: form["objects"][0]["propagation"]["alpha"],
        ALPHA,
    ),
    "amplitude": (
        lambda: bpy.data.objects["shaker"].haptics.source,
        lambda form: form["sources"][0]["amplitude"],
        AMPLITUDE,
    ),
    "radius": (
        lambda: bpy.data.objects["hand"].haptics.listener,
        lambda form: form["listeners"][0]["radius"],
        RADIUS,
    ),
    "threshold": (
        lambda: bpy.context.scene.haptics,
        lambda form: form["settings"]["threshold"],
        THRESHOLD,
    ),
}


@pytest.mark.parametrize("name", PLACES)
def test_an_imported_number_counts_as_long_as_its_property_holds_it(bar, tmp_path, name):
    owner, of_file, number = PLACES[name]
    assert in_single_precision(number) != number
    assert of_file(written(tmp_path)) == number
    before = getattr(owner(), name)
    setattr(owner(), name, before / 2)
    assert of_file(written(tmp_path)) == in_single_precision(before / 2)
    setattr(owner(), name, before)
    after = written(tmp_path)
    assert of_file(after) == number
    for other, (_, other_of_file, other_number) in PLACES.items():
        if other != name:
            assert other_of_file(after) == other_number


def test_an_animated_property_is_the_number_of_the_file_only_where_it_has_its_value(bar, tmp_path):
    bar.haptics.keyframe_insert("kappa", frame=1)
    bar.haptics.kappa = 0.5
    bar.haptics.keyframe_insert("kappa", frame=11)
    for frame, expected in ((1, KAPPA), (11, 0.5)):
        bpy.context.scene.frame_set(frame)
        assert written(tmp_path)["objects"][0]["kappa"] == expected


def test_text_that_is_no_json_is_left_for_the_reader_to_report(bar):
    bar.haptics.imported = "[" * 100_000
    bar.haptics.kappa = 0.5
    assert bar.haptics.imported == "[" * 100_000
