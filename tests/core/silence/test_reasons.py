"""Every reason for silence, in a scene made so that it holds; distances and decibels against closed
forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body, ContactSettings, Motion
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.diagnosis.gaps import Surroundings
from haptic_tracing.core.diagnosis.silence import reasons
from haptic_tracing.core.message import Cause, Message
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
    bodies = tuple(
        Body(o.name, shape, None, Motion.KINEMATIC)
        for o, shape in zip(objects, shapes, strict=True)
    )
    return Frame(
        number,
        number / 24,
        objects,
        sources,
        listeners,
        settings or Settings(),
        bodies,
        place(*positions),
    )


def traced(one, frames=1):
    """The result of tracing a frame so often, and its surroundings."""
    tracer = Tracer(CONTACTS)
    for number in range(frames):
        result = tracer.step(replace(one, number=number, time=number / 24))
    return result, Surroundings(one.bodies, one.transforms, CONTACTS)


def chain(gap=0.0, **changes):
    """Three boxes of 1 m in a row, the last one ``gap`` metres away; a source in the first, a
    listener in the last."""
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in ("ground", "bench", "seat"))
    return replace(
        frame(
            objects,
            (Box((1, 1, 1)),) * 3,
            ((0, 0, 0), (1, 0, 0), (2 + gap, 0, 0)),
            (Source("drill", "ground", (0, 0, 0), signal=Sine(100.0)),),
            (Listener("skin", "seat", (2 + gap, 0, 0), radius=0.0),),
        ),
        **changes,
    )


def why(one, frames=3, **more):
    result, around = traced(one, frames)
    return reasons(result, one.settings, 0, around, **more)


def test_who_feels_something_has_no_reason():
    assert why(chain()) == ()


@pytest.mark.parametrize(
    ("gap", "cause"), [(0.032, Cause.NARROW_GAP), (0.0205, Cause.NARROW_GAP), (2.5, Cause.GAP)]
)
def test_gap_is_measured_and_named(gap, cause):
    (reason,) = why(chain(gap))
    assert (reason.cause, reason.object) == (cause, "seat")
    assert (reason["source"], reason["first"], reason["second"]) == ("drill", "bench", "seat")
    assert reason["distance"] == pytest.approx(gap, abs=1e-6)
    assert cause is Cause.GAP or reason["tolerance"] == CONTACTS.tolerance


def test_distance_of_a_gap_is_that_of_the_shapes_not_of_their_boxes():
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in ("a", "b"))
    spheres = (Sphere(1.0), Sphere(1.0))
    one = frame(
        objects,
        spheres,
        ((0, 0, 0), (1.9, 1.9, 0)),
        (Source("s", "a"),),
        (Listener("l", "b", (1.9, 1.9, 0), radius=0.0),),
    )
    (reason,) = why(one)
    assert reason["distance"] == pytest.approx(1.9 * math.sqrt(2) - 2, abs=1e-6)


def test_several_gaps_are_counted_and_the_way_with_the_least_air_is_taken():
    names = ("ground", "bench", "seat", "far")
    objects = tuple(HapticObject(name, 0.0, 1.0, FUNCTION) for name in names)
    positions = ((0, 0, 0), (1.3, 0, 0), (2.5, 0, 0), (0, 90, 0))
    listener = Listener("skin", "seat", (2.5, 0, 0), radius=0.0)
    (reason,) = why(
        frame(objects, (Box((1, 1, 1)),) * 4, positions, (Source("drill", "ground"),), (listener,))
    )
    assert (reason.cause, reason["first"], reason["second"], reason["count"]) == (
        Cause.SEVERAL_GAPS,
        "ground",
        "bench",
        2,
    )
    assert reason["distance"] == pytest.approx(0.3, abs=1e-6)


def test_without_surroundings_the_objects_are_named():
    one = chain(1.0)
    result, _ = traced(one)
    (reason,) = reasons(result, one.settings, 0)
    assert reason == Message.of(
        Cause.NO_CONTACT, "seat", source="drill", carrier="ground", object="seat", listener="skin"
    )


def test_below_the_threshold_names_the_object_that_takes_the_most():
    one = chain()
    objects = (
        one.objects[0],
        replace(one.objects[1], propagation=Exponential(alpha=18.0)),
        one.objects[2],
    )
    (reason,) = why(replace(one, objects=objects))
    total = 20 / math.log(10) * (0.2 * 0.5 + 18.0 + 0.2 * 0.5)
    assert reason.cause is Cause.BELOW_THRESHOLD
    assert reason.object == reason["object"] == "bench"
    assert reason["gain"] == pytest.approx(-total, rel=1e-9)
    assert reason["threshold"] == pytest.approx(-120)
    assert reason["loss"] == pytest.approx(20 / math.log(10) * 18.0)
    assert reason["distance"] == pytest.approx(1.0)
    assert reason["path"] == ("ground", "bench", "seat")


def test_too_many_connections():
    (reason,) = why(chain(settings=Settings(strategy="as_in_the_paper", max_connections=3)))
    assert reason.cause is Cause.TOO_LONG
    assert (reason["count"], reason["most"]) == (5, 3)


@pytest.mark.parametrize(
    ("kappa", "rho", "cause"), [(1.0, 0.5, Cause.KAPPA_ONE), (0.2, 0.0, Cause.RHO_ZERO)]
)
def test_objects_that_transmit_nothing(kappa, rho, cause):
    one = chain()
    objects = (one.objects[0], HapticObject("bench", kappa, rho), one.objects[2])
    (reason,) = why(replace(one, objects=objects))
    assert reason == Message.of(cause, "bench", object="bench")


def test_functions_that_end():
    one = chain()
    objects = (one.objects[0], HapticObject("bench", 0.0, 1.0, Linear(range=0.4)), one.objects[2])
    (reason,) = why(replace(one, objects=objects))
    assert (reason.cause, reason["object"], reason["function"]) == (
        Cause.FUNCTION_ZERO,
        "bench",
        "linear",
    )
    assert reason["distance"] == pytest.approx(1.0)


def test_muted_silent_finished_and_missing_sources():
    one = chain()
    quiet = replace(one.sources[0], amplitude=0.0)
    assert why(replace(one, sources=(quiet,))) == (
        Message.of(Cause.ZERO_AMPLITUDE, "drill", source="drill"),
    )
    assert why(replace(one, sources=(quiet,)), muted={"drill"}) == (
        Message.of(Cause.MUTED, "drill", source="drill"),
    )
    over = replace(one.sources[0], signal=Sampled(np.ones(800), 8000.0))
    (reason,) = why(replace(one, sources=(over,)), frames=12)
    assert reason == Message.of(Cause.FINISHED, "drill", source="drill", end=0.1)
    assert why(replace(one, sources=()))[0].cause is Cause.NO_SOURCE


def test_the_same_reason_is_said_once():
    one = chain(5.0)
    twins = tuple(replace(one.sources[0], name=f"drill {k}") for k in range(20))
    found = why(replace(one, sources=twins))
    assert 1 <= len(found) <= 8
    assert len(set(found)) == len(found)


def test_only_the_nearest_listener():
    one = chain(settings=Settings(mode="SD"))
    near = Listener("toe", "ground", (0.1, 0, 0), radius=0.0)
    (reason,) = why(replace(one, listeners=(*one.listeners, near)))
    assert (reason.cause, reason.object) == (Cause.NEAREST_LISTENER_ONLY, "toe")


def test_far_away_in_straight_line():
    (reason,) = why(chain(70.0, settings=Settings(mode="MD")))
    assert reason.cause is Cause.TOO_FAR
    assert reason["distance"] == pytest.approx(72)
    assert reason["gain"] == pytest.approx(-0.2 * 72 * 20 / math.log(10))
    assert reason["threshold"] == pytest.approx(-120)
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
    assert reason["frequency"] == pytest.approx(40, abs=24)  # the spectrum of one frame of 1/24 s
    assert reason["margin"] > 0


def test_so_far_under_it_that_nothing_is_rendered():
    one = chain()
    soft = replace(one.sources[0], amplitude=1e-4, signal=Sine(100.0))
    (reason,) = why(replace(one, sources=(soft,)))
    assert reason.cause is Cause.NOT_FELT
    assert reason["gain"] == pytest.approx(-0.2 * 2 * 20 / math.log(10))
    assert reason["level"] == pytest.approx(-80 - 3.01 + reason["gain"], abs=0.5)
    assert reason["margin"] > 20


def test_a_pause_in_the_signal():
    assert why(chain(), recent=np.zeros(100))[0].cause is Cause.PAUSE


def test_a_media_of_authored_contacts_needs_no_bodies():
    one = chain(5.0)
    result, _ = traced(one)
    around = Surroundings((), np.zeros((0, 4, 4)), CONTACTS)
    assert reasons(result, one.settings, 0, around)[0].cause is Cause.NO_CONTACT
