"""What is written when, in simulated time: pace, refresh, watchdog, peaks, retries, and streams
without gaps or jumps."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices.actuation import ToneActuation
from haptic_tracing.core.devices.families.family import RumbleFamily
from haptic_tracing.core.devices.pacing import WATCHDOG, RumblePacing
from haptic_tracing.core.devices.profile_files import load_profiles, profile
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_time import RATE, Simulation, is_silent, longest_pause, pacing, sounded, tone

PROFILES = load_profiles()[0]


ALL = [
    (name, transport) for name, device in PROFILES.items() for transport in device.family.transports
]
RUMBLE = [name for name, device in PROFILES.items() if isinstance(device.family, RumbleFamily)]
STREAMS = [pair for pair in ALL if pair[0] not in RUMBLE]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "transport"), ALL)
@settings(deadline=None, max_examples=20)
@given(data=st.data())
def test_a_device_is_never_written_to_faster_than_it_takes_and_always_ends_silent(
    name, transport, data
):
    paced = pacing(name, transport)
    simulation = Simulation(paced)
    rows = len(PROFILES[name].actuators)
    for _ in range(data.draw(st.integers(1, 8))):
        length, amplitude = data.draw(st.floats(0.001, 0.2)), data.draw(st.floats(0.0, 2.0))
        simulation.play(tone(length, data.draw(st.floats(5, 2000)), amplitude, rows))
        if data.draw(st.booleans()):
            paced.silence()
        if data.draw(st.booleans()):
            simulation.run_until(simulation.now + data.draw(st.floats(0.0, 0.5)))
    last_block = simulation.now
    simulation.run_until(last_block + 5.0)
    times = [time for time, _ in simulation.written]
    # A stream keeps its average pace: it may catch up after a late packet, not run ahead.
    slack = 1e-4 if name.endswith("pcm") else 1e-12
    assert all(later - earlier >= paced.interval - slack for earlier, later in pairwise(times))
    assert paced.wake(simulation.now) is None, "nothing more to do"
    assert times[-1] <= last_block + WATCHDOG + paced.lead + 6 * paced.interval + 1e-3
    if not name.endswith("pcm"):
        assert is_silent(name, transport, simulation.reports[-1])


@pytest.mark.parametrize("name", RUMBLE)
def test_the_watchdog_silences_a_device_when_no_block_comes(name):
    transport = PROFILES[name].family.transports[0]
    paced = pacing(name, transport)
    simulation = Simulation(paced).run_until(1.0)
    start = simulation.now
    rows = len(PROFILES[name].actuators)
    simulation.play(tone(0.04, rows=rows)).run_until(start + 2.0)
    sounding = [
        time
        for time, data in simulation.written
        if time >= start and not is_silent(name, transport, data)
    ]
    silent = [time for time, data in simulation.written if time > sounding[-1]]
    assert sounding[-1] <= start + WATCHDOG + paced.interval
    assert start + WATCHDOG <= silent[0] <= start + WATCHDOG + 2 * paced.interval + 1e-3
    assert len(silent) == PROFILES[name].family.zero_repeats


def test_opening_a_device_makes_it_silent_whatever_it_did():
    assert Simulation(pacing("dualsense", "usb")).run_until(1.0).reports == [
        rumble_report("dualsense", 0.0, 0.0, "usb").data
    ]


@pytest.mark.parametrize("name", PROFILES)
def test_zero_never_waits_longer_than_60_ms_for_its_turn(name):
    """Of the 150 ms to silence, a device's own pace leaves the rest to the detection of the failure
    and to a busy machine."""
    assert all(
        PROFILES[name].interval(transport) <= 0.060
        for transport in PROFILES[name].family.transports
    )


def test_a_steady_drive_is_written_once_where_the_device_holds_it():
    simulation = Simulation(pacing("dualsense", "usb")).run_until(1.0)
    for i in range(25):
        simulation.play(tone(0.04, frequency=200.0, start=0.04 * i))
    assert len(set(simulation.reports)) <= len(simulation.reports) <= 8


@pytest.mark.parametrize("name", RUMBLE)
def test_a_steady_drive_is_said_again_after_two_seconds_in_case_another_program_stopped_it(name):
    transport = PROFILES[name].family.transports[0]
    simulation = Simulation(pacing(name, transport)).run_until(1.0)
    rows = len(PROFILES[name].actuators)
    for i in range(200):
        simulation.play(tone(0.04, 200.0, 0.3, rows, 0.04 * i))
    driven = [
        time
        for time, data in simulation.written
        if time >= 3.0 and not is_silent(name, transport, data)
    ]
    assert (
        max(later - earlier for earlier, later in pairwise([3.0, *driven, 9.0]))
        <= 2.0 + 2 * simulation.paced.interval
    )


def test_the_pause_between_two_reports_is_counted_from_the_end_of_the_write():
    paced = pacing("xbox", "bt")
    simulation = Simulation(paced).run_until(1.0)
    paced.accept(tone(0.4, amplitude=0.9, rows=1), simulation.now)
    while paced.next_report(simulation.now) is None:
        simulation.now += 0.001
    ended = simulation.now + 0.030
    paced.written(ended)
    assert paced.next_report(ended + 0.049) is None
    assert paced.wake(ended) >= ended + 0.050
    assert paced.next_report(ended + 0.051) is not None


@pytest.mark.parametrize("name", RUMBLE)
def test_what_was_sent_ahead_is_felt_where_no_block_comes_in_time(name):
    """A tone of 340 ms, of which 40 are the block: it ends in its time, neither with the block nor
    with the watchdog."""
    transport, rows = PROFILES[name].family.transports[0], len(PROFILES[name].actuators)
    simulation = Simulation(pacing(name, transport)).run_until(1.0)
    start = simulation.now
    signal = np.concatenate([tone(0.34, 150.0, 0.6, rows), np.zeros((rows, 1600))], axis=1)
    simulation.paced.accept(signal[:, :320], start)
    simulation.paced.expect(signal[:, 320:], start)
    simulation.run_until(start + 1.0)
    driven = [
        time
        for time, data in simulation.written
        if time > start and not is_silent(name, transport, data)
    ]
    silent = [time for time, data in simulation.written if time > driven[-1]]
    assert start + 0.32 <= silent[0] <= start + 0.34 + 0.03 + 2 * simulation.paced.interval


def test_what_was_sent_ahead_is_dropped_when_a_block_comes():
    paced = pacing("dualsense", "usb")
    simulation = Simulation(paced).run_until(1.0)
    for _ in range(5):
        paced.accept(np.zeros((2, 320)), simulation.now)
        paced.expect(tone(0.4, amplitude=0.9), simulation.now)
        simulation.run_until(simulation.now + 0.039)
    paced.accept(np.zeros((2, 320)), simulation.now)
    paced.expect(np.zeros((2, 3200)), simulation.now)
    # Comes late: it is of the block before.
    paced.expect(tone(0.4, amplitude=0.9), simulation.now - 0.039)
    simulation.run_until(simulation.now + 1.0)
    assert all(is_silent("dualsense", "usb", data) for data in simulation.reports)


@pytest.mark.parametrize(("name", "transport"), [("dualsense", "usb"), *STREAMS])
def test_what_was_sent_ahead_of_the_block_before_does_until_something_newer_comes(name, transport):
    """The lock is held right after a block, before what would follow it was rendered."""
    simulation = Simulation(pacing(name, transport, slew=10_000.0)).run_until(1.0)
    signal = tone(0.54, 150.0, 0.6)
    simulation.paced.accept(signal[:, :320], simulation.now)
    simulation.paced.expect(signal[:, 320:], simulation.now)
    simulation.run_until(1.04)
    simulation.paced.accept(signal[:, 320:640], simulation.now)
    simulation.run_until(1.4)
    if name == "dualsense":
        assert not is_silent(name, transport, simulation.reports[-1])
    else:
        played = np.abs(sounded(name, simulation.reports)).max(axis=0)
        rate = PROFILES[name].family.rate
        assert (
            played[rate // 20 :].reshape(-1)[: rate // 4].reshape(-1, rate // 100).max(axis=1).min()
            > 0.4
        )


@pytest.mark.parametrize(("name", "transport"), STREAMS)
def test_a_stream_goes_on_with_what_was_sent_ahead_without_a_gap_while_frames_are_late(
    name, transport
):
    """Frames of a sine come up to 30 ms late, one of them 150 ms: all that is heard is the sine,
    but for a few samples at each seam."""
    simulation = Simulation(pacing(name, transport, slew=10_000.0))
    late = np.random.default_rng(3)
    for i in range(30):
        signal = tone(0.44, 100.0, 0.5, start=0.04 * i)
        simulation.paced.accept(signal[:, :320], simulation.now)
        simulation.paced.expect(signal[:, 320:], simulation.now)
        due = 0.04 * (i + 1) + (0.15 if i == 15 else late.uniform(0.0, 0.03))
        simulation.run_until(max(due, simulation.now))
    played = sounded(name, simulation.reports)[0]
    rate = PROFILES[name].family.rate
    strengths = [
        np.abs(played[first : first + rate // 100]).max()
        for first in range(rate // 10, len(played) - rate // 20, rate // 100)
    ]
    assert min(strengths) > 0.3, "each period of 10 ms has its crest, less where two of them meet"


def test_a_steady_drive_is_refreshed_before_the_device_lets_go():
    assert longest_pause("xbox", "bt") <= 0.101


def test_sequence_numbers_count_every_report():
    simulation = Simulation(pacing("dualsense", "bt")).run_until(0.1)
    for i in range(40):
        simulation.play(tone(0.02, amplitude=0.3 + 0.01 * i))
    assert len(simulation.reports) > 20
    assert [data[1] >> 4 for data in simulation.reports] == [
        i % 16 for i in range(len(simulation.reports))
    ]


@pytest.mark.parametrize("moment", np.arange(0.0, 0.1, 0.007))
def test_a_slow_device_does_not_miss_an_impact_between_two_commands(moment):
    """An impact of 20 ms is felt on a pad that is written to every 50 ms, at whatever time it
    comes."""
    block = np.zeros((1, round(0.2 * RATE)))
    start = round(moment * RATE)
    block[:, start : start + 160] = tone(0.02, 150.0, 0.9, rows=1)
    simulation = Simulation(pacing("xbox", "bt")).run_until(1.0)
    simulation.play(block)
    assert max(data[5] for data in simulation.reports) >= 60


def test_touch_comes_at_its_time_within_a_step_and_a_delay_holds_it_back():
    for delay in (0.0, 0.030, -0.030):
        simulation = Simulation(pacing("dualsense", "usb", delay)).run_until(1.0)
        silence = round(0.1 * RATE)
        simulation.play(np.concatenate([np.zeros((2, silence)), tone(0.1)], axis=1)).run_until(1.5)
        first = next(time for time, data in simulation.written if data[3] or data[4])
        assert 1.1 + delay - 0.015 <= first <= 1.1 + delay + 0.015


def test_a_fresh_block_replaces_what_is_left_of_the_last():
    paced = pacing("dualsense", "usb")
    simulation = Simulation(paced).run_until(1.0)
    paced.accept(tone(0.2, amplitude=0.9), 1.0)
    simulation.run_until(1.05)
    paced.accept(np.zeros((2, 1600)), 1.05)
    simulation.run_until(1.12)
    assert is_silent("dualsense", "usb", simulation.reports[-1])


def test_silence_is_written_at_once_and_nothing_of_before_comes_back():
    paced = pacing("dualsense", "usb")
    simulation = Simulation(paced).run_until(1.0)
    paced.accept(tone(0.2, amplitude=0.9), 1.0)
    simulation.run_until(1.1)
    paced.silence()
    simulation.run_until(1.1 + paced.interval + 1e-3)
    assert is_silent("dualsense", "usb", simulation.reports[-1])
    count = len(simulation.reports)
    simulation.run_until(2.0)
    simulation.play(np.zeros((2, 400)))
    assert len(simulation.reports) == count


def test_a_report_that_did_not_arrive_is_written_again():
    paced = pacing("dualsense", "usb")
    assert is_silent("dualsense", "usb", paced.next_report(0.0).data)
    paced.failed()
    assert is_silent("dualsense", "usb", paced.next_report(1.0).data)
    assert paced.next_report(2.0) is None


def test_the_ending_is_zero_then_release():
    zero, release = pacing("dualsense", "usb").ending(False)
    assert is_silent("dualsense", "usb", zero.data) and release.data == bytes([2]) + bytes(47)


def test_ceilings_and_the_limit_on_full_drive_hold_for_what_is_written():
    device = profile("dualsense")
    quiet = tuple(replace(actuator, safe_maximum=0.5) for actuator in device.actuators)
    simulation = Simulation(pacing("dualsense", "usb", actuators=quiet))
    for i in range(50):
        simulation.play(tone(0.04, amplitude=1.0, start=0.04 * i))
    assert max(data[4] for data in simulation.reports) == 0x80
    simulation = Simulation(pacing("dualsense", "usb"))
    for i in range(500):
        simulation.play(tone(0.04, amplitude=1.0, start=0.04 * i))
    assert max(data[4] for data in simulation.reports) >= 0xFD
    assert simulation.reports[-1][4] <= math.ceil(0.7 * 255)


# Streams


@pytest.mark.parametrize(("name", "transport"), STREAMS)
def test_a_stream_plays_every_sample_in_time(name, transport):
    rate = PROFILES[name].family.rate
    simulation = Simulation(pacing(name, transport, slew=10_000.0))
    for i in range(50):
        simulation.play(tone(0.04, 100.0, 0.5, start=0.04 * i))
    played = sounded(name, simulation.reports)
    times = [time for time, data in simulation.written if data[0] != 0x86]
    frames = played.shape[1] / len(times)
    assert (times[-1] - times[0]) / (len(times) - 1) == pytest.approx(frames / rate, rel=1e-3)
    # The sine goes on through all packets: a fit of its amplitude and phase leaves no more than the
    # rounding to 8 bits.
    clean = played[0, 100:-100]
    phase = 2 * math.pi * 100.0 * np.arange(len(clean)) / rate
    basis = np.stack([np.sin(phase), np.cos(phase)], axis=1)
    fit, *_ = np.linalg.lstsq(basis, clean, rcond=None)
    assert np.hypot(*fit) == pytest.approx(0.5, rel=0.01)
    assert np.abs(basis @ fit - clean).max() <= 1.5 / 127


@pytest.mark.parametrize(("name", "transport"), STREAMS)
def test_a_stream_that_runs_dry_goes_to_silence_without_a_jump_and_stops(name, transport):
    simulation = Simulation(pacing(name, transport, slew=10_000.0))
    simulation.play(tone(0.043, 40.0, 0.9))
    simulation.run_until(0.15)
    simulation.play(tone(0.043, 40.0, 0.9))
    simulation.run_until(2.0)
    played = sounded(name, simulation.reports)
    assert np.abs(played).max() > 0.5
    assert np.abs(np.diff(played, axis=1)).max() <= 0.9 / 8 + 0.1
    assert (played[:, -8:] == 0.0).all()
    assert simulation.written[-1][0] <= 0.193 + WATCHDOG + 0.05


def test_a_stream_is_scaled_and_not_clipped():
    simulation = Simulation(pacing("dualsense-pcm", "bt", slew=10_000.0, sustained_maximum=1.0))
    for i in range(10):
        simulation.play(tone(0.04, 200.0, 3.0, start=0.04 * i))
    played = sounded("dualsense-pcm", simulation.reports)[0]
    spectrum = np.abs(np.fft.rfft(played[150:750] * np.hanning(600)))
    assert np.abs(played).max() <= 1.0
    assert spectrum[3 * 40] < 0.02 * spectrum[40], (
        "a clipped sine would have a third harmonic of up to a third"
    )


@pytest.mark.parametrize(("name", "transport"), STREAMS)
def test_a_block_that_comes_early_cuts_off_the_one_before_and_the_newest_is_played_whole(
    name, transport
):
    paced = pacing(name, transport, slew=10_000.0)
    rate = PROFILES[name].family.rate
    for amplitude in (0.2, 0.4, 0.8):
        paced.accept(tone(1.0, 100.0, amplitude), 0.0)
    played = sounded(name, Simulation(paced).run_until(2.0).reports)
    loud = np.flatnonzero(np.abs(played[0]) > 0.45)
    assert loud[0] <= 0.06 * rate
    assert loud[-1] - loud[0] == pytest.approx(WATCHDOG * rate, abs=0.03 * rate), (
        "played until the watchdog took over"
    )
    assert np.abs(np.diff(played, axis=1)).max() <= 0.2


@pytest.mark.parametrize(("name", "transport"), ALL)
def test_the_actuation_is_of_the_familys_kind(name, transport):
    """Amplitudes for a family that is commanded by them, samples for the others."""
    kinds = RumblePacing, ToneActuation, RumbleFamily
    paced = pacing(name, transport)
    assert [isinstance(made, kind) for made, kind in zip((paced, paced._actuation, paced._family), kinds, strict=True)] in (
        [True] * 3, [False] * 3,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("minutes", [5, pytest.param(30, marks=pytest.mark.more)])
def test_minutes_of_frames_do_not_drift_from_the_picture(minutes):
    """Frames of 333 or 334 samples at 24 a second, each sent as its picture comes; a knock is felt
    just as late in every minute."""
    paced = pacing("dualsense-pcm", "bt")
    simulation = Simulation(paced)
    edges = np.ceil(np.arange(minutes * 60 * 24 + 1) / 24 * RATE - 1e-6).astype(int)
    silence, knock = np.zeros((2, 334)), tone(0.02, 150.0, 0.9)
    lags = []
    for number in range(minutes * 60 * 24):
        start = edges[number] / RATE
        simulation.run_until(start)
        length = edges[number + 1] - edges[number]
        if number % (60 * 24) != 30 * 24:
            paced.accept(silence[:, :length], start)
            continue
        block = np.zeros((2, length))
        block[:, : knock.shape[1]] = knock
        simulation.written.clear()
        paced.accept(block, start)
        simulation.run_until(start + 0.040)
        packets = (
            (time, np.abs(np.frombuffer(data, np.int8)[13:77:2].astype(int)))
            for time, data in simulation.written
        )
        time, left = next((time, left) for time, left in packets if left.max() > 10)
        lags.append(time + int(np.argmax(left > 10)) / 3000 - start)
    assert len(lags) == minutes
    assert max(lags) - min(lags) <= 2 / 3000, (
        "within a sample of the device, and one of the frame's rounding"
    )
