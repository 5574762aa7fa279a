"""The schedule by which tracks follow a film: all blocks, each once and in order, at the film's
clock."""

import time
from types import SimpleNamespace

import numpy as np
from haptic_tracing.command_line.study_playing import BLOCK, RATE, FilmPlayer
from haptic_tracing.core.devices.profiles import profile
from haptic_tracing.core.devices.status import Status


def test_blocks_are_due_by_the_clock_of_the_film():
    sent = []
    pad = profile("dualsense")
    output = SimpleNamespace(
        profile=pad,
        status=Status("open"),
        send=lambda block, due: sent.append((block, due)),
        expect=lambda block, due: None,
    )
    player = FilmPlayer(SimpleNamespace(outputs={"pad": output}, stop=lambda: None))
    samples = np.random.default_rng(1).normal(size=(2, round(0.5 * RATE)))
    zero = time.perf_counter() + 0.9
    player.load({"pad": samples})
    player.follow(0.0, zero)
    played = samples[:, round(pad.latency * RATE) :]
    count = -(-played.shape[1] // round(BLOCK * RATE))
    deadline = time.monotonic() + 60
    while len(sent) < count and time.monotonic() < deadline:
        time.sleep(0.01)
        player._shown = time.perf_counter()  # as if pictures went on
    player.stop()
    assert [due for _, due in sent] == [zero + k * BLOCK for k in range(count)]
    assert np.array_equal(np.concatenate([block for block, _ in sent], axis=1), played)
