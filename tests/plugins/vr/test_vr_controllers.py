"""Blocks to calls of a VR session's frames, against the samples that they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.devices.profiles import Adjustment
from haptic_tracing.plugins.vr.device import LONGEST, Call, VrControllers
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000
BLOCK = 1 / 24
SECONDS = 3.0


def times(seconds=SECONDS):
    return np.arange(round(seconds * RATE)) / RATE


def steady(hertz=150.0, amplitude=0.4):
    return amplitude * np.sin(2 * np.pi * hertz * times())


def swept():
    t = times()
    return 0.4 * np.sin(2 * np.pi * (80 * t + 30 * t**2))  # 80 to 260 Hz


BLOWS = (0.31, 0.9), (0.97, 0.5), (1.508, 0.7), (2.2, 0.95)


def blows(decay):
    t = times()
    return sum(
        np.where(
            t >= at,
            strength
            * np.exp(-np.clip(t - at, 0, None) / decay)
            * np.sin(2 * np.pi * 170 * (t - at)),
            0.0,
        )
        for at, strength in BLOWS
    )


TRACKS = {"steady": steady(), "swept": swept()}


def played(samples, frame, jitter=0.0, adjustment=None, seed=1):
    """The times of the frames of a session as long as the samples, and of each the call of the left
    controller; the samples come in blocks of 1/24 s as in the player."""
    device = VrControllers(adjustment)
    device.start()
    random, now, sent = np.random.default_rng(seed), 0.0, 0
    found = []
    while now < len(samples) / RATE:
        while sent * BLOCK <= now:
            begin, end = round(sent * BLOCK * RATE), round((sent + 1) * BLOCK * RATE)
            block = np.zeros((2, end - begin))
            block[0, : len(samples[begin:end])] = samples[begin:end]
            device.send(block, sent * BLOCK)
            sent += 1
        calls = device.calls(now)
        call = calls.get("left", Call(0.0, 0.0, 0.0))
        found.append((now, call.amplitude, call.frequency))
        now += frame * (1 + jitter * random.uniform(-1, 1))
    return np.array(found).T


def energies(found, samples):
    """The energy of the calls, and of the samples of the frames that they stand for, by frame."""
    at, amplitude, _ = found
    edges = np.round(at * RATE).astype(int)
    squares = np.concatenate([[0.0], np.cumsum(2 * samples**2)]) / RATE
    due = np.diff(squares[np.minimum(edges, len(samples))])
    return amplitude[1:] ** 2 * np.diff(at), due


def levels(values, frames=3):
    """Of windows of so many frames, in dB."""
    windows = values[: len(values) // frames * frames].reshape(-1, frames).sum(axis=1)
    return 10 * np.log10(np.maximum(windows, 1e-12))


@pytest.mark.parametrize("frame", [1 / 60, 1 / 72, 1 / 90])
@pytest.mark.parametrize("name", ["steady", "swept"])
def test_the_level_is_that_of_the_samples_within_half_a_decibel_over_three_frames(name, frame):
    called, due = energies(played(TRACKS[name], frame), TRACKS[name])
    assert np.abs(levels(called[30:]) - levels(due[30:])).max() < 0.5


@pytest.mark.parametrize("frame", [1 / 60, 1 / 72, 1 / 90])
@pytest.mark.parametrize(("decay", "within"), [(0.015, 2.5), (0.02, 1.8), (0.04, 0.5)])
def test_a_blow_has_its_energy_over_three_frames(decay, within, frame):
    """A blow that is over within a frame is stronger than its energy, so that its peak is kept."""
    samples = blows(decay)
    found = played(samples, frame)
    called, due = energies(found, samples)
    for at, _ in BLOWS:
        begins = int(np.argmax(found[0] > at)) - 1
        three = slice(begins, begins + 3)
        assert abs(10 * np.log10(called[three].sum() / due[three].sum())) < within


@pytest.mark.parametrize("frame", [1 / 60, 1 / 90])
@pytest.mark.parametrize("decay", [0.015, 0.02, 0.04])
def test_the_peak_of_a_blow_is_kept(frame, decay):
    samples = blows(decay)
    at, amplitude, _ = played(samples, frame)
    for begin, _ in BLOWS:
        heard = amplitude[(at >= begin) & (at < begin + 0.3)].max()
        first = int(begin * RATE)
        meant = np.sqrt(2 * np.mean(samples[first : first + 80] ** 2))
        assert abs(20 * np.log10(heard / meant)) < 2.0


@pytest.mark.parametrize("frame", [1 / 20, 1 / 30, 1 / 60])
def test_a_blow_just_before_the_end_of_a_frame_keeps_its_peak(frame):
    """At any place in a frame, also where the first frame has only a part of the blow's rise."""
    t = times(1.0)
    for onset in np.linspace(0.5, 0.5 + frame, 12, endpoint=False):
        decaying = np.exp(-np.clip(t - onset, 0, None) / 0.05) * (t >= onset)
        samples = 0.8 * decaying * np.sin(2 * np.pi * 170 * (t - onset))
        first = int(onset * RATE)
        meant = np.sqrt(2 * np.mean(samples[first : first + 80] ** 2))
        assert abs(20 * np.log10(played(samples, frame)[1].max() / meant)) < 3.0


@pytest.mark.parametrize("frame", [1 / 60, 1 / 90])
@pytest.mark.parametrize("hertz", [65.0, 110.0, 223.0, 300.0])
def test_the_frequency_of_a_tone_is_kept(hertz, frame):
    _, _, frequency = played(steady(hertz), frame)
    assert np.abs(frequency[20:] / hertz - 1).max() < 0.05


def test_the_frequency_follows_a_sweep():
    at, _, frequency = played(swept(), 1 / 90)
    middle = 80 + 60 * (at - 1 / 90 - 0.02)
    assert np.abs(frequency - middle)[20:-5].max() < 6.0


def test_a_call_lasts_three_frames_and_at_most_60_ms():
    for frame, seconds in ((1 / 90, 3 / 90), (1 / 60, 0.05), (1 / 20, LONGEST)):
        device = VrControllers()
        device.start()
        device.send(np.tile(steady(), (2, 1)), 0.0)
        lasting = [device.calls(k * frame)["left"].seconds for k in range(1, int(0.45 / frame))]
        assert lasting[-3:] == pytest.approx([seconds] * 3)


def test_an_onset_is_called_in_the_next_frame():
    for onset in np.linspace(0.5, 0.52, 15):
        samples = np.where(times() >= onset, steady(), 0.0)[:RATE]
        at, amplitude, _ = played(samples, 1 / 60, jitter=0.2)
        first = at[np.argmax(amplitude > 0.01)]
        assert 0 < first - onset < 1.2 / 60 + 0.005


def test_nothing_is_called_while_it_is_silent_and_a_stop_is_called_once():
    device = VrControllers()
    device.start()
    assert device.calls(0.0) == {}
    device.send(np.tile(steady()[:400], (2, 1)), 0.0)
    assert device.calls(0.02)["right"].amplitude > 0.3
    device.rest()
    assert not device.is_silent
    assert [call.amplitude for call in device.calls(0.03).values()] == [0.0, 0.0]
    assert device.is_silent
    assert device.calls(0.04) == {}


def test_a_block_without_a_successor_ends_and_samples_ahead_bridge_a_late_one():
    for ahead in (False, True):
        device = VrControllers()
        device.start()
        device.send(np.tile(steady()[:400], (2, 1)), 0.0)
        if ahead:
            device.expect(np.tile(steady()[400:2400], (2, 1)), 0.0)
        calls = [device.calls(k / 60) for k in range(1, 60)]
        vibrating = [
            k / 60 for k, call in enumerate(calls, 1) if call and call["left"].amplitude > 0.01
        ]
        assert vibrating[-1] == pytest.approx(0.3 if ahead else 0.05, abs=0.04)


def test_the_gaps_of_a_busy_program_are_counted():
    device = VrControllers()
    device.start()
    device.send(np.tile(steady(), (2, 1)), 0.0)
    for now in (0.01, 0.02, 0.03, 0.2, 0.21, 0.35):
        device.calls(now)
    assert device.status.losses == 2
    assert "paused 2 times" in device.status.message


def test_a_frame_that_takes_too_long_makes_no_blow_of_a_steady_tone():
    for late in np.linspace(0.0, 1 / 150, 9):
        device = VrControllers()
        device.start()
        device.send(np.tile(steady()[:400], (2, 1)), 0.0)
        amplitudes = []
        for frame in range(1, 17):
            start, end = (round((frame + k) * 0.05 * RATE) for k in (0, 1))
            device.send(np.tile(steady()[start:end], (2, 1)), frame * 0.05)
            if frame != 9:
                now = frame * 0.05 + late * (frame > 9)
                amplitudes.append(device.calls(now)["left"].amplitude)
        assert np.abs(20 * np.log10(np.array(amplitudes[2:]) / 0.4)).max() < 0.5


def test_the_users_offset_and_ceiling_are_followed():
    late = played(steady(), 1 / 60, adjustment=Adjustment(delay=0.1))
    assert late[0][np.argmax(late[1] > 0.1)] == pytest.approx(0.1, abs=0.03)
    assert played(steady(), 1 / 60, adjustment=Adjustment(ceiling=0.25))[1].max() <= 0.25


@pytest.mark.slow
@settings(deadline=None)
@given(
    st.lists(
        st.one_of(
            st.floats(-1.5, 1.5).map(lambda value: ("send", value)),
            st.floats(0.0, 0.3).map(lambda seconds: ("frame", seconds)),
            st.just(("rest", 0.0)),
            st.just(("expect", 0.5)),
        ),
        max_size=40,
    )
)
def test_every_call_is_one_that_a_runtime_accepts_and_the_end_is_silent(events):
    device = VrControllers()
    device.start()
    now = sent = 0.0
    made = []
    for name, value in events:
        if name == "send":
            sent = device.send(np.full((2, 333), value), now)
        elif name == "expect":
            device.expect(np.full((2, 4000), value), sent)
        elif name == "rest":
            device.rest()
        else:
            now += value
            made += device.calls(now).values()
    for _ in range(60):
        now += 0.02
        last = device.calls(now)
        made += last.values()
    assert last == {}
    assert device.is_silent
    for call in made:
        assert 0 <= call.amplitude <= 1
        assert 65 <= call.frequency <= 300
        assert 0 < call.seconds <= LONGEST
