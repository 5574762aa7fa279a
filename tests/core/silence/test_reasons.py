"""Every reason for silence, in a scene made so that it holds; distances and decibels against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.contacts.tracker import Body, ContactSettings, Motion
from haptic_tracing.core.diagnosis.silence import Cause, Surroundings, reasons
from haptic_tracing.core.scene.functions import Exponential, Linear
from haptic_tracing.core.scene.values import HapticObject, Listener, Settings, Source
from haptic_tracing.core.signals import Sampled, Sine
from haptic_tracing.core.tracer import Frame, Tracer

CONTACTS = ContactSettings()
FUNCTION = Exponential(alpha=0.2)


def place(*positions):
    """Transforms of bodies that are not turned."""
    matrices = np.tile(np.eye(4), (len(positions), 1, 1))
    matrices[:, :3, 3] = positions
    return matrices


def frame(objects, shapes, positions, sources, listeners, settings=None, number=1):
    bodies = tuple(Body(o.name, shape, None, Motion.KINEMATIC) for o, shape in zip(objects, shapes, strict=True))
    return Frame(number, number / 24, objects, sources, listeners, settings or Settings(), bodies, place(*positions))


def traced(one, frames=1):
    """The result of tracing a frame so often, and its surroundings."""
    tracer = Tracer(CONTACTS)
    for number in range(frames):
        result = tracer.step(replace(one, number=number, time=number / 24))
    return result, Surroundings(one.bodies, one.transforms, CONTACTS)


def chain(gap=0.0, **changes):
    """Three boxes of 1 m in a row, the last one ``gap`` metres away; a source in the first, a listener in the last."""
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in ("ground", "bench", "seat"))
    return replace(
        frame(
            objects,
            (Box((1, 1, 1)),) * 3,
            ((0, 0, 0), (1, 0, 0), (2 + gap, 0, 0)),
            (Source("drill", "ground", (0, 0, 0), signal=Sine(100.0)),),
            (Listener("skin", "seat", (2 + gap, 0, 0)),),
        ),
        **changes,
    )


def why(one, frames=3, **more):
    result, around = traced(one, frames)
    return reasons(result, one.settings, 0, around, **more)


def test_who_feels_something_has_no_reason():
    assert why(chain()) == ()


@pytest.mark.parametrize(("gap", "words"), [(0.032, "3.2 cm"), (0.0205, "2.1 cm"), (2.5, "2.5 m")])
def test_gap_is_measured_and_named(gap, words):
    (reason,) = why(chain(gap))
    assert reason.cause is Cause.NO_CONTACT
    assert f"'bench' and 'seat' are {words} apart" in reason.words
    assert ("they touch from 1.0 cm on" in reason.words) == (gap < 0.1)


def test_distance_of_a_gap_is_that_of_the_shapes_not_of_their_boxes():
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in ("a", "b"))
    spheres = (Sphere(1.0), Sphere(1.0))
    one = frame(objects, spheres, ((0, 0, 0), (1.9, 1.9, 0)), (Source("s", "a"),), (Listener("l", "b", (1.9, 1.9, 0)),))
    (reason,) = why(one)
    assert f"are {100 * (1.9 * math.sqrt(2) - 2):.1f} cm apart" in reason.words


def test_several_gaps_are_counted_and_the_way_with_the_least_air_is_taken():
    names = ("ground", "bench", "seat", "far")
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in names)
    positions = ((0, 0, 0), (1.3, 0, 0), (2.5, 0, 0), (0, 90, 0))
    listener = Listener("skin", "seat", (2.5, 0, 0))
    (reason,) = why(frame(objects, (Box((1, 1, 1)),) * 4, positions, (Source("drill", "ground"),), (listener,)))
    assert "'ground' and 'bench' are 30.0 cm apart, and so are 1 more pair on the way" in reason.words


def test_without_surroundings_the_objects_are_named():
    one = chain(1.0)
    result, _ = traced(one)
    (reason,) = reasons(result, one.settings, 0)
    assert reason.words == "no contact leads from 'drill' on 'ground' to 'seat', on which 'skin' is"


def test_below_the_threshold_names_the_object_that_takes_the_most():
    one = chain()
    objects = (one.objects[0], replace(one.objects[1], propagation=Exponential(alpha=9.0)), one.objects[2])
    (reason,) = why(replace(one, objects=objects))
    total = 20 / math.log(10) * (0.2 * 0.5 + 9.0 + 0.2 * 0.5)
    assert reason.cause is Cause.BELOW_THRESHOLD
    assert reason.object == "bench"
    assert reason.decibels == pytest.approx(total, rel=1e-9)
    assert f"passes on −{total:.0f} dB, under the threshold of −60 dB" in reason.words
    assert "'bench' takes the most, 78 dB over 1.0 m" in reason.words
    assert "ground > bench > seat" in reason.words


def test_too_many_connections():
    (reason,) = why(chain(settings=Settings(max_connections=3)))
    assert reason.cause is Cause.TOO_LONG
    assert "has 5 connections, 3 are allowed" in reason.words


@pytest.mark.parametrize(("kappa", "rho", "why_not"), [(1.0, 0.5, "its kappa is 1"), (0.2, 0.0, "its rho is 0")])
def test_objects_that_pass_on_nothing(kappa, rho, why_not):
    one = chain()
    objects = (one.objects[0], HapticObject("bench", kappa, rho), one.objects[2])
    (reason,) = why(replace(one, objects=objects))
    assert (reason.cause, reason.object) == (Cause.BLOCKED, "bench")
    assert why_not in reason.words


def test_functions_that_end():
    one = chain()
    objects = (one.objects[0], HapticObject("bench", 0.0, 1.0, Linear(range=0.4)), one.objects[2])
    (reason,) = why(replace(one, objects=objects))
    assert reason.words == "'bench' passes on nothing over 1.0 m: see its function, linear"


def test_muted_silent_finished_and_missing_sources():
    one = chain()
    quiet = replace(one.sources[0], amplitude=0.0)
    assert why(replace(one, sources=(quiet,)))[0].words == "'drill' has amplitude 0"
    assert why(replace(one, sources=(quiet,)), muted={"drill"})[0].words == "'drill' is muted"
    over = replace(one.sources[0], signal=Sampled(np.ones(800), 8000.0))
    (reason,) = why(replace(one, sources=(over,)), frames=12)
    assert (reason.cause, reason.words) == (Cause.FINISHED, "the signal of 'drill' was over at 0.10 s")
    assert why(replace(one, sources=()))[0].cause is Cause.NO_SOURCE


def test_the_same_reason_is_said_once():
    one = chain(5.0)
    twins = tuple(replace(one.sources[0], name=f"drill {k}") for k in range(20))
    found = why(replace(one, sources=twins))
    assert 1 <= len(found) <= 8
    assert len(set(found)) == len(found)


@pytest.mark.parametrize("settings", [Settings(mode="SD"), Settings(localise=1.0)])
def test_only_the_nearest_listener(settings):
    one = chain(settings=settings)
    near = Listener("toe", "ground", (0.1, 0, 0))
    (reason,) = why(replace(one, listeners=(*one.listeners, near)))
    assert (reason.cause, reason.object) == (Cause.MODE, "toe")


def test_far_away_in_straight_line():
    (reason,) = why(chain(60.0, settings=Settings(mode="MD")))
    assert reason.cause is Cause.BELOW_THRESHOLD
    assert reason.decibels == pytest.approx(0.2 * 62 * 20 / math.log(10))
    assert why(chain(60.0, settings=Settings(mode="MN"))) == ()


def test_gain_of_the_listener():
    one = chain()
    deaf = replace(one.listeners[0], gain=0.0)
    assert why(replace(one, listeners=(deaf,)))[0].cause is Cause.LISTENER_GAIN


def test_one_frame_alone_is_not_rendered():
    assert why(chain(), frames=1)[0].cause is Cause.NOT_RENDERED


def test_under_the_threshold_of_feeling():
    one = chain()
    soft = replace(one.sources[0], amplitude=0.01, signal=Sine(40.0))
    (reason,) = why(replace(one, sources=(soft,)), frames=9)
    assert reason.cause is Cause.NOT_FELT
    assert "Hz is" in reason.words
    assert reason.decibels > 0


def test_a_pause_in_the_signal():
    assert why(chain(), recent=np.zeros(100))[0].cause is Cause.PAUSE


def test_a_media_of_authored_contacts_needs_no_bodies():
    one = chain(5.0)
    result, _ = traced(one)
    around = Surroundings((), np.zeros((0, 4, 4)), CONTACTS)
    assert reasons(result, one.settings, 0, around)[0].cause is Cause.NO_CONTACT
