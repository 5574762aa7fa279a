"""The messages to a server, without a socket: answers, errors with their place, axes and units."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from crate_on_ground import SCENE
from haptic_tracing.command_line.serve.convention import Convention
from haptic_tracing.command_line.serve.conversation import MOST_OBJECTS, Conversation
from hypothesis import given
from hypothesis import strategies as st


def ask(conversation, **message):
    return conversation.answer(json.dumps(message))


def talk(**hello):
    conversation = Conversation(None, None)
    (scene,) = ask(conversation, type="hello", version=1, scene=SCENE, **hello)
    assert scene["type"] == "scene", scene
    return conversation


def test_hello_names_what_the_scene_has():
    (scene,) = ask(Conversation(None, None), type="hello", version=1, scene=SCENE)
    assert (scene["objects"], scene["sources"], scene["listeners"]) == (
        ["ground", "crate"],
        ["drill"],
        ["hand"],
    )
    assert (scene["version"], scene["sample_rate"]) == (1, 8000)


def test_a_step_is_answered_by_a_frame_and_by_its_samples_if_asked():
    conversation = talk()
    (frame,) = ask(conversation, type="step", id=17, time=0.0)
    assert (frame["type"], frame["id"], frame["n"]) == ("frame", 17, 0)
    frame, block = ask(conversation, type="step", time=0.02, samples=True)
    samples = np.frombuffer(block, "<f4").reshape(len(frame["listeners"]), frame["n"])
    assert samples.shape == (1, 160)
    assert np.abs(samples).max() > 0
    assert frame["levels"]["hand"]["gains"]["drill"] > 0


@pytest.mark.parametrize(
    ("message", "where", "words"),
    [
        ("[1, 2", "", "not JSON"),
        ("{}", "/type", "must be one of hello, step"),
        ('{"type": "step", "time": "now"}', "/time", "must be a number"),
        ('{"type": "step", "time": 1, "pose": {}}', "/pose", "unknown key"),
        (
            '{"type": "step", "time": 1, "poses": {"crate": [1, 2, 3]}}',
            "/poses/crate",
            "expected x, y, z, qw",
        ),
        (
            '{"type": "step", "time": 1, "poses": {"crate": [1, 2, 3, 0, 0, 0, 0]}}',
            "/poses/crate",
            "rotation",
        ),
        (
            '{"type": "step", "time": 1, "poses": {"moon": [1, 2, 3, 1, 0, 0, 0]}}',
            "/poses/moon",
            "no object 'moon'",
        ),
        (
            '{"type": "step", "time": 1, "sources": {"drill": {"amplitude": 2}}}',
            "/sources/drill/amplitude",
            "at most 1",
        ),
        ('{"type": "step", "time": NaN}', "", "NaN"),
        ('{"type": "play", "source": "drill"}', "/source", "plays all the time"),
        (
            '{"type": "add", "object": {"name": "box", "kapa": 1}}',
            "/object",
            "is required|unknown key",
        ),
        ('{"type": "remove", "listener": "foot"}', "/listener", "no listener 'foot'"),
        ('{"type": "hello", "version": 2}', "/version", "must be 1"),
        (
            '{"type": "hello", "version": 1, "scene": {"objects": [{"name": 5}]}}',
            "/scene/objects/0",
            "required|string",
        ),
    ],
)
def test_a_message_that_is_not_valid_is_answered_by_its_place(message, where, words):
    conversation = talk()
    (error,) = conversation.answer(message)
    assert error["type"] == "error"
    assert error["where"].startswith(where)
    assert any(word in error["message"] for word in words.split("|")), error
    (frame,) = ask(conversation, type="step", time=0.5)
    assert frame["type"] == "frame"  # and the conversation goes on


def test_without_a_scene_there_are_no_steps():
    (error,) = ask(Conversation(None, None), type="step", id="a", time=0.0)
    assert (error["id"], error["where"]) == ("a", "/type")
    (error,) = ask(Conversation(None, None), type="hello", version=1)
    assert error["where"] == "/scene"


def test_too_many_objects_are_refused():
    many = [{"name": str(k), "kappa": 0, "rho": 0} for k in range(MOST_OBJECTS + 1)]
    (error,) = ask(Conversation(None, None), type="hello", version=1, scene={"objects": many})
    assert error["where"] == "/scene/objects"


def test_a_change_of_lists_is_answered_by_the_scene():
    conversation = talk()
    box = {"name": "box", "kappa": 0.1, "rho": 0.9}
    assert ask(conversation, type="add", object=box)[0]["objects"] == ["ground", "crate", "box"]
    assert ask(conversation, type="remove", object="box")[0]["objects"] == ["ground", "crate"]
    assert ask(conversation, type="stop") == [{"type": "stopped"}]


ENGINES = [("y", "right", 1.0), ("y", "left", 1.0), ("z", "left", 0.01), ("z", "right", 1.0)]
"""Godot, Unity, Unreal, Blender."""


def to_engine(convention, position):
    """What `Convention` says a scene's position is for an engine; checked by hand below."""
    return convention.position_back(position)


def test_axes_of_engines():
    """Up, and the axis that each engine's manual calls forward, of a viewer who looks along +y of
    the scene."""
    assert Convention("y", "right").position([1, 2, 3]) == [
        1,
        -3,
        2,
    ]  # Godot: x right, y up, -z forward
    assert Convention("y", "left").position([1, 2, 3]) == [
        1,
        3,
        2,
    ]  # Unity: x right, y up, z forward
    assert Convention("z", "left", 0.01).position([100, 200, 300]) == pytest.approx(
        [1, -2, 3]
    )  # Unreal: centimetres


@given(
    engine=st.sampled_from(ENGINES),
    quaternion=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1),
    point=st.tuples(*[st.floats(-9, 9)] * 3),
    place=st.tuples(*[st.floats(-9, 9)] * 3),
)
def test_a_point_on_a_turned_object_is_the_same_in_every_convention(
    engine, quaternion, point, place
):
    """Turning and moving a point in the engine and converting it gives what the converted pose does
    to the converted point. Engines turn by the same formula whatever the handedness of their
    axes."""
    convention = Convention(*engine)

    def turned(rotation, vector):
        w, *v = np.asarray(rotation) / np.linalg.norm(rotation)
        return vector + 2 * np.cross(v, np.cross(v, vector) + w * np.asarray(vector))

    moved = np.asarray(place) + turned(quaternion, np.asarray(point))
    ((x, y, z, *rotation),) = convention.poses(np.array([[*place, *quaternion]]))
    expected = np.array([x, y, z]) + turned(rotation, np.asarray(convention.position(point)))
    assert convention.position(moved) == pytest.approx(expected.tolist(), abs=1e-9)


@pytest.mark.parametrize(("up", "handedness", "unit"), ENGINES)
def test_the_same_fall_is_felt_alike_in_every_engine(up, handedness, unit):
    """A crate that falls and turns about the vertical: levels and impacts don't depend on the
    engine's axes."""

    def fall(conversation, convert):
        frames = []
        for k in range(40):
            height = max(1.0 - 9.81 / 2 * (k / 60) ** 2, 0.0) + 0.5
            turn = k / 90
            pose = convert((0.3, -0.2, height), turn)
            frames += ask(conversation, type="step", time=k / 60, poses={"crate": pose})
        return frames

    own = fall(talk(), lambda place, turn: [*place, math.cos(turn), 0, 0, math.sin(turn)])
    convention = Convention(up, handedness, unit)

    def convert(place, turn):
        axis = {"z": [0, 0, 1], "y": [0, 1, 0]}[up]
        side = (
            1 if handedness == "right" else -1
        )  # the same turn is the other way round in left-handed axes
        return [
            *to_engine(convention, place),
            math.cos(turn),
            *(side * math.sin(turn) * a for a in axis),
        ]

    there = fall(talk(up=up, handedness=handedness, metres_per_unit=unit), convert)
    assert [frame["levels"]["hand"]["level"] for frame in there] == [
        None
        if frame["levels"]["hand"]["level"] is None
        else pytest.approx(frame["levels"]["hand"]["level"], abs=1e-6)
        for frame in own
    ]
    (one,), (other,) = (
        [blow for frame in frames for blow in frame["impacts"]] for frames in (own, there)
    )
    assert other["energy"] == pytest.approx(one["energy"], rel=1e-9)
    assert convention.position(other["position"]) == pytest.approx(one["position"], abs=1e-9)


KEYS = [
    "type",
    "time",
    "poses",
    "sources",
    "contacts",
    "impacts",
    "object",
    "scene",
    "version",
    "id",
    "crate",
]
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=4)
    ),
)


@given(ANYTHING, st.sampled_from(["hello", "step", "add", "replace", "remove", "play", "stop"]))
def test_no_message_raises(message, kind):
    conversation = Conversation(None, None)
    if isinstance(message, dict):
        message["type"] = kind
    for answer in conversation.answer(json.dumps(message)):
        assert isinstance(answer, dict) and answer["type"] in ("error", "scene", "frame", "stopped")
