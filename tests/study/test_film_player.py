"""The schedule by which tracks follow a film: all blocks, each once and in order, at the film's
clock."""

import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from haptic_tracing.command_line.study_playing import AHEAD, BLOCK, RATE, FilmPlayer
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.status import Status

sys.path.insert(0, str(Path(__file__).parents[1] / "core" / "devices"))

from fake_hid import until


def player_of(sent):
    """A player of one pad, whose blocks are kept."""
    output = SimpleNamespace(
        profile=profile("dualsense"),
        status=Status("open"),
        send=lambda block, due=None: sent.append((block, due)),
        expect=lambda block, due: None,
    )
    return FilmPlayer(SimpleNamespace(outputs={"pad": output}, stop=lambda: None))


@pytest.mark.slow
def test_what_is_missed_without_pictures_is_counted():
    sent = []
    player = player_of(sent)
    player.load({"pad": np.zeros((2, 4 * RATE))})
    begun = time.perf_counter()
    for first, last in ((0.5, 1.0), (2.5, 3.0)):  # pictures of the film, seconds
        while (film := time.perf_counter() - begun) < last:
            if film >= first:
                player.follow(film, time.perf_counter())
            time.sleep(0.01)
    late, played = player.stop()
    count = len(sent)
    assert played == pytest.approx(count * BLOCK / RATE)
    # The devices go on for AHEAD after the last picture of the first half second.
    assert played == pytest.approx(2 * 0.5 + AHEAD / RATE, abs=0.15 + 2 * late)
    assert player.stop() == (0.0, 0.0)
    assert until(lambda: "haptics film" not in {thread.name for thread in threading.enumerate()})


def test_blocks_are_due_by_the_clock_of_the_film():
    sent, pad = [], profile("dualsense")
    player = player_of(sent)
    samples = np.random.default_rng(1).normal(size=(2, round(0.5 * RATE)))
    zero = time.perf_counter() + 0.9
    player.load({"pad": samples})
    player.follow(0.0, zero)
    played = samples[:, round(pad.latency * RATE) :]
    count = -(-played.shape[1] // BLOCK)
    deadline = time.monotonic() + 60
    while len(sent) < count and time.monotonic() < deadline:
        time.sleep(0.01)
        player._shown = time.perf_counter()  # as if pictures went on
    player.stop()
    assert [due for _, due in sent] == [zero + k * BLOCK / RATE for k in range(count)]
    assert np.array_equal(np.concatenate([block for block, _ in sent], axis=1), played)
