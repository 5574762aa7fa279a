"""Every reader of haptic scenes answers a mistake alike, with its place and, for a slip of the pen,
with what was meant."""

import copy
import json
from typing import Any, NamedTuple

import haptic_tracing as ht
import pytest
from haptic_tracing.command_line import main

SCENE: dict[str, Any] = {
    "format": "haptic-scene",
    "version": "1.1",
    "settings": {"strategy": "best_path", "threshold": 0.001},
    "rules": {"tolerance": 0.01},
    "objects": [
        {
            "name": "ground",
            "kappa": 0.2,
            "rho": 0.9,
            "shape": {"type": "box", "size": [10, 10, 1]},
            "pose": {"position": [0, 0, -0.5]},
        },
        {"name": "bench", "kappa": 0.1, "rho": 0.8, "mass": 20},
    ],
    "contacts": [{"objects": ["ground", "bench"], "positions": [[1, 0, 0], [1, 0, 0]]}],
    "sources": [
        {
            "name": "drill",
            "object": "ground",
            "position": [0, 0, 0],
            "signal": {"signal": "sine", "frequency": 60},
        }
    ],
    "listeners": [
        {
            "name": "seat",
            "object": "bench",
            "position": [1, 0, 0.4],
            "body_part": "hips",
            "radius": 0,
        }
    ],
    "frame_rate": 24,
    "frame_start": 1,
    "frames": [{"frame": 1}, {"frame": 2, "poses": {"bench": [0, 0, 0.1, 1, 0, 0, 0]}}],
}


class Mistake(NamedTuple):
    """``path``: where the file is changed. ``value``: what stands there then; `GONE` for nothing.
    ``answer``: what is said of it, without the file's name."""

    path: tuple[str | int, ...]
    value: Any
    answer: str


GONE = object()


def text_with(mistake: Mistake) -> str:
    """The file with a mistake."""
    document = copy.deepcopy(SCENE)
    at: Any = document
    for key in mistake.path[:-1]:
        at = at[key]
    if mistake.value is GONE:
        del at[mistake.path[-1]]
    elif isinstance(mistake.value, Renamed):
        at[mistake.value.key] = at.pop(mistake.path[-1])
    else:
        at[mistake.path[-1]] = mistake.value
    return json.dumps(document)


class Renamed(NamedTuple):
    """The same value under another key."""

    key: str


MISTAKES: dict[str, Mistake] = {
    "misspelt kappa": Mistake(
        ("objects", 0, "kappa"),
        Renamed("kapa"),
        "/objects/0/kapa: unknown key, did you mean 'kappa'?; known are name, kappa, rho, propagation, shape, pose, mass, medium, extras, motion, layers, impact_material, material",
    ),
    "capital Rho": Mistake(
        ("objects", 0, "rho"),
        Renamed("Rho"),
        "/objects/0/Rho: unknown key, did you mean 'rho'?; known are name, kappa, rho, propagation, shape, pose, mass, medium, extras, motion, layers, impact_material, material",
    ),
    "no rho": Mistake(("objects", 0, "rho"), GONE, "/objects/0/rho: is required"),
    "misspelt name": Mistake(
        ("objects", 0, "name"), Renamed("nmae"), "/objects/0/name: is required"
    ),
    "kappa as text": Mistake(
        ("objects", 0, "kappa"), "0.2", '/objects/0/kappa: must be a number, got "0.2"'
    ),
    "negative kappa": Mistake(
        ("objects", 0, "kappa"), -1, "/objects/0/kappa: must be at least 0, got -1"
    ),
    "kappa missing value": Mistake(
        ("objects", 0, "kappa"), None, "/objects/0/kappa: must be a number, got null"
    ),
    "rho above one": Mistake(
        ("objects", 0, "rho"), 1.5, "/objects/0/rho: must be at most 1, got 1.5"
    ),
    "name as number": Mistake(
        ("objects", 0, "name"), 7, "/objects/0/name: must be a string, got 7"
    ),
    "empty name": Mistake(
        ("objects", 0, "name"), "", "/objects/0/name: must have at least 1 character, has 0"
    ),
    "two objects of one name": Mistake(
        ("objects", 1, "name"), "ground", "/objects/1/name: there is an object 'ground' already"
    ),
    "negative mass": Mistake(
        ("objects", 1, "mass"), -2, "/objects/1/mass: must be at least 0, got -2"
    ),
    "mass with unit": Mistake(
        ("objects", 1, "mass"), "20 kg", '/objects/1/mass: must be a number, got "20 kg"'
    ),
    "shape a cube": Mistake(
        ("objects", 0, "shape"),
        {"type": "cube", "size": [1, 1, 1]},
        '/objects/0/shape/type: must be "box" or "sphere" or "capsule" or "cylinder" or "cone" or "convex_hull" or "mesh" or "compound", got "cube", did you mean \'box\'?',
    ),
    "shape a cilinder": Mistake(
        ("objects", 0, "shape"),
        {"type": "cilinder", "radius": 1, "height": 1},
        '/objects/0/shape/type: must be "box" or "sphere" or "capsule" or "cylinder" or "cone" or "convex_hull" or "mesh" or "compound", got "cilinder", did you mean \'cylinder\'?',
    ),
    "shape without type": Mistake(
        ("objects", 0, "shape"), {"size": [1, 1, 1]}, "/objects/0/shape/type: is required"
    ),
    "kind instead of type": Mistake(
        ("objects", 0, "shape"),
        {"kind": "box", "size": [1, 1, 1]},
        "/objects/0/shape/type: is required",
    ),
    "box with one size": Mistake(
        ("objects", 0, "shape", "size"), 2, "/objects/0/shape/size: must be an array, got 2"
    ),
    "box with two sizes": Mistake(
        ("objects", 0, "shape", "size"),
        [1, 1],
        "/objects/0/shape/size: must have at least 3 items, has 2",
    ),
    "flat box": Mistake(
        ("objects", 0, "shape", "size"),
        [1, 1, 0],
        "/objects/0/shape/size/2: must be more than 0, got 0",
    ),
    "box with radius": Mistake(
        ("objects", 0, "shape", "radius"), 1, "/objects/0/shape/radius: does not belong here"
    ),
    "sphere without radius": Mistake(
        ("objects", 0, "shape"), {"type": "sphere"}, "/objects/0/shape/radius: is required"
    ),
    "diameter": Mistake(
        ("objects", 0, "shape"),
        {"type": "sphere", "diameter": 1},
        "/objects/0/shape/radius: is required",
    ),
    "hull in one place": Mistake(
        ("objects", 0, "shape"),
        {"type": "convex_hull", "points": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]},
        "/objects/0/shape/points: they all lie in one place",
    ),
    "mesh without triangles": Mistake(
        ("objects", 0, "shape"),
        {"type": "mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]},
        "/objects/0/shape/triangles: is required",
    ),
    "triangle of missing point": Mistake(
        ("objects", 0, "shape"),
        {"type": "mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 3]]},
        "/objects/0/shape/triangles: triangle 0 refers to a point that is not there",
    ),
    "pose as list": Mistake(
        ("objects", 0, "pose"), [0, 0, 0], "/objects/0/pose: must be an object, got an array"
    ),
    "pose with location": Mistake(
        ("objects", 0, "pose"),
        {"location": [0, 0, 0]},
        "/objects/0/pose/location: unknown key; known are position, rotation",
    ),
    "position in two numbers": Mistake(
        ("objects", 0, "pose", "position"),
        [0, 0],
        "/objects/0/pose/position: must have at least 3 items, has 2",
    ),
    "unit quaternion missing": Mistake(
        ("objects", 0, "pose", "rotation"),
        [0, 0, 0, 0],
        "/objects/0/pose/rotation: a quaternion of length 0 is no rotation",
    ),
    "modulation unknown": Mistake(
        ("objects", 0, "propagation"),
        {"function": "exponentail"},
        '/objects/0/propagation/function: must be "identity" or "constant" or "linear" or "exponential" or "haptic_tracing" or "expression" or "physical" or "resilient" or "impedance" or "normal_force", got "exponentail", did you mean \'exponential\'?',
    ),
    "propagation as text": Mistake(
        ("objects", 0, "propagation"),
        "linear",
        '/objects/0/propagation: must be an object, got "linear"',
    ),
    "contact with a stranger": Mistake(
        ("contacts", 0, "objects"),
        ["ground", "bank"],
        "/contacts/0/objects/1: there is no object 'bank'",
    ),
    "contact with itself": Mistake(
        ("contacts", 0, "objects"),
        ["ground", "ground"],
        "/contacts/0/objects: 'ground' can't touch itself",
    ),
    "contact of three": Mistake(
        ("contacts", 0, "objects"),
        ["ground", "bench", "ground"],
        "/contacts/0/objects: must have at most 2 items, has 3",
    ),
    "contact with one point": Mistake(
        ("contacts", 0, "positions"),
        [[1, 0, 0]],
        "/contacts/0/positions: must have at least 2 items, has 1",
    ),
    "contacts as object": Mistake(
        ("contacts",), {"ground": "bench"}, "/contacts: must be an array, got an object"
    ),
    "source on a stranger": Mistake(
        ("sources", 0, "object"),
        "grund",
        "/sources/0/object: there is no object 'grund', did you mean 'ground'?",
    ),
    "source without position": Mistake(
        ("sources", 0, "position"), GONE, "/sources/0/position: is required"
    ),
    "two sources of one name": Mistake(
        ("sources",),
        [
            {"name": "a", "object": "ground", "position": [0, 0, 0]},
            {"name": "a", "object": "ground", "position": [0, 0, 0]},
        ],
        "/sources/1/name: there is a source 'a' already",
    ),
    "source amplitude text": Mistake(
        ("sources", 0, "amplitude"), "loud", '/sources/0/amplitude: must be a number, got "loud"'
    ),
    "signal unknown": Mistake(
        ("sources", 0, "signal", "signal"),
        "sin",
        '/sources/0/signal/signal: must be "sine" or "square" or "triangle" or "saw" or "pulse" or "noise" or "constant" or "adsr" or "keyed" or "decay" or "impulse" or "decaying_sine" or "sampled" or "gain" or "delay" or "product" or "sum" or "sequence" or "loop" or "struck", got "sin", did you mean \'sine\'?',
    ),
    "signal type": Mistake(
        ("sources", 0, "signal"),
        {"type": "sine", "frequency": 60},
        "/sources/0/signal/signal: is required: is 'type' meant to be it?",
    ),
    "signal misspelt frequency": Mistake(
        ("sources", 0, "signal"),
        {"signal": "sine", "frequenzy": 60},
        "/sources/0/signal/frequenzy: does not belong here, did you mean 'frequency'?; known are signal, frequency, amplitude, phase",
    ),
    "signal with duty": Mistake(
        ("sources", 0, "signal", "duty"),
        0.5,
        "/sources/0/signal/duty: does not belong here; known are signal, frequency, amplitude, phase",
    ),
    "signal frequency text": Mistake(
        ("sources", 0, "signal", "frequency"),
        "60 Hz",
        '/sources/0/signal/frequency: must be a number or object, got "60 Hz"',
    ),
    "signal above hearing": Mistake(
        ("sources", 0, "signal", "frequency"),
        100000.0,
        "/sources/0/signal/frequency: must be from 0 to 20000, got 100000.0",
    ),
    "listener on a stranger": Mistake(
        ("listeners", 0, "object"), "chair", "/listeners/0/object: there is no object 'chair'"
    ),
    "listener gain negative": Mistake(
        ("listeners", 0, "gain"), -1, "/listeners/0/gain: must be at least 0, got -1"
    ),
    "listener radius negative": Mistake(
        ("listeners", 0, "radius"), -1, "/listeners/0/radius: must be at least 0, got -1"
    ),
    "sources misspelt": Mistake(
        ("sources",),
        Renamed("sorces"),
        "/sorces: unknown key, did you mean 'sources'?; known are format, version, convention, settings, rules, objects, contacts, sources, listeners, materials, devices, frame_rate, frame_start, motions, frames, tracks, extras",
    ),
    "listeners in singular": Mistake(
        ("listeners",),
        Renamed("listener"),
        "/listener: unknown key, did you mean 'listeners'?; known are format, version, convention, settings, rules, objects, contacts, sources, listeners, materials, devices, frame_rate, frame_start, motions, frames, tracks, extras",
    ),
    "strategy unknown": Mistake(
        ("settings", "strategy"),
        "best",
        '/settings/strategy: must be "best_path" or "as_in_the_paper", got "best"',
    ),
    "setting misspelt": Mistake(
        ("settings", "strategy"),
        Renamed("stratgy"),
        "/settings/stratgy: unknown key, did you mean 'strategy'?; known are mode, strategy, max_connections, threshold, epsilon",
    ),
    "threshold above one": Mistake(
        ("settings", "threshold"), 2, "/settings/threshold: must be at most 1, got 2"
    ),
    "mode in words": Mistake(
        ("settings", "mode"),
        "haptic tracing",
        '/settings/mode: must be "HT" or "SD" or "MD" or "MN", got "haptic tracing"',
    ),
    "rules misspelt": Mistake(
        ("rules", "tolerance"),
        Renamed("tolerence"),
        "/rules/tolerence: unknown key, did you mean 'tolerance'?; known are tolerance, slack, impacts, templates, least_energy, full_energy, energy, refractory, gravity, time_scale, passing, joints, impact_table, transmission_table, textures",
    ),
    "another format": Mistake(
        ("format",), "gltf", '/format: not a haptic scene: must be "haptic-scene"'
    ),
    "no format": Mistake(("format",), GONE, '/format: not a haptic scene: must be "haptic-scene"'),
    "newer version": Mistake(("version",), "9.0", '/version: this reads version "1.1", not "9.0"'),
    "version as number": Mistake(("version",), 1.1, '/version: this reads version "1.1", not 1.1'),
    "frames out of order": Mistake(
        ("frames", 0, "frame"), 5, "/frames/1/frame: must come after 5, the frame before"
    ),
    "frame twice": Mistake(
        ("frames", 0, "frame"), 2, "/frames/1/frame: must come after 2, the frame before"
    ),
    "pose of a stranger": Mistake(
        ("frames", 1, "poses"),
        {"bank": [0, 0, 0, 1, 0, 0, 0]},
        "/frames/1/poses/bank: there is no object 'bank'",
    ),
    "parted strangers": Mistake(
        ("frames", 1, "parted"),
        [["ground", "bank"]],
        "/frames/1/parted/0: 'bank' and 'ground' did not touch",
    ),
    "parted of one": Mistake(
        ("frames", 1, "parted"),
        [["ground"]],
        "/frames/1/parted/0: must have at least 2 items, has 1",
    ),
    "time in frames": Mistake(
        ("frames", 0, "time"),
        0.0,
        "/frames/0/time: unknown key; known are frame, poses, properties, functions, amplitudes, source_positions, listener_positions, gains, contacts, parted, sources, objects, listeners, removed_objects, removed_listeners",
    ),
    "no frame rate": Mistake(
        ("frame_rate",), GONE, "/frame_rate: is required where there are frames"
    ),
    "frame rate zero": Mistake(("frame_rate",), 0, "/frame_rate: must be more than 0, got 0"),
}


def test_without_a_mistake_the_scene_is_read():
    assert ht.Scene(**{key: SCENE[key] for key in SCENE.keys() - {"format", "version"}}).gains()


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_answered_alike_by_all(name, tmp_path, capsys):
    mistake, file = MISTAKES[name], tmp_path / "scene.json"
    file.write_text(text_with(mistake))
    with pytest.raises(ValueError) as error:
        ht.load(file)
    assert str(error.value) == f"{file}: {mistake.answer}"
    for command in (["propagate"], ["export", "--to", "wav", "--out", str(tmp_path)]):
        assert main([command[0], str(file), *command[1:]]) == 2
        assert capsys.readouterr().err == f"{file}: {mistake.answer}\n"
