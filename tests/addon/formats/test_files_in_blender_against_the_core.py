"""What the core computes from a file alone, Blender computes from what it imported of it: the same
gains to the last digits."""

import json

import bpy
import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import function_from_dict
from haptic_tracing.core.scene.values import (
    Contact,
    Extent,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Settings,
    Source,
)
from haptic_tracing.core.signals import Adsr, Decay, Noise, Pulse, Sine
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_files import exported, imported

FEW = settings(
    max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)


def by_core(scene):
    """(gain, gains of bands) by the names of source and listener, from what the file says."""
    found = propagate(graph_of_scene(scene), scene.settings)
    bands = (
        np.ones((*found.gain.shape, 6)) * found.gain[..., None]
        if found.band_gain is None
        else found.band_gain
    )
    return {
        (source.name, listener.name): (source.amplitude * found.gain[s, i], bands[s, i])
        for s, source in enumerate(scene.sources)
        for i, listener in enumerate(scene.listeners)
    }


def in_blender(result):
    bands = result.propagation.band_gain
    bands = (
        np.ones((*result.amplitudes.shape, 6)) * result.propagation.gain[..., None]
        if bands is None
        else bands
    )
    return {
        (source.name, listener.name): (
            source.amplitude * result.propagation.gain[s, i],
            bands[s, i],
        )
        for s, source in enumerate(result.sources)
        for i, listener in enumerate(result.listeners)
    }


def assert_alike(found, expected):
    assert found.keys() == expected.keys()
    for pair, (gain, bands) in expected.items():
        assert found[pair][0] == pytest.approx(gain, rel=1e-12, abs=1e-300), pair
        np.testing.assert_allclose(
            found[pair][1], bands, rtol=1e-12, atol=1e-300, err_msg=str(pair)
        )


shares = st.floats(0.01, 1)
sixes = st.lists(st.floats(0, 1), min_size=6, max_size=6)
functions = st.one_of(
    st.builds(lambda gain: {"function": "constant", "gain": gain}, shares),
    st.builds(
        lambda alpha, speed: {"function": "exponential", "alpha": alpha, "wave_speed": speed},
        shares,
        st.floats(100, 3000),
    ),
    st.builds(
        lambda length, gains: {"function": "linear", "range": length, "band_gains": gains},
        st.floats(5, 50),
        sixes,
    ),
    st.builds(
        lambda gains, decays: {
            "function": "haptic_tracing",
            "band_gains": gains,
            "band_decays": decays,
        },
        sixes,
        sixes,
    ),
    st.builds(
        lambda wave, loss, speed, sizes, absorption: {
            "function": "physical",
            "wave": wave,
            "loss_factor": loss,
            "phase_speed": speed,
            "thickness": min(sizes),
            "extent": max(sizes),
            "absorption": absorption,
        },
        st.sampled_from(["bounded", "surface", "limb"]),
        shares,
        st.floats(100, 3000),
        st.tuples(shares, st.floats(0.1, 5)),
        shares,
    ),
    st.just({"function": "identity"}),
    st.just({"function": "expression", "expression": "exp(-0.3 * d) * 0.9"}),
).map(function_from_dict)
places = st.tuples(*[st.floats(-3, 3)] * 3)


@st.composite
def scenes(draw):
    """A chain of objects, some of whose contacts are double, numbers with all digits that they can
    have. Blender makes a box where there is no shape, and an energy balance divides that about its
    middle: so there all have shapes."""
    strategy = draw(st.sampled_from(["all_paths", "best_path", "energy_balance"]))
    shapes = (
        st.sampled_from([Box((1.1, 1, 1)), None])
        if strategy != "energy_balance"
        else st.just(Box((1.1, 1, 1)))
    )
    count = draw(st.integers(2, 5))
    names = [f"part {k}" for k in range(count)]
    objects = tuple(
        HapticObject(name, draw(st.floats(0, 0.9)), draw(shares), draw(functions), draw(shapes),
                     Pose((1.3 * k, draw(shares), 0), (1, 0, 0, draw(shares))))
        for k, name in enumerate(names)
    )  # fmt: skip
    contacts = tuple(
        Contact(
            (names[k], names[k + 1]),
            (draw(places), draw(places)),
            draw(functions),
            draw(shares),
            (0.6, 0.0, 0.8),
            draw(shares),
        )
        for k, n in enumerate(
            draw(st.lists(st.integers(1, 2), min_size=count - 1, max_size=count - 1))
        )
        for _ in range(n)
    )
    signals = st.sampled_from(
        [Sine(60.0), Pulse(25.0) * Decay(0.7), Noise() * Decay(1 / 3), Sine(90.0) * Adsr()]
    )
    sources = tuple(
        Source(
            f"source {k}",
            draw(st.sampled_from(names)),
            draw(places),
            draw(shares),
            signal=draw(signals),
            priority=draw(shares),
        )
        for k in range(2)
    )
    formulas = {"mixing": "custom", "mixing_expression": "s_max * tanh(sum / s_max)"}
    listeners = tuple(
        Listener(
            f"listener {k}", draw(st.sampled_from(names)), draw(places), radius=draw(shares), gain=draw(shares),
            s_max=draw(shares), limiter=draw(st.booleans()), extent=(Extent.STRONGEST, Extent.MEAN_POWER)[k],
            **draw(st.sampled_from([formulas, {"mixing": "power"}, {}])),
        )
        for k in range(2)
    )  # fmt: skip
    wanted = Settings(
        draw(st.sampled_from(["HT", "SD", "MD"])), strategy,
        threshold=0, epsilon=draw(shares), tolerance=draw(shares), localise=draw(shares),
    )  # fmt: skip
    return HapticScene(objects, contacts, sources, listeners, wanted)


@pytest.mark.slow
@FEW
@given(scene=scenes())
def test_generated_scenes(tmp_path_factory, scene):
    from haptic_tracing.addon.session import session

    folder = tmp_path_factory.mktemp("generated")
    write_export(Export("a", scene), folder / "a.json")
    imported(folder / "a.json")
    result = session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    assert_alike(in_blender(result), by_core(read_export(folder / "a.json").scene))
    first = exported(folder / "b.json")
    written = read_export(folder / "b.json").scene
    assert (written.settings, written.sources, written.listeners) == (
        scene.settings,
        scene.sources,
        scene.listeners,
    )
    assert {item.name: item.propagation for item in written.objects} == {
        item.name: item.propagation for item in scene.objects
    }
    assert sorted(map(repr, written.contacts)) == sorted(map(repr, scene.contacts))
    imported(folder / "b.json")
    assert exported(folder / "c.json") == first


@pytest.fixture
def stack(tmp_path):
    """A file with two boxes on the floor whose contacts pass on half and a tenth."""
    half, tenth = ({"function": "constant", "gain": gain} for gain in (0.5, 0.1))
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "settings": {"strategy": "as_in_the_paper"},
        "objects": [
            {"name": "floor", "kappa": 0, "rho": 1, "propagation": {"function": "identity"},
             "shape": {"type": "box", "size": [10, 10, 1]}, "pose": {"position": [0, 0, -0.5]}},
            *({"name": name, "kappa": 0, "rho": 1, "propagation": {"function": "identity"},
               "shape": {"type": "box", "size": [1, 1, 1]}, "pose": {"position": [x, 0, 0.5]}} for name, x in (("left", -2), ("right", 2))),
        ],
        "contacts": [
            {"objects": ["left", "floor"], "positions": [[-2, 0.1, 0], [-2, 0.1, 0]], "transmission": half, "extras": {"screws": 4}},
            {"objects": ["floor", "right"], "positions": [[2, 0, 0], [2, 0, 0]], "transmission": tenth},
        ],
        "sources": [{"name": "motor", "object": "floor", "position": [0, 0, 0]}],
        "listeners": [{"name": name, "object": name, "position": [x, 0, 0.5]} for name, x in (("left", -2), ("right", 2))],
    }  # fmt: skip
    path = tmp_path / "stack.json"
    path.write_text(json.dumps(document))
    return path


def test_what_a_contact_passes_on_belongs_to_the_pair(stack, tmp_path, traced):
    imported(stack)
    assert traced().amplitudes.tolist() == [[0.5, 0.1]]
    exported(tmp_path / "b.json")
    written = json.loads((tmp_path / "b.json").read_text())["contacts"]
    assert [item["transmission"]["gain"] for item in written] == [0.5, 0.1] and written[0][
        "extras"
    ] == {"screws": 4}
    bpy.data.objects["left"].location.y += 1.0  # now contacts are found, and pass on what they did
    bpy.context.view_layer.update()
    result = traced()
    assert result.amplitudes.tolist() == [[0.5, 0.1]]
    places = {
        item.objects: item.positions[0] for item in result.contacts.to_contacts(result.objects)
    }
    assert places["floor", "right"] == (2, 0, 0) and places[min(k for k in places if "left" in k)][
        1
    ] == pytest.approx(1.0, abs=0.01)
    bpy.data.objects["left"].location.z += 1.0
    bpy.context.view_layer.update()
    assert traced().amplitudes.tolist() == [[0.0, 0.1]]


def test_what_an_author_changes_counts_more_than_the_file(stack, traced):
    imported(stack)
    scene, floor = bpy.context.scene, bpy.data.objects["floor"]
    places = {item.positions[0] for item in traced().contacts.to_contacts(traced().objects)}
    assert (-2, 0.1, 0) in places
    scene.haptics.contact_tolerance = 0.02
    assert (-2, 0.1, 0) not in {
        item.positions[0] for item in traced().contacts.to_contacts(traced().objects)
    }
    scene.haptics.contact_tolerance = 0.01
    assert traced().amplitudes.tolist() == [[0.5, 0.1]]
    floor.haptics.function, floor.haptics.constant = "constant", 0.25
    assert traced().amplitudes.tolist() == [[0.125, 0.025]]
    floor.scale = (0.1, 0.1, 1)
    bpy.context.view_layer.update()
    assert traced().amplitudes.tolist() == [[0.0, 0.0]]


def test_two_files_in_one_scene_keep_their_contacts(stack, traced):
    """The second time all are renamed, and stand in the first ones' place: they are other
    objects."""
    imported(stack)
    for name in ("floor", "left", "right"):
        bpy.data.objects[name].name = f"old {name}"
        bpy.data.objects[f"old {name}"].location.z += 50
    bpy.context.view_layer.update()
    assert bpy.ops.import_scene.haptic_scene(filepath=str(stack)) == {"FINISHED"}
    gains = {(s.name, i.name): g for s, row in zip(traced().sources, traced().amplitudes, strict=True)
             for i, g in zip(traced().listeners, row, strict=True)}  # fmt: skip
    assert gains["motor.001", "left"] == 0.5 and gains["motor.001", "right"] == 0.1


def test_damaged_contacts_are_a_problem_in_words(stack, traced):
    from haptic_tracing.addon.session import session

    imported(stack)
    huge = "1" + 400 * "0"
    for text in (
        "{",
        "[]",
        '{"contacts": 3}',
        '{"contacts": [{"objects": ["left", "left"], "positions": []}]}',
        '{"contacts": [{}]}',
        '{"contacts": [{"objects": ["left", "right"]}]}',
        '{"contacts": [{"positions": [[0, 0, 0], [0, 0, 0]]}], "later": [null]}',
        f'{{"contacts": [{{"objects": ["left", "right"], "positions": [[0, 0, 0], [0, 0, '
        f"{huge}]]}}]}}",
        f'{{"tolerance": {huge}}}',
        "[" * 1000,
    ):
        bpy.context.scene.haptics.imported_contacts = text
        assert traced() is not None
        assert "import it again" in session.problems_of(bpy.context.scene)[0].message
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    assert bpy.ops.import_scene.haptic_scene(filepath=str(stack)) == {"FINISHED"}
    assert traced().amplitudes.tolist() == [[0.5, 0.1]] and not session.problems_of(
        bpy.context.scene
    )


def test_functions_that_begin_in_a_later_frame_are_kept(stack, tmp_path, traced):
    document = json.loads(stack.read_text())
    document["contacts"].pop()
    landed = {
        "objects": ["floor", "right"],
        "positions": [[2, 0, 0], [2, 0, 0]],
        "transmission": {"function": "constant", "gain": 0.3},
    }
    document["objects"][2]["pose"]["position"][2] = 3
    later = {"frame": 2, "poses": {"right": [2, 0, 0.5, 1, 0, 0, 0]}, "contacts": [landed]}
    document |= {"frame_rate": 25, "frames": [{"frame": 1}, later]}
    stack.write_text(json.dumps(document))
    imported(stack)
    assert traced().amplitudes.tolist() == [[0.5, 0.0]]
    bpy.context.scene.frame_set(2)
    assert traced().amplitudes.tolist() == [[0.5, 0.3]]
