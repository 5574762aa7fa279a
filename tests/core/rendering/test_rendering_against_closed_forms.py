"""The renderer against signals, gains and delays written out as functions of time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pytest
import scipy.signal
from haptic_tracing.core.render.filter_bank import bank_reach, low_pass, split_bands
from haptic_tracing.core.render.renderer import ListenerMix, Renderer
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.scene.bands import BAND_EDGES
from haptic_tracing.core.signals import (
    Adsr,
    Constant,
    DecayingSine,
    Noise,
    Sampled,
    Signal,
    Sine,
    Square,
)
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000.0
LOUD = 1e6


def play(
    times: Sequence[float],
    voices: Callable[[float], list[Voice]],
    listeners: int = 1,
    sample_rate: float = RATE,
) -> np.ndarray:
    """All samples of frames between `times`, where `voices` says what is given at a frame's end."""
    renderer = Renderer(
        [ListenerMix(str(number), s_max=LOUD) for number in range(listeners)], sample_rate
    )
    return np.concatenate(
        [renderer.render_frame(start, end, voices(end)) for start, end in pairwise(times)], axis=1
    )


def frames(count: int, per_second: float = 25.0) -> list[float]:
    return [number / per_second for number in range(count + 1)]


def gain_at(time: float) -> float:
    return 0.5 + 0.4 * np.sin(3.0 * time)


def smoothed(now: np.ndarray, times: Sequence[float], values: Sequence[float]) -> np.ndarray:
    """Straight lines between keys, convolved with a Hann window over the last 8 ms, by Gauss' rule
    between the keys."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = [now - 0.008, *(np.clip(time, now - 0.008, now) for time in times), now]
    total = np.zeros(now.shape)
    for begin, end in pairwise(edges):
        at = (begin + end) / 2 + (end - begin) / 2 * nodes[:, None]
        window = (1 - np.cos(2 * np.pi * (now - at) / 0.008)) / 0.008
        total += (
            (end - begin)
            / 2
            * (weights[:, None] * window * np.interp(at, times, values)).sum(axis=0)
        )
    return total


def test_gains_go_straight_from_frame_to_frame_round_the_corners() -> None:
    times = frames(50)
    voice = Sine(60.0)
    samples = play(
        times, lambda end: [Voice("a", voice, np.array([gain_at(end), 0.2]), amplitude=2.0)], 2
    )
    now = np.arange(16_000) / RATE
    # Given at time 0 for the first time, it begins there at the first frame's gain.
    keys = [gain_at(times[1]), *(gain_at(time) for time in times[1:])]
    assert (
        np.abs(samples[0] - 2 * smoothed(now, times, keys) * np.sin(2 * np.pi * 60 * now)).max()
        < 1e-11
    )
    assert np.abs(samples[1] - 0.4 * np.sin(2 * np.pi * 60 * now)).max() < 1e-11


@pytest.mark.parametrize("tone", [60.0, 156.0, 252.0])
@pytest.mark.parametrize("pattern", ["on and off", "random"])
def test_gain_changes_at_24_frames_a_second_stay_80_decibels_below_the_tone_above_500_hertz(
    tone: float, pattern: str
) -> None:
    levels = (
        np.arange(482) % 2.0
        if pattern == "on and off"
        else np.random.default_rng(0).uniform(0, 1, 482)
    )
    times = frames(482, 24.0)
    keys = {
        round(time, 6): np.array([level]) for time, level in zip(times[1:], levels, strict=True)
    }
    # 20 s, in which each of the tones has whole periods; the window is for the random gains.
    samples = play(times, lambda end: [Voice("a", Sine(tone), keys[round(end, 6)])])[0, -160_000:]
    power = (
        np.abs(np.fft.rfft(samples * scipy.signal.windows.blackmanharris(len(samples), sym=False)))
        ** 2
    )
    assert 10 * np.log10(power[500 * 20 :].sum() / power.sum()) < -80


def test_new_sources_fade_in_and_old_ones_out() -> None:
    voice = Voice("hum", Constant(1.0), np.ones(1))
    samples = play(frames(6), lambda end: [voice] if 0.05 < end < 0.17 else [])
    expected = smoothed(np.arange(1920) / RATE, (0.04, 0.08, 0.16, 0.192), (0.0, 1.0, 1.0, 0.0))
    assert np.abs(samples[0] - expected).max() < 1e-12
    assert not samples[0, 1600:].any(), "silent from the frame's end on"


def test_in_short_frames_a_source_fades_out_over_the_next_ones() -> None:
    voice = Voice("hum", Constant(1.0), np.ones(1))
    samples = play(frames(60, 250.0), lambda end: [voice] if end < 0.0801 else [])
    expected = smoothed(np.arange(1920) / RATE, (0.08, 0.084), (1.0, 0.0))
    assert np.abs(samples[0] - expected).max() < 1e-12
    assert not samples[0, 736:].any(), "silent 8 ms after the line"


@pytest.mark.parametrize("onset", [0.08, 0.0817263, 0.11999])
def test_a_temporary_source_begins_at_its_onset_at_full_gain(onset: float) -> None:
    blow = DecayingSine(150.0, 0.03, 0.8)
    samples = play(
        frames(20), lambda end: [Voice("blow", blow, np.array([0.7]), onset)] if end > 0.11 else []
    )[0]
    since = np.arange(6400) / RATE - onset
    sounding = (since >= 0) & (since < blow.duration)
    expected = np.where(
        sounding, 0.56 * np.exp(-since / 0.03) * np.sin(2 * np.pi * 150 * since), 0.0
    )
    assert np.abs(samples - expected).max() < 1e-11


def test_a_signal_that_changes_fades_over() -> None:
    samples = play(
        frames(4), lambda end: [Voice("a", Constant(1.0 if end < 0.1 else 3.0), np.ones(1))]
    )
    now = np.arange(1280) / RATE
    expected = smoothed(now, (0.08, 0.112), (1.0, 0.0)) + smoothed(now, (0.08, 0.12), (0.0, 3.0))
    assert np.abs(samples[0] - expected).max() < 1e-12


def test_struck_again_the_old_blow_fades_and_the_new_begins_at_once() -> None:
    gate = Constant(1.0, 10.0)
    samples = play(
        frames(4), lambda end: [Voice("a", gate, np.ones(1), 0.0 if end < 0.1 else 0.1)]
    )[0]
    now = np.arange(1280) / RATE
    expected = smoothed(now, (0.08, 0.112), (1.0, 0.0)) + (now >= 0.1)
    assert np.abs(samples - expected).max() < 1e-12


def test_constant_and_moving_delays() -> None:
    def delays_at(time: float) -> np.ndarray:
        return np.array([0.0123, 0.02 + 0.005 * np.sin(5 * time), 0.0])

    times = frames(30)
    samples = play(
        times,
        lambda end: [Voice("a", Sine(200.0), np.array([1.0, 0.5, 0.25]), delays=delays_at(end))],
        3,
    )
    now = np.arange(9600) / RATE
    for listener, gain in enumerate((1.0, 0.5, 0.25)):
        keys = [delays_at(times[1])[listener], *(delays_at(time)[listener] for time in times[1:])]
        earlier = now - np.interp(now, times, keys)
        expected = np.where(earlier >= 0, gain * np.sin(2 * np.pi * 200 * earlier), 0.0)
        assert np.abs(samples[listener] - expected).max() < 1e-10


def test_a_path_that_opens_has_its_own_delay_at_once() -> None:
    """No glide from the delay of a path that nobody heard."""
    unknown = float("nan")
    samples = play(
        frames(5),
        lambda end: [
            Voice(
                "a",
                Sine(100.0),
                np.array([float(end > 0.09)]),
                delays=np.array([0.01 if end > 0.09 else unknown]),
            )
        ],
    )[0]
    now = np.arange(1600) / RATE
    expected = smoothed(now, (0.08, 0.12), (0.0, 1.0)) * np.sin(2 * np.pi * 100 * (now - 0.01))
    assert np.abs(samples - expected).max() < 1e-10


def test_a_delayed_blow_rings_out() -> None:
    blow = DecayingSine(150.0, 0.01)
    samples = play(
        frames(20), lambda end: [Voice("a", blow, np.ones(1), 0.01, delays=np.array([0.3]))]
    )[0]
    since = np.arange(6400) / RATE - 0.31
    expected = np.where(
        (since >= 0) & (since < blow.duration),
        np.exp(-since / 0.01) * np.sin(2 * np.pi * 150 * since),
        0.0,
    )
    assert np.abs(samples - expected).max() < 1e-10


def bands_of(signal: Signal, count: int, onset: float = 0.0) -> np.ndarray:
    reach = bank_reach(RATE)
    begun = np.arange(count) / RATE >= onset
    return split_bands(signal.sample(-reach, count + 2 * reach, RATE, onset), RATE) * begun


def test_bands_have_their_own_gains() -> None:
    signal = Noise(seed=1)
    gains = np.array([[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    samples = play(frames(20), lambda end: [Voice("a", signal, gains)], 2)
    assert np.abs(samples - gains @ bands_of(signal, 6400)).max() < 1e-12


@pytest.mark.parametrize("signal", [Noise(seed=2), Square(50.0), DecayingSine(90.0, 0.05)])
def test_equal_gains_in_all_bands_are_one_gain(signal: Signal) -> None:
    onset = 0.04321
    plain, banded = (
        play(
            frames(30),
            lambda end, shape=shape: (
                [Voice("a", signal, np.full(shape, gain_at(end)), onset)] if end > 0.05 else []
            ),
        )
        for shape in ((1,), (1, 6))
    )
    assert np.abs(plain - banded).max() < 1e-12


def test_bands_with_delays() -> None:
    signal = Sine(100.0) + Sine(30.0)
    gains = np.array([[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]])
    samples = play(
        frames(50), lambda end: [Voice("a", signal, gains, -1.0, delays=np.array([0.01234]))], 1
    )[0]
    now = np.arange(16_000) / RATE - 0.01234
    offsets = np.arange(-bank_reach(RATE), bank_reach(RATE) + 1)
    expected = np.zeros(16_000)
    for frequency in (100.0, 30.0):
        low = [
            low_pass(edge, RATE) @ np.cos(2 * np.pi * frequency / RATE * offsets)
            for edge in BAND_EDGES[1:-1]
        ]
        expected += (gains[0] @ np.diff([0.0, *low, 1.0])) * np.sin(2 * np.pi * frequency * now)
    assert np.abs(samples - expected)[400:].max() < 2e-5, "from the second frame on"


def test_ramps_leave_no_step() -> None:
    """Gains that jump from frame to frame move a steady signal no faster than their ramp."""
    random = np.random.default_rng(0)
    gains = {round(time, 6): random.uniform(0, 1, 1) for time in frames(100)}
    samples = play(frames(100), lambda end: [Voice("a", Constant(1.0), gains[round(end, 6)])])[0]
    assert np.abs(np.diff(samples)).max() <= 1.0 / (0.04 * RATE) + 1e-12
    stepped = np.repeat([gains[round(time, 6)][0] for time in frames(100)[1:]], 320)
    assert np.abs(np.diff(stepped)).max() > 0.5


signals = st.sampled_from(
    [
        Sine(60.0),
        Sine(333.0) * Adsr(hold=0.1),
        Noise(seed=4),
        DecayingSine(120.0, 0.02),
        Sampled(np.hanning(300), 7000.0),
        Square(31.0),
    ]
)


@pytest.mark.slow
@given(
    st.lists(st.tuples(signals, st.floats(-0.1, 0.4), st.booleans(), st.booleans()), max_size=4),
    st.lists(st.floats(0.001, 0.039), max_size=8),
    st.integers(0, 99),
)
@settings(deadline=None, max_examples=100)
def test_frames_cut_into_blocks_give_the_same(
    kinds: list[tuple[Signal, float, bool, bool]], cuts: list[float], seed: int
) -> None:
    """Gains, delays and priorities are functions of time here: how finely it is cut does not
    show."""
    random = np.random.default_rng(seed)
    whole = frames(10)
    levels = random.uniform(0, 1, (len(kinds), len(whole), 2, 6))
    lags = random.uniform(0, 0.03, (len(kinds), len(whole), 2))
    levels[:, 0], lags[:, 0] = levels[:, 1], lags[:, 1]

    def between(keys: np.ndarray, time: float) -> np.ndarray:
        number = min(int(time * 25 + 1e-9), len(whole) - 2)
        share = time * 25 - number
        return keys[number] * (1 - share) + keys[number + 1] * share

    def voices(end: float) -> list[Voice]:
        return [
            Voice(
                index,
                signal,
                between(levels[index], end) if banded else between(levels[index], end)[:, 0],
                max(onset, 0.0),
                delays=between(lags[index], end) if delayed else None,
            )
            for index, (signal, onset, banded, delayed) in enumerate(kinds)
        ]

    fine = sorted({*whole, *(number / 25 + cut for number, cut in enumerate(cuts))})
    assert np.abs(play(fine, voices, 2) - play(whole, voices, 2)).max(initial=0.0) < 1e-9


def test_after_a_reset_all_is_as_in_a_new_renderer() -> None:
    listeners = [
        ListenerMix("a", "strongest"),
        ListenerMix("b", limiter=True, s_max=0.3),
        ListenerMix("c", "power"),
    ]
    times = frames(40, 30 / 1.001)
    steps = [
        (
            start,
            end,
            [
                Voice("hum", Sine(60.0), np.full(3, gain_at(end))),
                Voice("blow", DecayingSine(), np.ones((3, 6)), 0.2345),
            ],
        )
        for start, end in pairwise(times)
    ]
    used, new = Renderer(listeners), Renderer(listeners)
    used.render_frame(7.0, 7.3, steps[0][2])
    used.reset()
    first, second = (
        np.concatenate([each.render_frame(*step) for step in steps], axis=1) for each in (used, new)
    )
    assert np.array_equal(first, second)


def test_order_of_voices_does_not_matter() -> None:
    voices = [Voice(number, Sine(40.0 + number), np.full(1, 0.1 * number)) for number in range(12)]
    assert (
        np.abs(play(frames(5), lambda _: voices) - play(frames(5), lambda _: voices[::-1])).max()
        < 1e-12
    )


class Counted(Sine):
    """A tone that counts the values asked of it."""

    __slots__ = ()
    counts: list[int] = []  # noqa: RUF012

    def values(self, times: np.ndarray, step: float) -> np.ndarray:
        self.counts.append(len(times))
        return Sine.values(self, times, step)


def test_inaudible_voices_are_not_rendered() -> None:
    Counted.counts.clear()
    silent = [
        Voice("silent", Counted(50.0), np.zeros(1)),
        Voice("later", Counted(50.0), np.ones(1), onset=5.0),
    ]
    over = Voice("over", Counted(50.0) * Constant(1.0, 0.1), np.ones(1))
    play(frames(25), lambda end: silent)
    assert Counted.counts == []
    renderer = Renderer([ListenerMix("hand")])
    for start, end in pairwise(frames(25)):
        renderer.render_frame(start, end, [over])
    assert len(Counted.counts) == 1, "one run of samples while it sounds, none when it is over"
    assert not renderer.render_frame(1.0, 1.04, [over]).any()


def test_no_listeners_no_voices() -> None:
    assert Renderer([]).render_frame(0.0, 0.04, [Voice("a", Sine(), np.zeros(0))]).shape == (0, 320)
    assert not play(frames(3), lambda _: [], 4).any()


NAN = float("nan")


@pytest.mark.parametrize(
    ("voice", "message"),
    [
        (Voice("a", Sine(), np.ones(3)), r"^gains: those of 'a' have shape \(3,\)"),
        (Voice("a", Sine(), np.ones((2, 5))), r"^gains: those of 'a' have shape \(2, 5\)"),
        (Voice("a", Sine(), np.array([1.0, NAN])), "^gains: those of 'a' must be finite"),
        (Voice("a", Sine(), np.array([np.inf, 1.0])), "^gains: those of 'a' must be finite"),
        (Voice("a", Sine(), np.ones(2), amplitude=NAN), "^amplitude: that of 'a'"),
        (Voice("a", Sine(), np.ones(2), onset=NAN), "^onset: that of 'a'"),
        (Voice("a", Sine(), np.ones(2), priority=-1.0), "^priority: that of 'a'"),
        (Voice("a", Sine(), np.ones(2), delays=np.zeros(3)), "^delays: those of 'a' have shape"),
        (
            Voice("a", Sine(), np.ones(2), delays=np.array([0.0, -1.0])),
            "^delays: those of 'a' must be",
        ),
        (
            Voice("a", Sine(), np.ones(2), delays=np.array([0.0, NAN])),
            "^delays: those of 'a' must be",
        ),
        (Voice("ok", Sine(), np.ones(2)), "^voices: key 'ok' is given twice"),
    ],
)
def test_a_bad_voice_is_named_and_changes_nothing(voice: Voice, message: str) -> None:
    good = Voice("ok", Sine(60.0), np.ones(2))
    renderer, reference = (Renderer([ListenerMix("hand"), ListenerMix("foot")]) for _ in range(2))
    for each in (renderer, reference):
        each.render_frame(0.0, 0.04, [good])
    with pytest.raises(ValueError, match=message):
        renderer.render_frame(0.04, 0.08, [good, voice])
    assert np.array_equal(
        renderer.render_frame(0.04, 0.08, [good]), reference.render_frame(0.04, 0.08, [good])
    )


@pytest.mark.parametrize("rate", [0.0, 99.0, 1e6, NAN])
def test_impossible_sample_rates_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match=r"^sample_rate: "):
        Renderer([], rate)
