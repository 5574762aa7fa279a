"""The messages to a server, without a socket: answers, errors with their place, axes and units."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from crate_on_ground import SCENE
from haptic_tracing.command_line.serve.convention import Convention
from haptic_tracing.command_line.serve.conversation import MOST_OBJECTS, Conversation
from haptic_tracing.command_line.serve.mailboxes import Outbox
from hypothesis import given
from hypothesis import strategies as st


def ask(conversation, **message):
    return conversation.answer(json.dumps(message))


def talk(**hello):
    conversation = Conversation(None)
    (scene,) = ask(conversation, type="hello", version=1, scene=SCENE, **hello)
    assert scene["type"] == "scene", scene
    return conversation


def test_hello_names_what_the_scene_has():
    (scene,) = ask(Conversation(None), type="hello", version=1, scene=SCENE)
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
    (error,) = ask(Conversation(None), type="step", id="a", time=0.0)
    assert (error["id"], error["where"]) == ("a", "/type")
    (error,) = ask(Conversation(None), type="hello", version=1)
    assert error["where"] == "/scene"


def test_too_many_objects_are_refused():
    many = [{"name": str(k), "kappa": 0, "rho": 0} for k in range(MOST_OBJECTS + 1)]
    (error,) = ask(Conversation(None), type="hello", version=1, scene={"objects": many})
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
    conversation = Conversation(None)
    if isinstance(message, dict):
        message["type"] = kind
    for answer in conversation.answer(json.dumps(message)):
        assert isinstance(answer, dict) and answer["type"] in ("error", "scene", "frame", "stopped")


def words(*messages):
    return [json.dumps(message) for message in messages]


def step(k, **more):
    return {"type": "step", "id": k, "time": k / 60, **more}


def kinds(answers):
    """What is answered, in short."""
    return [
        one["answers"] if one["type"] == "frame" else one["type"]
        for answer in answers
        for one in answer
        if isinstance(one, dict)
    ]


def test_of_steps_that_wait_only_the_newest_is_answered():
    alone, together = talk(), talk()
    poses = [{"crate": [0.01 * k, 0, 0.5, 1, 0, 0, 0]} for k in range(8)]
    each = [ask(alone, **step(k, poses=poses[k]))[0] for k in range(8)]
    assert [frame["answers"] for frame in each] == [[k] for k in range(8)]
    ((frame,),) = together.answers(words(*(step(k, poses=poses[k]) for k in range(8))))
    assert (frame["id"], frame["answers"]) == (7, list(range(8)))
    assert frame["levels"]["hand"]["gains"] == each[-1]["levels"]["hand"]["gains"]
    assert (frame["first_sample"], frame["n"]) == (0, sum(one["n"] for one in each))


@pytest.mark.parametrize(
    ("messages", "expected"),
    [
        ([step(0), step(1, samples=True), step(2), step(3)], [[0, 1], [2, 3]]),
        ([step(0), {"type": "stop"}, step(1), step(2)], [[0], "stopped", [1, 2]]),
        (
            [step(0), {"type": "add", "object": {"name": "b", "kappa": 0, "rho": 0}}, step(1)],
            [[0], "scene", [1]],
        ),
        (
            [step(0), {"type": "remove", "source": "drill"}, step(1), step(2)],
            [[0], "scene", [1, 2]],
        ),
        ([step(0), step(1), step(100), step(101)], [[0, 1], [100, 101]]),
        ([step(9), step(10), step(3), step(4)], [[9, 10], [3, 4]]),
        ([step(0), step(1, poses={"moon": []}), step(2)], ["error", [0, 2]]),
        ([step(0), step(0), step(1)], [[0], "error", [1]]),
        (
            [
                step(0, sources={"drill": {"playing": False}}),
                step(1, sources={"drill": {"playing": True}}),
                step(2, sources={"drill": {"amplitude": 0.5}}),
                step(3, sources={"drill": {"playing": False}}),
                step(4, sources={"drill": {"playing": True}}),
            ],
            [[0, 1, 2], [3, 4]],
        ),
    ],
)
def test_what_ends_a_merge(messages, expected):
    """Samples that are asked for, changes of what there is, beginnings, and what stops a source
    that has begun; a message that is not valid does not."""
    assert kinds(talk().answers(words(*messages))) == expected


def test_a_source_that_begins_and_ends_in_steps_that_wait_is_felt():
    conversation = talk()
    off, on = ({"drill": {"playing": playing}} for playing in (False, True))
    last = [step(k, sources=off) for k in range(40)]
    *_, (quiet,) = conversation.answers(words(*last))
    assert quiet["levels"]["hand"]["level"] is None
    answers = [
        *conversation.answers(
            words(step(40, sources=on), step(41), step(42, sources=off), step(43))
        )
    ]
    assert kinds(answers) == [[40, 41], [42, 43]]
    assert answers[0][0]["levels"]["hand"]["level"] is not None


def test_frames_that_are_not_read_leave_their_blows_and_names():
    outbox = Outbox()
    frames = [
        {"type": "frame", "answers": [k], "first_sample": 10 * k, "n": 10, "impacts": [k] * k}
        for k in range(5)
    ]
    outbox.put(frames[:1])
    outbox.put([{"type": "scene"}])
    for frame in frames[1:]:
        outbox.put([frame])
    assert outbox.take() == [frames[0]]
    assert outbox.take() == [{"type": "scene"}]
    (newest,) = outbox.take()
    assert newest["answers"] == [4]
    assert newest["impacts"] == [1, 2, 2, 3, 3, 3, 4, 4, 4, 4]
    assert newest["dropped"] == [
        {"answers": [k], "first_sample": 10 * k, "n": 10} for k in (1, 2, 3)
    ]
    outbox.close()
    assert not outbox.take()


def test_who_reads_nothing_for_good_is_not_kept():
    outbox = Outbox()
    frame = {"type": "frame", "answers": [], "first_sample": 0, "n": 0, "impacts": [0] * 1000}
    kept = [outbox.put([dict(frame)]) for _ in range(100)]
    assert kept[:60] == [True] * 60 and not kept[-1]


def test_a_fault_of_the_program_is_an_answer_and_the_conversation_goes_on(monkeypatch, capsys):
    conversation = talk()
    ask(conversation, **step(0))

    def fail(*arguments):
        raise KeyError("inside")

    with monkeypatch.context() as broken:
        broken.setattr(type(conversation.run._tracer), "step", fail)
        (error,) = ask(conversation, **step(1))
    assert (error["type"], error["id"], conversation.failures) == ("error", 1, 1)
    assert "KeyError" in capsys.readouterr().err
    (frame,) = ask(conversation, **step(2))
    assert (frame["answers"], frame["n"]) == ([2], 0)


NAMES = ["a", "b", "c", "d"]
SHAPES = st.sampled_from(
    [
        None,
        {"type": "box", "size": [1, 1, 1]},
        {"type": "sphere", "radius": 0.5},
        {"type": "capsule", "radius": 0.2, "height": 1},
        {"type": "convex_hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
    ]
)
PLACES = st.lists(st.sampled_from([-1.0, 0.0, 0.25, 1.0, 40.0]), min_size=3, max_size=3)
POSES = st.builds(lambda place, turn: [*place, *turn], PLACES,
                  st.sampled_from([[1, 0, 0, 0], [0.5, 0.5, 0.5, 0.5], [0, 0, -3, 4]]))  # fmt: skip


def without_none(**form):
    return {key: value for key, value in form.items() if value is not None}


@st.composite
def valid_object(draw, name):
    return without_none(
        name=name,
        kappa=draw(st.sampled_from([0, 0.1, 1])),
        rho=draw(st.sampled_from([0, 0.8, 1])),
        shape=draw(SHAPES),
        motion=draw(st.sampled_from([None, "static", "dynamic"])),
        mass=draw(st.sampled_from([None, 5])),
        pose=draw(st.none() | st.builds(lambda place: {"position": place}, PLACES)),
    )


@st.composite
def valid_source(draw, name, objects):
    triggers = st.sampled_from([None, [], [{"times": [0.1]}]])
    return without_none(
        name=name,
        object=draw(st.sampled_from(objects)),
        position=draw(PLACES),
        triggers=draw(triggers),
    )


@st.composite
def valid_listener(draw, name, objects):
    return without_none(
        name=name,
        object=draw(st.sampled_from(objects)),
        position=draw(PLACES),
        radius=draw(st.sampled_from([None, 0, 0.5])),
    )


@st.composite
def pairs(draw, objects):
    return draw(st.permutations(objects))[:2]


@st.composite
def valid_messages(draw):
    """A scene of shaped and shapeless objects, and messages about what there is."""
    objects = draw(st.lists(st.sampled_from(NAMES), min_size=2, max_size=4, unique=True))
    contact = st.builds(
        lambda pair, place: {"objects": pair, "positions": [place, place]}, pairs(objects), PLACES
    )
    scene = {
        "objects": [draw(valid_object(name)) for name in objects],
        "sources": [draw(valid_source("s", objects))],
        "listeners": [draw(valid_listener("l", objects))],
        **draw(st.sampled_from([{}, {"contacts": [draw(contact)]}])),
        "rules": {"least_energy": 0.01, "full_energy": 10.0},
    }
    messages = [{"type": "hello", "version": 1, "scene": scene}]
    time = draw(st.sampled_from([0.0, 1.7e9, -5.0]))
    for _ in range(draw(st.integers(2, 12))):
        kind = draw(
            st.sampled_from(["step"] * 6 + ["replace", "remove", "add", "play", "stop", "source"])
        )
        if kind == "step":
            time += draw(st.sampled_from([1 / 60, 0.1, 0.2, 0.5, -1.0]))
            impact = st.builds(
                lambda pair, place, how: {"objects": pair, "position": place, **how},
                pairs(objects),
                PLACES,
                st.sampled_from([{"energy": 50.0}, {"normal_speed": 3.0}]),
            )
            messages.append(
                without_none(
                    type="step",
                    time=time,
                    poses=draw(st.none() | st.dictionaries(st.sampled_from(objects), POSES)),
                    impacts=draw(st.none() | st.lists(impact, max_size=2)),
                    contacts=draw(st.none() | st.none() | st.lists(contact, max_size=2)),
                    sources=draw(st.sampled_from([None, {"s": {"playing": False}}])),
                    samples=draw(st.sampled_from([None, True])),
                )
            )
        elif kind == "replace":
            messages.append(
                {"type": kind, "object": draw(valid_object(draw(st.sampled_from(objects))))}
            )
        elif kind == "source":
            messages.append({"type": "replace", "source": draw(valid_source("s", objects))})
        elif kind in ("remove", "add"):
            spare = "spare"
            messages.append({"type": "add", "object": draw(valid_object(spare))})
            messages.append({"type": "add", "listener": draw(valid_listener("m", [spare]))})
            if kind == "remove":
                messages.append({"type": "step", "time": (time := time + 0.02)})
            messages.append({"type": "remove", "object": spare})
        else:
            messages.append(without_none(type=kind, source="s" if kind == "play" else None))
    return messages


@given(valid_messages(), st.booleans())
def test_valid_messages_about_mixed_scenes_are_answered(messages, together):
    """No valid message ends in a fault of the program, alone or while others wait; what plays all
    the time can't be played, which is all that is refused."""
    conversation = Conversation(None)
    texts = words(*messages)
    batches = [texts] if together else [[text] for text in texts]
    answers = [answer for batch in batches for answer in conversation.answers(batch)]
    assert conversation.failures == 0
    for first, *_ in filter(None, answers):
        assert first["type"] != "error" or "plays all the time" in first["message"], first
