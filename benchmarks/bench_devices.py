"""Similarity of each device's output to the signal: ST-SIM (spectral and temporal similarity of 8
kHz vibration, 1 is equal), as a table.

    python -m benchmarks.bench_devices

Each signal goes through the device's actuation, pace and limits, frame by frame at 24 frames a
second on a clock of its own. What the reports make the actuator do is then played: samples as they
are, tones as they are told. Where only strength is told, it is the middle of the actuator's band:
ST-SIM, which compares waves, is then near 0, however well strength follows. The lag is how many
milliseconds later that is than the signal, taken out before the comparison.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from haptic_tracing.core.arrays import FloatArray
from haptic_tracing.core.devices.families.family import RumbleFamily, StreamFamily
from haptic_tracing.core.devices.pacing import pacing_of
from haptic_tracing.core.devices.profile_files import load_profiles
from haptic_tracing.core.devices.profiles import Actuator, Adjustment, Profile
from haptic_tracing.core.devices.report import Report, Tones
from haptic_tracing.core.signals import (
    DecayingSine,
    Loop,
    Noise,
    Pulse,
    Signal,
    Sine,
    impact_template,
    ramp,
)
from numpy.typing import NDArray
from vibromaf.metrics.stsim import st_sim

RATE, SECONDS, FPS = 8000, 4.0, 24.0
BLOCK = 512  # samples that ST-SIM looks at together
LONGEST_LAG = 0.120
SIGNALS: dict[str, Signal] = {
    "60 Hz": Sine(60.0, 0.6),
    "150 Hz": Sine(150.0, 0.6),
    "30-400 Hz": Sine(ramp(30.0, 400.0, SECONDS), 0.6),
    "jackhammer": 0.8 * Pulse(20.0),
    "impacts": 0.8 * Loop(impact_template("stone", "wood") >> 0.0 * DecayingSine(100.0, 0.02)),
    "noise": 0.4 * Noise(),
}


@dataclass(slots=True)
class Written:
    """The reports to a device with their times."""

    times: list[float]
    drives: list[Tones | NDArray[np.int8]]


def driven(profile: Profile, signal: FloatArray) -> Written:
    """Everything that is written to a device, all of whose actuators get the signal."""
    written = Written([], [])
    family = profile.family
    transport = family.transports[0]
    told: list[Tones | NDArray[np.int8]] = []

    def encode(drive: Tones | NDArray[np.int8], *_: object) -> Report:
        told.append(drive)
        return Report(
            repr(drive.amplitudes + drive.frequencies).encode()
            if isinstance(drive, Tones)
            else drive.tobytes()
        )

    recorder: Any = encode  # of either kind of family
    recording = replace(family, encode=recorder, startup=lambda *_: (), release=lambda *_: ())
    profile = replace(profile, family=recording)
    pacing = pacing_of(profile, recording, transport, RATE, Adjustment())
    edges = np.ceil(np.arange(round(SECONDS * FPS) + 1) / FPS * RATE - 1e-6).astype(int)
    now = 1.0
    for first, last in pairwise(edges):
        start, end = 1.0 + first / RATE, 1.0 + last / RATE
        pacing.accept(np.tile(signal[first:last], (len(profile.actuators), 1)), start)
        now = max(now, start)
        while now < end:
            report = pacing.next_report(now)
            if report is not None:
                written.times.append(now - 1.0)
                written.drives.append(told[-1])
                continue
            due = pacing.wake(now)
            now = end if due is None else min(max(due, now + 1e-6), end)
    return written


def played(profile: Profile, written: Written) -> FloatArray:
    """The motion of the first actuator, as samples from the start of the signal on."""
    family, actuator = profile.family, profile.actuators[0]
    samples = np.zeros(round(SECONDS * RATE))
    if isinstance(family, StreamFamily):
        channel = family.channels.index(actuator.channels[0].name)
        stream = np.concatenate([np.asarray(drive)[channel] for drive in written.drives]) / 127.0
        times = np.arange(len(samples)) / RATE - written.times[0]
        return np.interp(times, np.arange(len(stream)) / family.rate, stream, left=0.0, right=0.0)
    places = [family.channels.index(channel.name) for channel in actuator.channels]
    edges = [*(round(time * RATE) for time in written.times), len(samples)]
    phases = np.zeros(len(places))
    for drive, first, last in zip(written.drives, edges[:-1], edges[1:], strict=True):
        assert isinstance(drive, Tones)
        for number, place in enumerate(places):
            frequency = drive.frequencies[place] if family.has_tones else natural(actuator, number)
            steps = phases[number] + 2 * np.pi * frequency / RATE * np.arange(last - first)
            samples[first:last] += drive.amplitudes[place] * np.sin(steps)
            phases[number] += 2 * np.pi * frequency / RATE * (last - first)
    return samples


def natural(actuator: Actuator, channel: int) -> float:
    """What an actuator plays whose frequency can't be chosen: the middle of the band that the
    channel takes."""
    takes = actuator.channels[channel].takes
    return float(np.sqrt(max(actuator.band[0], takes[0]) * min(actuator.band[1], takes[1])))


def compared(signal: FloatArray, result: FloatArray) -> tuple[float, float]:
    """ST-SIM at the lag where signal and result fit best, and that lag in seconds."""
    size = 2 * len(signal)
    fit = np.fft.irfft(np.fft.rfft(result, size) * np.fft.rfft(signal, size).conj(), size)
    lag = int(np.argmax(fit[: round(LONGEST_LAG * RATE)]))
    count = (len(signal) - lag) // BLOCK * BLOCK
    source, again = signal[:count].reshape(-1, BLOCK), result[lag : lag + count].reshape(-1, BLOCK)
    sounds = np.abs(source).max(axis=1) > 1e-3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        # It has no real value where the result runs against the signal.
        return max(
            float(np.real(st_sim(again[sounds].ravel(), source[sounds].ravel()))), 0.0
        ), lag / RATE


def main() -> None:
    """Print the table."""
    print("ST-SIM (lag in ms)")
    print(f"{'device':22}" + "".join(f"{name:>16}" for name in SIGNALS))
    samples = {
        name: signal.sample(0, round(SECONDS * RATE), RATE) for name, signal in SIGNALS.items()
    }
    for profile in load_profiles()[0].values():
        cells = []
        for signal in samples.values():
            score, lag = compared(signal, played(profile, driven(profile, signal)))
            cells.append(f"{score:8.3f} ({1000 * lag:4.0f})")
        kind = (
            "samples"
            if not isinstance(profile.family, RumbleFamily)
            else "tones"
            if profile.plays_frequency
            else "strength"
        )
        print(
            f"{profile.name:22}" + "".join(f"{cell:>16}" for cell in cells) + f"  {kind}",
            flush=True,
        )


if __name__ == "__main__":
    main()
