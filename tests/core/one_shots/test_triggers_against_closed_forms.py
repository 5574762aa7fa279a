"""Sources that play once per trigger: the moments of triggers, and what is heard, against closed
forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.settings import Body, Motion
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.diagnosis.silence import reasons
from haptic_tracing.core.message import sentence
from haptic_tracing.core.scene.functions import Identity, Physical
from haptic_tracing.core.scene.functions.modulation import Spectrum
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    Listener,
    Settings,
    Source,
    SourceKind,
    Trigger,
)
from haptic_tracing.core.signals import Constant, DecayingSine, Impulse, Noise
from haptic_tracing.core.tracer import Frame, Tracer

RATE = 24.0
KNOCK = DecayingSine(120.0, 0.02)
PLATE = HapticObject("plate", 0.2, 0.9, Identity())
SKIN = Listener("skin", "plate", s_max=1.0, radius=0.0)
G = 9.81


def source(*triggers, **more):
    return Source("bell", "plate", signal=KNOCK, triggers=triggers, **more)


def play(frames, make, tracer=None):
    """The results of frames, each made by ``make(number, time)``."""
    tracer = tracer or Tracer()
    return [tracer.step(make(number, number / RATE)) for number in frames]


def still(bell, listeners=(SKIN,)):
    return lambda number, time: Frame(number, time, (PLATE,), (bell,), listeners, contacts=None)


def onsets(results):
    return sorted({shot.onset for result in results for shot in result.shots})


def heard(results, listener=0):
    return np.concatenate(
        [result.block[listener] for result in results if result.block is not None]
    )


def test_at_given_times_the_signal_is_heard_as_it_is():
    results = play(
        range(25),
        still(source(Trigger((0.1003, 0.5, 0.52), (1.0, 0.25, 0.5)), amplitude=0.8)),
    )
    expected = 0.8 * sum(
        s * KNOCK.sample(0, 8000, 8000.0, t) for t, s in ((0.1003, 1.0), (0.5, 0.25), (0.52, 0.5))
    )
    np.testing.assert_allclose(heard(results), expected, atol=1e-12)
    # The two that have just begun.
    assert [item.kind for item in results[13].sources] == [SourceKind.TEMPORARY] * 2
    assert results[0].sources == () and results[24].sources == ()


def test_without_a_trigger_a_source_is_silent_and_one_that_needs_none_is_not():
    silent = play(range(5), still(source()))
    assert all(result.sources == () for result in silent) and not heard(silent).any()
    assert heard(play(range(5), still(replace(source(), triggers=None)))).any()
    (why,) = reasons(silent[-1], Settings(), 0, waiting=["bell"])
    assert sentence(why) == "'bell' waits for a trigger"


@pytest.mark.parametrize("first", [1, 7, 12])
def test_a_part_has_the_bits_of_the_whole_from_the_length_of_the_signal_on(first):
    bell = source(Trigger((0.05, 0.3, 0.61)), Trigger((0.4,), (0.5,)))
    whole = play(range(30), still(bell))
    back = math.ceil(KNOCK.duration * RATE) + 4
    part = play(range(max(first - back, 0), 30), still(bell))
    for one, other in zip(
        whole[max(first, back) :], part[max(first, back) - max(first - back, 0) :], strict=True
    ):
        assert one.shots == other.shots and one.sources == other.sources
        np.testing.assert_array_equal(one.block, other.block)


def test_a_level_plays_where_it_rises_above_0_with_its_height():
    levels = [0.0, 0.0, 0.5, 0.7, 0.0, -1.0, 2.0, 0.0]

    def make(number, time):
        return Frame(number, time, (PLATE,), (source(Trigger(value=levels[number])),), (SKIN,))

    results = play(range(len(levels)), make)
    assert {(shot.onset, shot.strength) for result in results for shot in result.shots} == {
        (2 / RATE, 0.5),
        (6 / RATE, 1.0),
    }


def test_a_frame_that_is_come_to_again_has_the_shots_that_it_had():
    def rising(*others):
        """A level that rises in frame 10."""

        def make(number, time):
            level = Trigger(value=float(number >= 10))
            plate = replace(PLATE, shape=Box((1, 1, 0.1)))
            return Frame(
                number,
                time,
                (plate,),
                (source(level, *others),),
                (SKIN,),
                bodies=(Body("plate", plate.shape, None, Motion.STATIC),),
                transforms=np.eye(4)[None],
            )

        return make

    make, tracer = rising(Trigger((0.42,))), Tracer()
    results = play(range(20), make, tracer)
    frame = 11  # both sound
    assert len(results[frame].shots) == 2
    again = tracer.step(replace(make(frame, frame / RATE), continuous=False, restore=True))
    assert (
        again.sources == results[frame].sources
        and again.amplitudes.tolist() == results[frame].amplitudes.tolist()
    )
    edited = tracer.step(replace(rising()(frame, frame / RATE), continuous=False, restore=True))
    assert [shot.risen for shot in edited.shots] == [True]


def test_a_still_frame_shows_the_blow_that_falls_into_it():
    frame = replace(still(source(Trigger((0.49,))))(12, 0.5), duration=1 / RATE)
    short = replace(frame.sources[0], signal=Impulse(0.002))
    assert [shot.onset for shot in Tracer().step(replace(frame, sources=(short,))).shots] == [0.49]


@pytest.mark.parametrize("signal", [Noise(), Constant(0.0, 0.1), Constant(1.0, 61.0)])
def test_a_signal_without_an_end_or_that_is_silent_or_too_long_is_refused(signal):
    with pytest.raises(ValueError, match="signal: the signal of an impact or a trigger must"):
        replace(source(), signal=signal)


def test_wrong_triggers_name_the_key():
    for key, form in (
        ("times", {"times": (math.nan,)}),
        ("strengths", {"times": (1.0, 2.0), "strengths": (1.0,)}),
        ("strengths", {"times": (1.0,), "strengths": (1.5,)}),
    ):
        with pytest.raises(ValueError, match=f"{key}: "):
            Trigger(**form)


# A pressure front: a one-shot in a medium that spreads in all directions.

SPEED, RADIUS, DECAY = 343.0, 0.5, 0.02
DISTANCES = (1.0, 5.0, 10.0, 20.0, 34.3)


def front(frames, blast, decay=DECAY, rate=RATE):
    function = Physical(
        loss_factor=0.0,
        thickness=1e6,
        absorption=decay,
        reference_distance=RADIUS,
        spectrum=Spectrum(wave_speed=SPEED),
    )
    air = HapticObject("air", 0.3, 0.8, function, medium=True)
    decay_of_k = replace(function, material_k=0.56)  # (1 - 0.3) 0.8: the decay is as it is given
    air = replace(air, propagation=decay_of_k)
    ears = tuple(Listener(f"ear {d}", "air", (d, 0.0, 0.0), radius=0.0) for d in DISTANCES)
    tracer = Tracer()
    return [tracer.step(Frame(n, n / rate, (air,), (blast,), ears)) for n in frames]


def test_a_front_arrives_after_distance_over_speed_and_falls_with_the_distance():
    onset = 0.1
    blast = Source("blast", "air", signal=Impulse(0.004), triggers=(Trigger((onset,)),))
    results = front(range(12), blast)
    for k, d in enumerate(DISTANCES):
        samples = heard(results, k)
        arrival = np.flatnonzero(np.abs(samples) > 1e-9)[0] / 8000.0
        assert arrival == pytest.approx(onset + d / SPEED, abs=1 / 8000.0)
        middle = (onset + d / SPEED + 0.002) * 8000.0  # of the half-sine
        assert np.argmax(samples) == pytest.approx(middle, abs=1)
        level = RADIUS / (RADIUS + d) * math.exp(-DECAY * d)
        assert samples.max() == pytest.approx(level, rel=5e-3)
    gains = next(result.amplitudes[0] for result in results if result.sources)
    np.testing.assert_allclose(
        gains, [RADIUS / (RADIUS + d) * math.exp(-DECAY * d) for d in DISTANCES], rtol=1e-9
    )


def test_a_front_reaches_objects_in_the_medium_when_it_is_there():
    """Two panes on either side, touched by the air at 3.43 and 6.86 m, which pass everything on."""
    function = Physical(
        loss_factor=0.0,
        reference_distance=RADIUS,
        thickness=1e6,
        spectrum=Spectrum(wave_speed=SPEED),
    )
    air = HapticObject("air", 0.3, 0.8, function, medium=True)
    panes = tuple(HapticObject(f"pane {k}", 0.3, 0.8, Identity()) for k in (1, 2))
    places = ((3.43, 0.0, 0.0), (0.0, -6.86, 0.0))
    contacts = tuple(
        Contact(("air", pane.name), (place, place))
        for pane, place in zip(panes, places, strict=True)
    )
    touching = ContactSet.from_contacts(contacts, {"air": 0, "pane 1": 1, "pane 2": 2})
    hands = tuple(Listener(f"hand {k}", f"pane {k}", (9.0, 9.0, 9.0), radius=0.0) for k in (1, 2))
    blast = Source("blast", "air", signal=Impulse(0.004), triggers=(Trigger((0.05,)),))
    results = play(
        range(6), lambda n, t: Frame(n, t, (air, *panes), (blast,), hands, contacts=touching)
    )
    for k, d in enumerate((3.43, 6.86)):
        samples = heard(results, k)
        assert np.argmax(samples) == pytest.approx((0.05 + d / SPEED + 0.002) * 8000.0, abs=1)
        assert samples.max() == pytest.approx(RADIUS / (RADIUS + d), rel=5e-3)


def test_what_is_short_is_felt_far_away_long_after_it_was_played():
    """At 34.3 m a blow of 4 ms comes 2.4 frames late, when its source has long been silent."""
    results = front(
        range(9),
        Source("blast", "air", signal=Impulse(0.004), triggers=(Trigger((0.1,)),)),
        decay=0.0,
    )
    assert [bool(result.sources) for result in results] == [False] * 3 + [True] * 3 + [False] * 3
    far = heard(results, -1)
    assert np.sum(far) == pytest.approx(
        np.sum(heard(results, 0)) * (RADIUS + 1.0) / (RADIUS + 34.3), rel=3e-3
    )
