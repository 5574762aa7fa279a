"""Blocks of live playback: those of the bake frame by frame, never shifted by dropped frames, never
clicking at jumps."""

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.render.playback import GRAIN, Playback, grain, recorded_grain
from haptic_tracing.core.scene.values import HapticObject, Listener, Source, SourceKind
from haptic_tracing.core.signals import DecayingSine, Sine
from haptic_tracing.core.tracer import Frame, Tracer

RATE = 8000.0
FPS = 24.0
TONE = 100.0
# A 100 Hz sine of amplitude 1 never moves faster than this from sample to sample.
STEEPEST = 2 * np.pi * TONE / RATE


def traced(numbers, fps=FPS, impact=None, limiter=False, amplitude=lambda number: 1.0):
    """One object with a source and a listener on it, traced frame by frame."""
    tracer = Tracer()
    thing = HapticObject("thing", 0.0, 1.0)
    hum = Source("hum", "thing", signal=Sine(TONE))
    listener = Listener("skin", "thing", body_part="hand.L", limiter=limiter, radius=0.0)
    results, last = [], None
    for number in numbers:
        sources = (replace(hum, amplitude=amplitude(number)),)
        if impact is not None:
            sources += (
                Source(
                    "blow",
                    "thing",
                    kind=SourceKind.TEMPORARY,
                    signal=DecayingSine(150.0, 0.03),
                    onset=impact,
                ),
            )
        frame = Frame(
            number,
            number / fps,
            (thing,),
            sources,
            (listener,),
            continuous=last is not None and number == last + 1,
        )
        results.append(tracer.step(frame))
        last = number
    return results


def played(results, start, fps=FPS):
    playback = Playback()
    playback.start(start / fps)
    return [playback.block(result, 1 / fps) for result in results]


@pytest.mark.parametrize("fps", [24.0, 25.0, 29.97, 60.0])
def test_frame_by_frame_it_is_the_bake_bit_for_bit(fps):
    results = traced(range(50), fps, impact=0.5)
    for block, result in zip(played(results[1:], 0, fps), results[1:], strict=True):
        assert block.tobytes() == result.block.tobytes()


def test_dropped_frames_do_not_shift_what_is_felt():
    """Each block is the last frame before its picture; the steady tone has the phase that the
    scene's time gives it."""
    numbers = [1, 2, 4, 5, 9, 10, 11]
    for number, block in zip(numbers[1:], played(traced(numbers), 0)[1:], strict=True):
        last = np.arange(np.ceil(number / FPS * RATE - 1e-6)) / RATE
        expected = np.sin(2 * np.pi * TONE * last)[-block.shape[1] :]
        assert abs(block.shape[1] - RATE / FPS) < 1
        settled = 64 if number == 2 else 0  # it fades in over the first frame and 8 ms
        np.testing.assert_allclose(block[0, settled:], expected[settled:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("limiter", [False, True])
def test_the_predicted_block_is_the_next_one_while_nothing_changes_and_leaves_playback_alone(
    limiter,
):
    results = traced(range(24), impact=0.5, limiter=limiter)
    expected = np.concatenate(played(results[1:], 0), axis=1)
    playback = Playback()
    playback.start(0.0)
    samples = []
    for result in results[1:]:
        samples.append(playback.block(result, 1 / FPS))
        end = sum(block.shape[1] for block in samples)
        following = playback.following(result, 0.4)()
        assert following.shape == (1, 3200)
        if result.number >= 13:  # the blow is known from frame 12 on, and goes on for two frames
            count = min(3200, expected.shape[1] - end)
            # What a limiter does depends on all that went before.
            exactness = 0.02 if limiter else 1e-9
            np.testing.assert_allclose(
                following[:, :count], expected[:, end : end + count], rtol=0, atol=exactness
            )
    assert np.concatenate(samples, axis=1).tobytes() == expected.tobytes()


def test_a_block_ahead_of_tracing_from_the_start_begins_the_tone():
    """The source begins with the frame at which playback starts: it is no late beginner in the
    second block."""
    results = traced(range(6))
    playback = Playback()
    playback.start(0.0)
    blocks = [playback.ahead(results[number - 1], number / FPS, 1 / FPS) for number in range(1, 6)]
    samples = np.concatenate(blocks, axis=1)[0]
    begin = blocks[0].shape[1]
    times = np.arange(len(samples)) / RATE
    begin += 64  # it fades in over the first block and 8 ms
    np.testing.assert_allclose(
        samples[begin:], np.sin(2 * np.pi * TONE * times)[begin:], rtol=0, atol=1e-9
    )


def test_a_block_goes_ahead_where_moving_gains_have_come_to():
    """The gain's line bends to a level one, over 8 ms: no step where blocks of the tracer are
    followed by one that went ahead."""
    results = traced(range(10), amplitude=lambda number: 0.1 * number)
    playback = Playback()
    playback.start(0.0)
    for result in results[1:]:
        playback.block(result, 1 / FPS)
    ahead = playback.ahead(results[9], 10 / FPS, 1 / FPS)
    times = (np.ceil(9 / FPS * RATE) + np.arange(ahead.shape[1])) / RATE
    since = np.minimum(times - 9 / FPS, 0.008)
    # The integral of the Hann window's integral, by which the gain is still behind the line.
    rising = since**2 / 0.016 + 0.008 / (4 * np.pi**2) * (np.cos(2 * np.pi * since / 0.008) - 1)
    gain = 0.9 + 0.1 * FPS * (since - rising - 0.004)
    np.testing.assert_allclose(ahead[0], gain * np.sin(2 * np.pi * TONE * times), rtol=0, atol=1e-9)


def test_a_block_that_went_ahead_is_corrected_from_the_moment_its_trace_is_done():
    """The blow of frame 12 is known 10 ms after the block went ahead: from there on the samples are
    those of the bake."""
    results = traced(range(12)) + traced(range(20), impact=11.6 / FPS)[12:]
    playback = Playback()
    playback.start(0.0)
    for result in results[1:12]:
        playback.block(result, 1 / FPS)
    ahead = playback.ahead(results[11], 12 / FPS, 1 / FPS)
    quiet = traced(range(20))
    np.testing.assert_allclose(ahead, quiet[12].block, rtol=0, atol=1e-9)
    corrected = playback.correction(results[12], 0.010)
    cut = results[12].block.shape[1] - corrected.shape[1]
    assert cut == pytest.approx(0.010 * RATE, abs=1)
    np.testing.assert_allclose(corrected, results[12].block[:, cut:], rtol=0, atol=1e-9)
    assert playback.correction(results[12], 0.010) is None, "nothing else has changed"
    assert playback.correction(results[12], 1.0) is None, "the block has been played"
    assert playback.block(results[12], 1 / FPS).shape == (1, 0)
    assert playback.block(results[13], 1 / FPS).tobytes() == results[13].block.tobytes(), (
        "and what follows is the bake"
    )


def test_a_blow_from_before_its_correction_begins_with_the_correction():
    results = traced(range(12)) + traced(range(20), impact=11.1 / FPS)[12:]
    playback = Playback()
    playback.start(0.0)
    for result in results[1:12]:
        playback.block(result, 1 / FPS)
    playback.ahead(results[11], 12 / FPS, 1 / FPS)
    corrected = playback.correction(results[12], 0.020)[0]
    times = (11 / FPS * RATE + 0.020 * RATE + np.arange(len(corrected))) / RATE
    blow = corrected - np.sin(2 * np.pi * TONE * np.ceil(times * RATE - 1e-6) / RATE)
    assert abs(blow[0]) < 0.15 and np.abs(blow[:60]).max() > 0.4, (
        "from its beginning, not from its middle"
    )


def test_blocks_ahead_of_tracing_are_in_time_and_miss_no_impact():
    """Frames 10 to 14 are played with what the frame before says: the tone goes on, the blow comes
    with the block after its frame's."""
    results = traced(range(12)) + traced(range(30), impact=11.5 / FPS)[12:]
    playback = Playback()
    playback.start(0.0)
    blocks = []
    for number, result in enumerate(results[1:], 1):
        ahead = 10 <= number <= 14
        blocks.append(
            playback.ahead(results[number - 1], number / FPS, 1 / FPS)
            if ahead
            else playback.block(result, 1 / FPS)
        )
        if number == 14:
            assert playback.block(result, 1 / FPS).shape == (1, 0), "played already"
    samples = np.concatenate(blocks, axis=1)[0]
    begin = int(np.ceil(12 / FPS * RATE - 1e-6))
    times = np.arange(len(samples)) / RATE
    since = times - 12 / FPS
    blow = np.where(
        since >= 0, np.exp(-np.maximum(since, 0) / 0.03) * np.sin(2 * np.pi * 150.0 * since), 0.0
    )
    first = int(np.ceil(RATE / FPS))
    assert (
        np.abs(samples - np.clip(np.sin(2 * np.pi * TONE * times) + blow, -1, 1))[
            first : begin + 2000
        ].max()
        < 1e-4
    )
    assert playback.ahead(results[3], 3 / FPS, 1 / FPS) is None, "a jump waits for its frame"
    assert Playback().ahead(results[3], 3 / FPS, 1 / FPS) is None


@pytest.mark.parametrize("second", [0, 3, 17, 40, 900])
def test_loops_and_jumps_do_not_click(second):
    first = list(range(25))
    jumped = list(range(second, second + 10))
    samples = np.concatenate(played(traced([*first[1:], *jumped]), 0), axis=1)[0]
    # While one tone fades out another fades in: together they move little faster than one does.
    assert np.abs(np.diff(samples)).max() <= 1.2 * STEEPEST
    assert np.abs(samples).max() <= 1.0
    blocks = len(first) - 1 + len(jumped)
    assert abs(len(samples) - blocks * RATE / FPS) <= blocks


def test_playing_backwards_does_not_click():
    samples = np.concatenate(played(traced(range(30, 5, -1)), 31), axis=1)[0]
    assert np.abs(np.diff(samples)).max() <= 1.2 * STEEPEST


def test_a_frame_that_comes_twice_is_played_once():
    results = traced([1, 2, 2])
    assert [block.shape[1] > 0 for block in played(results, 0)] == [True, True, False]


@pytest.mark.slow
def test_thirty_minutes_do_not_drift():
    """The sample that each block ends with is the picture's, within one sample, at every frame of
    half an hour."""
    fps = 30000 / 1001
    playback = Playback()
    playback.start(0.0)
    template = traced([0, 1], fps)[1]
    silent = replace(
        template, sources=(), propagation=replace(template.propagation, gain=np.zeros((0, 1)))
    )
    count = round(30 * 60 * fps)
    total = 0
    worst = 0.0
    for number in range(1, count + 1):
        total += playback.block(replace(silent, number=number, time=number / fps), 1 / fps).shape[1]
        worst = max(worst, abs(total - number / fps * RATE))
    assert count == 53946
    assert worst <= 1.0


def test_a_grain_is_short_begins_and_ends_in_silence_and_holds_the_tone():
    (result,) = traced([12])
    samples = grain(result, 1 / FPS)[0]
    sounding = np.flatnonzero(samples)
    assert sounding[-1] / RATE <= GRAIN
    assert abs(samples[0]) < 0.01 and np.abs(np.diff(samples)).max() <= STEEPEST
    times = (
        np.arange(np.ceil(11 / FPS * RATE - 1e-6), len(samples) + np.ceil(11 / FPS * RATE - 1e-6))
        / RATE
    )
    middle = slice(round(0.010 * RATE), round(0.055 * RATE))
    np.testing.assert_allclose(
        samples[middle], np.sin(2 * np.pi * TONE * times)[middle], rtol=0, atol=1e-9
    )


def test_an_impact_is_in_the_grain_of_its_frame():
    results = traced([11, 12], impact=11.5 / FPS)
    quiet = traced([11, 12])
    difference = np.abs(grain(results[1], 1 / FPS)[0] - grain(quiet[1], 1 / FPS)[0])
    assert difference.max() > 0.3
    assert np.flatnonzero(difference > 1e-9)[0] == pytest.approx(0.5 / FPS * RATE, abs=2)


def test_a_recorded_track_is_played_as_it_is_and_joined_at_jumps():
    results = traced(range(40))
    playback = Playback()
    playback.start(0.0)
    blocks = [playback.recorded(result) for result in results[1:20]]
    tracked = np.concatenate([result.block for result in results[1:20]], axis=1)
    assert np.array_equal(np.concatenate(blocks, axis=1)[:, 64:], tracked[:, 64:]), (
        "it begins from silence, within 8 ms"
    )
    after = playback.recorded(results[30])
    step = np.abs(np.diff(np.concatenate([blocks[-1][0], after[0]])))
    assert step.max() <= STEEPEST + 2.0 / (0.008 * RATE)
    assert np.array_equal(after[:, 64:], results[30].block[:, 64:])
    assert playback.recorded(results[30]).shape == (1, 0)
    assert playback.recorded(results[0]).shape == (1, 0)
    assert recorded_grain(results[0]).shape == (1, 0)
    assert abs(recorded_grain(results[30])[0, 0]) < 0.01
