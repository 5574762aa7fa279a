"""Scenes from files and dictionaries: gains against closed forms and NetworkX, errors that name
their place."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import wave

import haptic_tracing as ht
import networkx
import numpy as np
import pytest
from haptic_tracing.command_line import main


def chain(count, alpha=0.3):
    """Objects in a row, a metre each, that touch at their ends."""
    function = {"function": "exponential", "alpha": alpha}
    objects = [
        {"name": f"link {k}", "kappa": 0.5, "rho": 0.5, "propagation": function}
        for k in range(count)
    ]
    contacts = [
        {"objects": [f"link {k - 1}", f"link {k}"], "positions": [[k, 0, 0], [k, 0, 0]]}
        for k in range(1, count)
    ]
    return {
        "objects": objects,
        "contacts": contacts,
        "sources": [{"name": "drill", "object": "link 0", "position": [0, 0, 0], "amplitude": 0.5}],
        "listeners": [
            {
                "name": "hand",
                "object": f"link {count - 1}",
                "position": [count, 0, 0],
                "gain": 2.0,
                "radius": 0,
            }
        ],
    }


def test_a_gain_is_that_of_the_path_without_amplitude_and_gain_of_the_listener():
    assert ht.Scene(**chain(5)).gains() == {("drill", "hand"): pytest.approx(math.exp(-0.3 * 5))}


def test_numbers_and_arrays_of_numpy_may_stand_in_dictionaries():
    """Exact in single precision, so that both scenes are the same."""
    parts = chain(3, 0.25)
    parts["objects"][1]["kappa"] = np.float32(0.5)
    parts["contacts"][0]["positions"] = np.array([[1, 0, 0], [1, 0, 0]])
    parts["sources"][0]["position"] = np.zeros(3)
    scene = ht.Scene(**parts)
    assert scene.gains() == ht.Scene(**chain(3, 0.25)).gains()
    run = ht.open(scene)
    run.add(
        listener={
            "name": "foot",
            "object": "link 0",
            "position": np.array([1.0, 0, 0]),
            "radius": 0,
        }
    )
    assert run.step(0.0).levels["foot"].gains == {"drill": pytest.approx(math.exp(-0.25))}


def test_what_is_no_scene_and_no_rate_is_named():
    with pytest.raises(TypeError, match=r"as load\(path\) gives, not 'bench.json'"):
        ht.open("bench.json")
    with pytest.raises(ValueError, match="sample_rate: must be from 100 to 192000, not 0"):
        ht.open(ht.Scene(), sample_rate=0)
    with pytest.raises(ValueError, match=r"/objects/0/kappa: .*got \"\{1\}\""):
        ht.Scene(objects=[{"name": "bench", "kappa": {1}, "rho": 0.5}])


def test_gains_of_a_grid_are_those_of_networkx():
    """Slabs that touch their neighbours in a 4 x 4 grid; NetworkX searches the graph whose nodes
    are the ends of contacts."""
    side, alpha, loss = 4, 0.35, 0.8
    function = {"function": "exponential", "alpha": alpha}
    names = {(x, y): f"slab {x} {y}" for x in range(side) for y in range(side)}
    between = {"function": "constant", "gain": loss}
    joints = [
        ((x, y), (x + dx, y + dy))
        for x, y in names
        for dx, dy in ((1, 0), (0, 1))
        if (x + dx, y + dy) in names
    ]
    contacts = [
        {
            "objects": [names[a], names[b]],
            "positions": [[(a[0] + b[0]) / 2, (a[1] + b[1]) / 2 + 0.1 * k, 0.0] for k in (0, 1)],
            "transmission": between,
        }
        for a, b in joints
    ]
    scene = ht.Scene(
        objects=[
            {"name": name, "kappa": 0.1, "rho": 0.9, "propagation": function}
            for name in names.values()
        ],
        contacts=contacts,
        sources=[{"name": "drill", "object": names[0, 0], "position": [-0.4, 0, 0]}],
        listeners=[
            {"name": name, "object": name, "position": [x, y + 0.3, 0], "radius": 0}
            for (x, y), name in names.items()
        ],
        settings={"strategy": "best_path", "threshold": 0, "max_connections": None},
    )
    graph = networkx.Graph()
    places = {name: [] for name in names.values()}
    places[names[0, 0]].append(("drill", (-0.4, 0.0, 0.0)))
    for (x, y), name in names.items():
        places[name].append((name, (x, y + 0.3, 0.0)))
    for number, form in enumerate(contacts):
        for k, name in enumerate(form["objects"]):
            places[name].append(((number, k), tuple(form["positions"][k])))
        graph.add_edge((number, 0), (number, 1), cost=-math.log(loss))
    for ends in places.values():
        for i, (a, p) in enumerate(ends):
            for b, q in ends[:i]:
                graph.add_edge(a, b, cost=alpha * math.dist(p, q))
    expected = networkx.single_source_dijkstra_path_length(graph, "drill", weight="cost")
    assert scene.gains() == {
        ("drill", name): pytest.approx(math.exp(-expected[name])) for name in names.values()
    }


def test_contacts_are_found_where_the_scene_lists_none(tmp_path):
    parts = chain(3)
    del parts["contacts"]
    for k, item in enumerate(parts["objects"]):
        item["shape"] = {"type": "box", "size": [1, 1, 1]}
        item["pose"] = {"position": [k + 0.5, 0, 0]}
    path = tmp_path / "chain.json"
    path.write_text(
        json.dumps({"format": "haptic-scene", "version": "1.1", **parts}), encoding="utf-8"
    )
    scene = ht.load(path)
    assert [item.objects for item in scene.contacts()] == [
        ("link 0", "link 1"),
        ("link 1", "link 2"),
    ]
    assert scene.gains() == {("drill", "hand"): pytest.approx(math.exp(-0.3 * 3))}
    assert ht.loads(path.read_text(encoding="utf-8")).gains() == scene.gains()
    scene.with_settings(strategy="as_in_the_paper").save(tmp_path / "saved.json")
    assert ht.load(tmp_path / "saved.json").content.settings.strategy == "as_in_the_paper"


def test_errors_name_the_place():
    parts = chain(2)
    parts["objects"][1]["kapa"] = 2
    with pytest.raises(ValueError, match="/objects/1/kapa"):
        ht.Scene(**parts)
    parts = chain(2)
    parts["objects"][1]["propagation"] = {"function": "expression", "expression": "0 / (d - 1)"}
    with pytest.raises(ValueError, match=r"scene: /objects/1/propagation: .*link 1"):
        ht.Scene(**parts).gains()


def test_the_package_is_imported_without_what_is_not_needed():
    program = (
        "import sys, haptic_tracing as ht; ht.Scene; print(sorted({'bpy', 'fcl', "
        "'networkx', 'hid', 'soxr'} & set(sys.modules)))"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True
        ).stdout
        == "[]\n"
    )


def test_frames_of_a_scene_in_which_nothing_moves_are_those_of_its_run():
    """Samples of both; boxes that stand on each other, without contacts in the file."""
    box = {"kappa": 0.1, "rho": 0.8, "shape": {"type": "box", "size": [1, 1, 1]}}
    scene = ht.Scene(
        objects=[
            {**box, "name": "under"},
            {**box, "name": "over", "pose": {"position": [0, 0, 1]}},
        ],
        sources=[{"name": "drill", "object": "under", "position": [0, 0, 0]}],
        listeners=[{"name": "hand", "object": "over", "position": [0, 0, 1], "radius": 0}],
    )
    run = ht.open(scene)
    run.step(0.0)
    first, *rest = scene.frames(seconds=0.2)
    assert first.block is None and rest[-1].time == pytest.approx(0.2)
    for frame in rest:
        assert run.step(frame.time).block == pytest.approx(frame.block, abs=1e-12)
    assert abs(rest[-1].block).max() > 0.1


def test_a_function_of_a_rule_that_gives_no_gain_is_refused():
    between = {"function": "expression", "expression": "log(d - 1)"}
    rules = {"transmission_table": [{"between": [{}, {}], "transmission": between}]}
    with pytest.raises(ValueError, match=r"/rules.*log.*no finite value"):
        ht.Scene(objects=[], rules=rules)


def table_above_the_floor(**source):
    box = {"type": "box", "size": [1, 1, 1]}
    loss = {"propagation": {"function": "exponential", "alpha": 0.5}}
    body = {"kappa": 0.1, "rho": 0.9, "shape": box, "motion": "static", **loss}
    return ht.Scene(
        objects=[
            body | {"name": "floor"},
            body | {"name": "table", "pose": {"position": [0, 0, 1.2]}},
            body | {"name": "shelf", "pose": {"position": [0, 1, 1.2]}},
        ],
        sources=[{"name": "phone", "object": "table", "position": [0, 0, 1.7], **source}],
        listeners=[
            {"name": "wrist", "object": "floor", "position": [0, 0, 0.5], "body_part": "hand_r"},
            {"name": "top", "object": "table", "position": [0, 0.5, 1.7], "radius": 0},
            {"name": "side", "object": "shelf", "position": [0, 1, 1.7], "radius": 0},
        ],
    )


def test_a_pair_has_its_gain_its_path_and_why_nothing_arrives():
    result = table_above_the_floor().result()
    assert result["phone", "top"] == ht.Pair(pytest.approx(math.exp(-0.25)), ("table",), ())
    assert result["phone", "side"].path == ("table", "shelf")
    lost = result["phone", "wrist"]
    assert (lost.gain, lost.path) == (0.0, ())
    assert "no contact leads" in lost.why[0]
    with pytest.raises(ValueError, match=r"'phon'.*did you mean 'phone'"):
        result["phon", "top"]
    assert repr(result) == "<Result of 1 sources, 3 listeners>"


def test_the_door_says_what_the_command_line_says(tmp_path, capsys):
    scene = table_above_the_floor(
        position=[0, 0, 51.7], signal={"signal": "sine", "frequency": 6000}
    )
    scene.save(tmp_path / "scene.json")
    assert main(["propagate", str(tmp_path / "scene.json")]) == 0
    said = capsys.readouterr().err.splitlines()
    warnings = scene.result().warnings
    assert said == [f"{tmp_path / 'scene.json'}: {words}" for words in warnings]
    for words in ("50 m away", "6000 Hz", "did you mean 'hand.R'", "'wrist' feels nothing"):
        assert any(words in one for one in warnings), words
    assert set(ht.open(scene).warnings) < set(warnings)


def test_what_others_call_it_gets_a_hint():
    with pytest.raises(ht.FormatError, match="signal: is required: is 'type' meant to be it"):
        table_above_the_floor(signal={"type": "sine"})
    run = ht.open(table_above_the_floor())
    with pytest.raises(ValueError, match=r"sources/phone: expected .*playing.*got 0.5"):
        run.step(0.0, sources={"phone": 0.5})
    assert repr(run) == "<Run of 3 objects, 1 sources, 3 listeners, not begun>"
    assert repr(run.step(0.0)).startswith("<Step at 0 s: wrist: silent, top: -")


def test_a_vibration_is_read_as_samples(tmp_path):
    times = np.arange(800) / 8000
    with wave.open(str(tmp_path / "buzz.wav"), "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes((16384 * np.sin(2 * np.pi * 100 * times)).astype("<i2").tobytes())
    (channel,) = ht.read(tmp_path / "buzz.wav").channels
    assert (channel.sample_rate, len(channel.samples)) == (8000, 800)
    assert np.abs(channel.samples - 0.5 * np.sin(2 * np.pi * 100 * times)).max() < 1e-4
