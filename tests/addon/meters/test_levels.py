"""History, levels and stills against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.addon.scene_reader.reading import Reading
from haptic_tracing.addon.session.sessions import Traced
from haptic_tracing.addon.view.comparison import mode_amplitudes
from haptic_tracing.addon.view.levels import (
    levels,
    margin_words,
    place_of,
    shown_levels,
    titles,
)
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.settings import ContactSettings
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.render.history import History, still_samples
from haptic_tracing.core.render.mixdown import with_block
from haptic_tracing.core.scene.body import BODY_PARTS
from haptic_tracing.core.scene.body_map import HALF_WIDTH, HEIGHT, figure
from haptic_tracing.core.scene.functions import Exponential
from haptic_tracing.core.scene.values import (
    HapticObject,
    Listener,
    Mode,
    Settings,
    Source,
    SourceKind,
)
from haptic_tracing.core.signals import Sine
from haptic_tracing.core.tracer import Frame, Tracer

RATE = 8000.0


def traced(result, history):
    """What the session keeps of a frame, traced rather than read from a track."""
    reading = Reading((), (), np.zeros((0, 4, 4)), (), (), Settings(), ContactSettings(), {}, ())
    return Traced(result, Settings(), history.all(), reading)


def played(frames, amplitude=0.5, frequency=100.0, distance=1.0, settings=None, **listener):
    """A sine on a plank, felt ``distance`` metres away with e^(-0.2 d), and one that nothing
    reaches; frames of 1/25 s."""
    objects = (
        HapticObject("plank", 0.0, 1.0, Exponential(alpha=0.2)),
        HapticObject("moon", 0.0, 1.0),
    )
    sources = (Source("hum", "plank", (0, 0, 0), amplitude, signal=Sine(frequency)),)
    listeners = (
        Listener("hand", "plank", (distance, 0, 0), "hand.L", **listener, radius=0.0),
        Listener("eye", "moon", radius=0.0),
    )
    tracer, history = Tracer(), History()
    for number in range(frames):
        result = tracer.step(
            Frame(
                number,
                number / 25,
                objects,
                sources,
                listeners,
                settings or Settings(),
                contacts=ContactSet.empty(),
            )
        )
        history.feed(result)
    return result, history


def test_history_is_the_last_second():
    result, history = played(40)
    hand, eye = history.all()
    assert hand.shape == (8000,)
    assert np.array_equal(hand[-320:], result.block[0])
    assert not eye.any()
    wave = (
        0.5
        * math.exp(-0.2)
        * np.sin(2 * math.pi * 100 * (result.time - 1 + np.arange(8000) / RATE))
    )
    np.testing.assert_allclose(hand, wave, rtol=0, atol=1e-9)


def test_a_jump_begins_anew():
    result, history = played(20)
    history.feed(replace(result, first_sample=result.first_sample + 9))
    assert history.all().shape == (2, 320)


def test_levels_of_a_sine():
    result, history = played(40)
    felt, nothing = shown_levels(traced(result, history), True)
    amplitude = 0.5 * math.exp(-0.2)
    assert felt.rms == pytest.approx(20 * math.log10(amplitude / math.sqrt(2)), abs=0.01)
    assert felt.margin == pytest.approx(
        20 * math.log10(amplitude) - float(threshold_level(100.0)), abs=0.1
    )
    assert felt.is_felt
    assert round(felt.rms) == -11
    assert felt.margin_text() == "+23 dB"
    assert (nothing.rms, nothing.margin) == (-math.inf, -math.inf)
    assert not nothing.is_felt
    assert (felt.verdict(), nothing.verdict()) == ("Felt: +23 dB", "Feels nothing")


def test_too_weak_to_be_felt():
    result, history = played(20, amplitude=0.1, frequency=40.0)
    level = shown_levels(traced(result, history), True)[0]
    assert not level.is_felt
    assert level.margin_text() == f"−{float(threshold_level(40.0)) + 20 + 1.74:.0f} dB"


def test_a_frame_that_stands_alone_is_as_loud_as_the_same_frames_playing():
    """So that a change of mode shows on the meters while nothing plays."""
    result, history = played(40, gain=0.8)
    still = replace(result, block=None)
    alone = History()
    alone.feed(still)
    for one, other in zip(
        shown_levels(traced(result, history), True),
        shown_levels(traced(still, alone), False),
        strict=True,
    ):
        assert one.rms == pytest.approx(other.rms, abs=0.05)
        assert one.margin == pytest.approx(other.margin, abs=0.2)
    assert still_samples(still, 0.25).shape == (2, 2000)


@pytest.mark.parametrize("frames", [1, 2, 3, 5, 8, 40])
def test_a_steady_sine_reads_the_same_on_every_still_however_the_timeline_came_to_it(frames):
    """60 Hz, in the 15 whole periods of a quarter second: its amplitude divided by the square root
    of 2."""
    result, history = played(frames, frequency=60.0)
    expected = 20 * math.log10(0.5 * math.exp(-0.2) / math.sqrt(2))
    assert shown_levels(traced(result, history), False)[0].rms == pytest.approx(expected, abs=0.01)
    assert shown_levels(traced(result, history), True)[0].rms == pytest.approx(expected, abs=0.01)


def test_a_still_shows_an_impact_of_its_own_frame():
    """Its onset lies within the frame's interval: what follows is felt, although hardly anything of
    it has been played."""
    objects = (HapticObject("plank", 0.0, 1.0, Exponential(alpha=0.2)),)
    blow = Source(
        "blow", "plank", (0, 0, 0), 0.5, SourceKind.TEMPORARY, Sine(100.0), onset=19 / 25 + 0.039
    )
    listeners = (Listener("hand", "plank", (1, 0, 0), radius=0.0),)
    tracer, history = Tracer(), History()
    for number in range(21):
        sources = (blow,) if number == 20 else ()
        result = tracer.step(
            Frame(number, number / 25, objects, sources, listeners, contacts=ContactSet.empty())
        )
        history.feed(result)
    still, playing = (
        shown_levels(traced(result, history), is_playing)[0] for is_playing in (False, True)
    )
    assert still.is_felt
    assert still.rms > playing.rms + 10


def test_a_frame_of_a_track_reads_what_was_recorded():
    result, history = played(3)
    recorded = Traced(result, Settings(), history.all())
    assert (
        shown_levels(recorded, False)
        == shown_levels(recorded, True)
        == levels(result, history.all())
    )


def test_places_and_texts():
    places = [place_of(margin) for margin in (-math.inf, -20.0, 0.0, 10.0, 40.0, 60.0)]
    assert places == pytest.approx([0, 0, 1 / 3, 0.5, 1, 1])
    assert [margin_words(margin) for margin in (-math.inf, -11.6, -0.2, 0.0, 3.2)] == [
        "",
        "−12 dB",
        "0 dB",
        "0 dB",
        "+3 dB",
    ]


def test_titles_are_as_short_as_they_are_unique():
    def titled(*named):
        return titles([Listener(name, "plank", body_part=part) for name, part in named])

    left, right = ("Ann ear.L", "ear.L"), ("Ann ear.R", "ear.R")
    assert titled(left, right, ("seat", "hips"), ("rod", "")) == ["ear.L", "ear.R", "seat", "rod"]
    assert titled(left, ("Bob ear.L", "ear.L"), right) == ["Ann ear.L", "Bob ear.L", "ear.R"]


def test_every_body_part_is_on_a_figure_and_mirrored():
    views = {view: {limb.part: limb for limb in figure(view)} for view in ("front", "back")}
    assert set(views["front"]) | set(views["back"]) == {part.name for part in BODY_PARTS}
    for limbs in views.values():
        for part in BODY_PARTS:
            if part.name in limbs:
                limb, other = limbs[part.name], limbs[part.mirror]
                if part.side:
                    assert (limb.start[0], limb.start[1]) == (-other.start[0], other.start[1])
                for x, y in (limb.start, limb.end):
                    assert abs(x) + limb.width / 2 <= HALF_WIDTH
                    assert y >= limb.width / 2
                    assert y + limb.width / 2 <= HEIGHT
    # Who looks at somebody's face sees that one's left hand at the right.
    assert views["front"]["hand.L"].start[0] > 0 > views["back"]["hand.L"].start[0]


def test_compared_modes_are_those_that_tracing_gives():
    settings = Settings()
    result, history = played(3, settings=settings)
    frame = replace(traced(result, history), settings=settings)
    gains = {mode: mode_amplitudes(mode, frame) for mode in Mode}
    for mode, gain in gains.items():
        assert gain == pytest.approx(0.5 * propagate(result.graph, Settings(mode=mode)).gain[0])
    assert gains[Mode.MN].tolist() == [0.5, 0.5]


def test_frames_that_nobody_hears_are_left_out_and_rendered_when_asked_for():
    """A sine of 100 Hz arrives with 0.5 e^-0.2, in the frame that was left out, in the one after
    it, and in those that follow."""
    objects, listeners = (
        (HapticObject("plank", 0.0, 1.0, Exponential(alpha=0.2)),),
        (Listener("hand", "plank", (1.0, 0, 0), radius=0.0),),
    )
    sources = (Source("hum", "plank", (0, 0, 0), 0.5, signal=Sine(100.0)),)
    tracer, results = Tracer(), []
    for number in range(8):
        heard = number not in (3, 4, 5)
        frame = Frame(
            number,
            number / 25,
            objects,
            sources,
            listeners,
            contacts=ContactSet.empty(),
            heard=heard,
        )
        results.append(tracer.step(frame))
    assert [result.block is None for result in results] == [
        True,
        False,
        False,
        True,
        True,
        True,
        False,
        False,
    ]
    for result in results[2:]:
        times = (result.first_sample + np.arange(320)) / RATE
        wave = 0.5 * math.exp(-0.2) * np.sin(2 * np.pi * 100.0 * times)
        assert with_block(result).block[0] == pytest.approx(wave, abs=1e-12)
    assert with_block(results[0]).block is None


@pytest.mark.parametrize(
    ("margin", "words"),
    [
        (23.4, "+23 dB"),
        (0.6, "+1 dB"),
        (0.4, "0 dB"),
        (0.0, "0 dB"),
        (-0.4, "0 dB"),
        (-0.6, "\u22121 dB"),
        (-5.2, "\u22125 dB"),
        (-math.inf, ""),
    ],
)
def test_margins_have_a_sign_unless_they_are_zero(margin, words):
    assert margin_words(margin) == words
