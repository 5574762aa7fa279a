"""How much faster than real time 10 listeners x 32 voices are rendered at 8 kHz on one core, frame
by frame as live playback does it.

    python -m benchmarks.bench_rendering [--voices 32] [--listeners 10] [--fps 30] [--seconds 10]

Gains (and delays) of every path change in every frame. `ratio` is seconds of signal by seconds of
CPU time of this one thread, the best of five runs; `median` and `worst` are the milliseconds of one
frame.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from haptic_tracing.core.render.mixing import MixingMethod
from haptic_tracing.core.render.renderer import SAMPLE_RATE, ListenerMix, Renderer
from haptic_tracing.core.render.voices import Voice
from haptic_tracing.core.scene.bands import BAND_COUNT
from haptic_tracing.core.scene.impact_rule import ImpactRule
from haptic_tracing.core.signals import (
    IMPACT_MATERIALS,
    Adsr,
    Loop,
    Noise,
    Sampled,
    Signal,
    Sine,
    impact_template,
    ramp,
)

from .timing import peak

TARGET = 100.0
IMPACTS = 500


@dataclass(frozen=True, slots=True)
class Load:
    """One row of the table: what every voice and listener does."""

    name: str
    signal: Callable[[int], Signal]
    method: MixingMethod = "cumulative"
    limiter: bool = False
    bands: bool = False
    delays: str = "none"


def tone(number: int) -> Signal:
    return Sine(40.0 + 3.0 * number)


def rich(number: int) -> Signal:
    return Sine(ramp(40.0, 200.0 + number, 5.0), 0.8) * Adsr() + Noise(0.2, seed=number)


def recording(number: int) -> Signal:
    return Loop(Sampled(np.random.default_rng(number).uniform(-1, 1, 4000)))


LOADS = (
    Load("steady tones", tone),
    Load("steady tones, limiter", tone, limiter=True),
    Load("steady tones, strongest", tone, method="strongest"),
    Load("steady tones, power", tone, method="power"),
    Load("sweep x envelope + noise", rich),
    Load("looped recordings", recording),
    Load(
        "impacts, 1 s apart",
        lambda number: Loop(impact_template("stone", "metal"), crossfade=0.001 * (number % 3)),
    ),
    Load("steady tones, 6 bands", tone, bands=True),
    Load("looped recordings, 6 bands", recording, bands=True),
    Load("steady tones, moving delays", tone, delays="moving"),
    Load("steady tones, 6 bands, still delays", tone, bands=True, delays="still"),
    Load("steady tones, 6 bands, moving delays", tone, bands=True, delays="moving"),
    Load("sweep x envelope + noise, moving delays", rich, delays="moving"),
    Load("looped recordings, still delays", recording, delays="still"),
    Load("looped recordings, 6 bands, still delays", recording, bands=True, delays="still"),
)


def frame_times(
    load: Load, voices: int, listeners: int, fps: float, seconds: float
) -> tuple[float, np.ndarray]:
    """Return the seconds of CPU time for all frames and the milliseconds of each."""
    random = np.random.default_rng(0)
    count = round(seconds * fps)
    gains = random.uniform(
        0.0, 0.1, (64, voices, listeners, BAND_COUNT) if load.bands else (64, voices, listeners)
    )
    lags = random.uniform(0.0, 0.02, (voices, listeners)) + np.zeros((64, 1, 1))
    if load.delays == "moving":
        lags += random.uniform(0.0, 0.002, lags.shape)
    signals = [load.signal(number) for number in range(voices)]
    renderer = Renderer(
        [
            ListenerMix(str(number), load.method, limiter=load.limiter)
            for number in range(listeners)
        ],
        SAMPLE_RATE,
    )
    each = np.empty(count)
    begun = time.process_time()
    for frame in range(count):
        entered = time.perf_counter()
        playing = [
            Voice(
                number,
                signals[number],
                gains[frame % 64, number],
                delays=None if load.delays == "none" else lags[frame % 64, number],
            )
            for number in range(voices)
        ]
        renderer.render_frame(frame / fps, (frame + 1) / fps, playing)
        each[frame] = time.perf_counter() - entered
    return time.process_time() - begun, 1000.0 * each


def impacts(listeners: int, fps: float, seconds: float, recorded: bool) -> float:
    """Return the seconds of CPU time for a second in which 500 impacts sound at any time, each
    replaced by another one when it has ended: of all pairs of materials, or of one recording of
    half a second; each has a pitch, a decay and a brightness of its own."""
    random = np.random.default_rng(0)
    names = sorted(IMPACT_MATERIALS)
    rule = ImpactRule(variation=0.2, brightness=(0.3, 1.0), decay=(0.5, 1.0))
    recording = Sampled(random.uniform(-1, 1, 4000) * np.exp(-np.arange(4000) / 800))

    def begun(number: int, time: float) -> tuple[int, Signal, float]:
        template = (
            recording
            if recorded
            else impact_template(names[number % 20], names[number * 7 // 3 % 20])
        )
        return number, rule.played(template, number * 13 % 100 / 100, ("a", "b"), time)[0], time

    sounding = [begun(number, -random.uniform(0.0, 1.0)) for number in range(IMPACTS)]
    gains = random.uniform(0.0, 0.1, (64, IMPACTS, listeners))
    renderer = Renderer([ListenerMix(str(number)) for number in range(listeners)], SAMPLE_RATE)
    number, entered = IMPACTS, time.process_time()
    for frame in range(round(seconds * fps)):
        now = frame / fps
        for place, (_, signal, onset) in enumerate(sounding):
            if onset + signal.duration <= now:
                sounding[place], number = begun(number, now), number + 1
        voices = [
            Voice(key, signal, gains[frame % 64, place], onset=onset)
            for place, (key, signal, onset) in enumerate(sounding)
        ]
        renderer.render_frame(now, now + 1.0 / fps, voices)
    return (time.process_time() - entered) / seconds


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--voices", type=int, default=32)
    parser.add_argument("--listeners", type=int, default=10)
    parser.add_argument("--fps", type=float, default=30.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    print(
        f"{options.listeners} listeners x {options.voices} voices, {SAMPLE_RATE:g} Hz, "
        f"{options.fps:g} frames a second"
    )
    print(f"{'load':42} {'ratio':>8} {'median ms':>10} {'worst ms':>9}")
    for load in LOADS:
        seconds = (
            options.seconds
            if load.delays == "none" or load.signal is tone
            else options.seconds / 10
        )
        runs = [
            frame_times(load, options.voices, options.listeners, options.fps, seconds)
            for _ in range(5)
        ]
        used, each = min(runs, key=lambda run: run[0])
        print(
            f"{load.name:42} {seconds / used:8.1f} {np.median(each):10.3f} {each.max():9.3f}",
            flush=True,
        )
    print(f"target: steady tones at least {TARGET:g}")
    for name, recorded in (("of materials", False), ("of a recording", True)):
        used = min(impacts(options.listeners, options.fps, 3.0, recorded) for _ in range(5))
        most = peak(impacts, options.listeners, options.fps, 3.0, recorded)
        ratio = f"{1.0 / used:8.1f}   (target: at least 1)"
        print(
            f"{f'{IMPACTS} impacts at once, {name}':42} {ratio}, {most / 1e6:.0f} MB at most",
            flush=True,
        )


if __name__ == "__main__":
    main()
