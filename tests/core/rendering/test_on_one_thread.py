"""Rendering uses no thread but its own, whatever the library for linear algebra would start, and
gives the same bits on any machine.

Threads of such a library wait for more work at full load for some milliseconds after each product,
and so take them from Blender.
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from haptic_tracing.core.render.mixing import MixingExpression
from haptic_tracing.core.render.renderer import ListenerMix, Renderer
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.scene.bands import BAND_COUNT
from haptic_tracing.core.signals import DecayingSine, Loop, Sampled, Signal, Sine
from threads_of_libraries import printed

LISTENERS = 24
FRAMES = 6


def voices(frame: int) -> list[Voice]:
    """Blows, tones and recordings, in bands and without, with delays and without: more than a
    library computes on one thread."""
    rng = np.random.default_rng(frame)
    signals: list[tuple[Signal, float]] = [(Sine(60.0 + k), 0.0) for k in range(60)]
    signals += [(DecayingSine(200.0 + k, 0.05), 0.01 * k) for k in range(80)]
    signals += [
        (Loop(Sampled(np.random.default_rng(k).uniform(-1, 1, 4000))), 0.0) for k in range(4)
    ]
    result = []
    for number, (signal, onset) in enumerate(signals):
        for bands in (False, True):
            for delayed in (False, True) if number % 10 == 0 or number >= 140 else (False,):
                gains = rng.uniform(0, 0.1, (LISTENERS, BAND_COUNT) if bands else (LISTENERS,))
                delays = rng.uniform(0, 0.01, LISTENERS) if delayed else None
                result.append(
                    Voice((number, bands, delayed), signal, gains, onset, 1.0, delays, 1.0 + number)
                )
    return result


def rendered() -> np.ndarray:
    """The samples of some frames by several methods of mixing."""
    blocks = []
    for method in (
        "cumulative",
        "weighted",
        "strongest",
        MixingExpression("weighted + 0.1 * power", 1.0),
    ):
        renderer = Renderer([ListenerMix(f"listener {k}", method) for k in range(LISTENERS)])
        blocks += [renderer.render_frame(k / 24, (k + 1) / 24, voices(k)) for k in range(FRAMES)]
    return np.concatenate(blocks, axis=1)


def seconds_of_others() -> float:
    """CPU time [s] of all threads of this process but this one."""
    return time.process_time() - time.thread_time()


@pytest.mark.slow
def test_same_bits_with_any_number_of_threads_and_none_of_them_works():
    code = (
        "from test_on_one_thread import seconds_of_others, rendered; before = seconds_of_others();"
        "print(rendered().tobytes().hex(), seconds_of_others() - before)"
    )
    (alone, _), (together, seconds) = (
        printed(code, __file__, threads).split() for threads in (1, 4)
    )
    assert alone == together
    assert float(seconds) < 0.01  # at full load as much as the frames take
