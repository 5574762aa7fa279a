"""The hands of a VR session, at poses that no controller has to be moved to."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.tracer import Tracer
from haptic_tracing.plugins.vr import actions, recording
from haptic_tracing.plugins.vr.hands import Glide, Hands, frame_of, settings_of
from haptic_tracing.sample_scenes import SAMPLES

FAR = ((100.0, 0.0, 50.0), (1.0, 0.0, 0.0, 0.0))
STRAIGHT = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture
def reading():
    scene = bpy.data.scenes.new("Demo")
    SAMPLES["jackhammer_bench"].build(scene)
    bpy.context.window.scene = scene
    scene.frame_set(1)
    session.trace(scene, bpy.context.evaluated_depsgraph_get())
    yield session.of(scene).reading
    bpy.data.scenes.remove(scene)


def top_of(reading, part):
    """A place on an object, 2 cm above which its bounding box ends."""
    number = next(k for k, body in enumerate(reading.bodies) if part in body.name.lower())
    low, high = reading.bodies[number].shape.local_bounds
    middle = (low + high) / 2
    place = reading.transforms[number] @ [middle[0], middle[1], high[2], 1.0]
    return tuple(place[:3].tolist())


def trace(reading, grips, seconds=0.3, rate=90):
    tracer = Tracer(settings_of(reading.contact_settings), lazy=True)
    results = []
    for k in range(round(seconds * rate)):
        given = grips(k / rate) if callable(grips) else grips
        results.append(
            tracer.step(frame_of(reading, reading.transforms, given, k / rate, k + 1, k > 0))
        )
    return results


def levels(results):
    block = np.concatenate([result.block for result in results if result.block is not None], axis=1)
    return np.sqrt(2 * np.mean(block**2, axis=1))


def test_a_hand_feels_what_it_touches_and_the_other_one_nothing(reading):
    ground = top_of(reading, "ground")
    jackhammer = top_of(reading, "jackhammer")
    for place in (ground, jackhammer):
        left, right = levels(trace(reading, {"left": (place, STRAIGHT), "right": FAR}))
        assert left > 0.01
        assert right == 0.0
    left, right = levels(trace(reading, {"left": FAR, "right": (jackhammer, STRAIGHT)}))
    assert left == 0.0
    assert right > 0.01


def test_the_reading_stays_as_it_is(reading):
    objects, transforms = reading.objects, reading.transforms.copy()
    trace(reading, {"left": FAR, "right": FAR}, 0.05)
    assert reading.objects is objects
    assert np.array_equal(reading.transforms, transforms)
    assert not any(obj.name.startswith("VR hand") for obj in bpy.data.objects)


def test_a_knock_is_felt_and_a_faster_one_more(reading):
    reading = type(reading)(
        **{name: getattr(reading, name) for name in reading.__slots__ if name != "sources"},
        sources=(),
    )
    place = np.array(top_of(reading, "bench"))

    def knock(speed):
        def grips(time):
            height = max(0.25 - speed * time, 0.0)
            return {"left": (tuple(place + np.array([0, 0, height])), STRAIGHT), "right": FAR}

        return grips

    felt = []
    for speed in (0.0, 0.5, 2.0):
        results = trace(reading, knock(speed), 0.8)
        felt.append(levels(results)[0])
        struck = [impact for result in results for impact in result.impacts]
        assert bool(struck) == (speed > 0)
    assert felt[0] == 0.0 < felt[1] < felt[2]


def test_frames_are_traced_on_the_side(reading):
    hands = Hands()
    grips = {"left": (top_of(reading, "jackhammer"), STRAIGHT), "right": FAR}
    felt = []
    for k in range(20):
        felt += hands.step(reading, None, grips, k / 60)
        if hands.running is not None:
            hands.running.result()
    hands.end()
    assert [frame.result.number for frame in felt] == list(range(1, len(felt) + 1))
    assert len(felt) >= 19
    assert max(frame.levels[0] for frame in felt) > 0.01
    assert felt[-1].transforms.shape == (2, 4, 4)


def step(hands, reading, grips, number):
    """What was felt by the end of a frame of the session."""
    felt = hands.step(reading, None, grips, number / 60)
    if hands.running is not None:
        hands.running.exception()
        felt += hands._collect(1.0)
    return felt


def test_hands_go_on_beside_recorded_ones_and_after_their_removal(reading):
    scene, place = bpy.context.scene, (top_of(reading, "jackhammer"), STRAIGHT)
    hands, grips = Hands(), {"left": place, "right": FAR}
    before, made = set(bpy.data.objects), []
    for number in range(60):
        if number == 20:
            recording.add(scene, {1: grips, 2: {"right": FAR}})
            made = [obj for obj in bpy.data.objects if obj not in before and obj.haptics.enabled]
            assert sorted(obj.name for obj in made) == ["VR hand, left", "VR hand, right"]
        if number == 40:
            for obj in made:
                bpy.data.objects.remove(obj)
        if number % 20 == 0:
            scene.frame_set(scene.frame_current)
            session.trace(scene, bpy.context.evaluated_depsgraph_get())
            loudest = 0.0
        felt = step(hands, session.of(scene).reading, grips, number)
        assert hands.failure is None
        loudest = max(loudest, *(frame.levels[0] for frame in felt))
        assert number % 20 != 19 or loudest > 0.01
    hands.end()


def test_a_controller_that_is_not_tracked_has_no_hand(reading):
    place, number = (top_of(reading, "jackhammer"), STRAIGHT), 0
    hands = Hands()
    for grips in ({"right": place}, {}, {"left": FAR, "right": place}):
        loudest = np.zeros(2)
        for _ in range(20):
            number += 1
            for frame in step(hands, reading, grips, number):
                assert frame.hands == tuple(grips)
                assert frame.transforms.shape == (len(grips), 4, 4)
                if frame.block is not None:
                    loudest = np.maximum(loudest, np.abs(frame.block).max(axis=1))
        assert loudest[0] == 0.0
        assert (loudest[1] > 0.01) == bool(grips)
    hands.end()


def test_grips_are_those_of_tracked_controllers(monkeypatch):
    """Poses read from Blender 5.2 with Monado: the right controller was switched off. The left one
    is turned by a degree, because simulated ones are held level."""
    places = [(6.894772, -6.687779, 4.659798), (7.352517, -6.932463, 3.359798)]
    turned = [
        (0.657552, 0.642597, 0.275461, 0.280588),
        (0.649215042591095, 0.649215042591095, 0.2802139222621918, 0.2802139222621918),
    ]
    state = SimpleNamespace(
        controller_grip_location_get=lambda context, number: places[number],
        controller_grip_rotation_get=lambda context, number: turned[number],
    )
    monkeypatch.setattr(actions, "session_state", lambda: state)
    assert actions.grips() == {"left": (places[0], turned[0])}


def test_a_failure_is_kept_for_the_panel_until_a_frame_is_traced(reading):
    hands, grips = Hands(), {"left": FAR, "right": FAR}
    hands.tracer = SimpleNamespace(
        collisions=SimpleNamespace(settings=None), step=lambda frame: {}["no such thing"]
    )
    assert step(hands, reading, grips, 1) == []
    assert isinstance(hands.failure, KeyError)
    assert len(step(hands, reading, grips, 2)) == 1
    assert hands.failure is None
    hands.end()


def test_bodies_glide_from_frame_to_frame_of_the_timeline_at_their_speed():
    """A body that moves at 2 m/s and turns, read 24 times a second, seen 90 times."""
    glide, seen, speed = Glide(), [], 2.0
    for k in range(90):
        time = k / 90
        if not seen or int(time * 24) != seen[-1][2]:
            angle, place = 0.5 * int(time * 24) / 24, np.eye(4)
            place[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
            place[0, 3] = speed * int(time * 24) / 24
            read = np.array([place])
        now, continues = glide.at(read, int(time * 24), time)
        seen.append((now[0, 0, 3], continues, int(time * 24)))
        assert np.allclose(now[0, :3, :3] @ now[0, :3, :3].T, np.eye(3))
    speeds = np.diff([x for x, _, _ in seen])[12:] * 90
    assert speeds.max() < 1.6 * speed
    assert np.mean(speeds) == pytest.approx(speed, rel=0.05)
    assert all(continues for _, continues, _ in seen[1:])


def test_bodies_that_jump_do_not_glide():
    glide, here, there = Glide(), np.eye(4)[None], np.eye(4)[None] * 1.0
    there[0, 0, 3] = 5.0
    assert glide.at(here, 10, 0.0)[1] is False
    moved, continues = glide.at(there, 1, 0.04)  # the timeline starts again
    assert moved is there
    assert not continues
    moved, continues = glide.at(here, None, 0.08)  # an edit
    assert moved is here
    assert not continues
