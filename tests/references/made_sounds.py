"""Ten sounds with the times at which their events begin, known because they are put there. Seeds
are fixed."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from scipy.signal import butter, lfilter


class _Sheet:
    """Samples to which events are added, at a background of -60 dB."""

    def __init__(self, seconds, rate, seed):
        self.rate, self.rng = rate, np.random.default_rng(seed)
        self.samples = self.rng.normal(0.0, 0.001, round(seconds * rate))
        self.onsets = []

    def times(self, seconds):
        return np.arange(round(seconds * self.rate)) / self.rate

    def noise(self, seconds, low, high):
        """Band noise of about the amplitude 1."""
        raw = self.rng.normal(0.0, 1.0, round(seconds * self.rate))
        shaped = lfilter(*butter(2, [low, min(high, 0.45 * self.rate)], "band", fs=self.rate), raw)
        return shaped / np.std(shaped) / 2.0

    def add(self, time, event, is_onset=True):
        first = round(time * self.rate)
        part = self.samples[first : first + len(event)]
        part += event[: len(part)]
        if is_onset:
            self.onsets.append(first / self.rate)

    def done(self):
        peak = np.max(np.abs(self.samples))
        return self.samples / max(peak, 1.0), self.rate, np.array(sorted(self.onsets))


def _apart(rng, first, last, shortest, longest) -> Iterable[float]:
    time = first
    while time < last:
        yield time
        time += rng.uniform(shortest, longest)


def claps():
    """Bursts of 1 to 3 kHz, each of three within 6 ms, from -3 to -20 dB."""
    sheet = _Sheet(8.0, 48000, 1)
    for time in _apart(sheet.rng, 0.4, 7.5, 0.25, 0.8):
        level = 10 ** (-sheet.rng.uniform(3, 20) / 20)
        for later, share in ((0.0, 0.7), (0.003, 0.8), (0.006, 1.0)):
            t = sheet.times(0.12)
            sheet.add(
                time + later,
                level * share * sheet.noise(0.12, 1000, 3000) * np.exp(-t / 0.015),
                later == 0.0,
            )
    return sheet.done()


def engine():
    """An engine that starts, runs up from 25 to 50 firings a second, and backfires twice."""
    sheet = _Sheet(8.0, 44100, 2)
    t = sheet.times(7.0)
    firing = 25 * t + (25 / 14) * t**2
    body = sum(np.sin(2 * np.pi * k * firing) / k for k in range(1, 12)) + 0.1 * sheet.noise(
        7.0, 100, 2000
    )
    sheet.add(0.5, 0.12 * body * np.minimum(t / 0.01, 1.0))
    for time in (3.1, 5.6):
        t = sheet.times(0.2)
        sheet.add(time, 0.8 * sheet.noise(0.2, 60, 3000) * np.exp(-t / 0.04))
    return sheet.done()


def rain():
    """Steady rain at -35 dB, and drops on tin."""
    sheet = _Sheet(8.0, 48000, 3)
    sheet.samples += 0.02 * sheet.noise(8.0, 500, 8000)
    for time in _apart(sheet.rng, 0.5, 7.8, 0.06, 0.5):
        t = sheet.times(0.1)
        pitch = sheet.rng.uniform(1500, 4000)
        sheet.add(
            time,
            10 ** (-sheet.rng.uniform(6, 16) / 20)
            * np.sin(2 * np.pi * pitch * t)
            * np.exp(-t / 0.008),
        )
    return sheet.done()


def steps_on_gravel():
    """Crunches that swell within 10 ms, with grains in them."""
    sheet = _Sheet(6.0, 44100, 4)
    for time in _apart(sheet.rng, 0.3, 5.5, 0.5, 0.6):
        t = sheet.times(0.3)
        grains = np.repeat(sheet.rng.uniform(0.6, 1.0, 100), len(t) // 100 + 1)[: len(t)]
        sheet.add(
            time,
            0.5
            * sheet.noise(0.3, 300, 6000)
            * grains
            * np.minimum(t / 0.010, 1.0)
            * np.exp(-t / 0.07),
        )
    return sheet.done()


def knocks():
    """Threes on a wooden door."""
    sheet = _Sheet(6.0, 22050, 5)
    for group in (0.4, 2.1, 4.0):
        for number in range(3):
            t = sheet.times(0.25)
            wood = (
                np.sin(2 * np.pi * 180 * t)
                + 0.6 * np.sin(2 * np.pi * 420 * t)
                + 0.3 * sheet.noise(0.25, 800, 4000) * np.exp(-t / 0.004)
            )
            sheet.add(group + 0.22 * number, 0.4 * wood * np.exp(-t / 0.03))
    return sheet.done()


def anvil():
    """Strikes that ring into the next one."""
    sheet = _Sheet(6.0, 48000, 6)
    for time in _apart(sheet.rng, 0.3, 5.0, 0.6, 0.9):
        t = sheet.times(2.0)
        ring = sum(
            a * np.sin(2 * np.pi * f * t) * np.exp(-t / d)
            for f, a, d in ((830, 0.5, 0.6), (2170, 0.4, 0.4), (3910, 0.3, 0.2))
        )
        sheet.add(time, 0.5 * ring)
    return sheet.done()


def drums():
    """A bar of bass drum, snare and hi-hat, four times, at 120 beats a minute."""
    sheet = _Sheet(8.6, 44100, 7)
    for eighth in range(32):
        time = 0.25 + 0.25 * eighth
        t = sheet.times(0.2)
        if eighth % 4 == 0:
            event = (
                0.8
                * np.sin(2 * np.pi * (50 * t - 70 * 0.03 * np.exp(-t / 0.03)))
                * np.exp(-t / 0.08)
            )
        elif eighth % 4 == 2:
            event = 0.5 * sheet.noise(0.2, 200, 5000) * np.exp(-t / 0.05)
        else:
            event = 0.15 * sheet.noise(0.2, 6000, 12000) * np.exp(-t / 0.02)
        sheet.add(time, event)
    return sheet.done()


def plucked_strings():
    """A tune on strings that go on sounding."""
    sheet = _Sheet(6.0, 44100, 8)
    for number, semitones in enumerate((0, 4, 7, 12, 7, 4, 0, 5, 9, 12, 9, 5)):
        t = sheet.times(1.2)
        pitch = 147.0 * 2 ** (semitones / 12)
        string = sum(
            np.sin(2 * np.pi * k * pitch * t) / k * np.exp(-t * k / 0.8) for k in range(1, 10)
        )
        sheet.add(0.3 + 0.4 * number, 0.25 * string * np.minimum(t / 0.002, 1.0))
    return sheet.done()


def heart():
    """Lub, dub: low and soft, each swelling within 15 ms."""
    sheet = _Sheet(6.0, 8000, 9)
    for beat in np.arange(0.4, 5.5, 0.85):
        for later, pitch, level in ((0.0, 45.0, 0.6), (0.3, 65.0, 0.4)):
            t = sheet.times(0.2)
            sheet.add(
                beat + later,
                level
                * np.sin(2 * np.pi * pitch * t)
                * np.minimum(t / 0.015, 1.0)
                * np.exp(-t / 0.04),
            )
    return sheet.done()


def explosion():
    """A blast whose roar dies away, and the debris that falls."""
    sheet = _Sheet(7.0, 48000, 10)
    t = sheet.times(5.0)
    sheet.add(0.5, 0.5 * sheet.noise(5.0, 30, 1500) * np.exp(-t / 0.5))
    for time in _apart(sheet.rng, 2.0, 6.5, 0.2, 0.6):
        t = sheet.times(0.15)
        sheet.add(
            time,
            10 ** (-sheet.rng.uniform(10, 18) / 20)
            * sheet.noise(0.15, 300, 4000)
            * np.exp(-t / 0.02),
        )
    return sheet.done()


SOUNDS: tuple[Callable, ...] = (
    claps,
    engine,
    rain,
    steps_on_gravel,
    knocks,
    anvil,
    drums,
    plucked_strings,
    heart,
    explosion,
)
"""Each returns samples (n,), their rate [Hz], and the times of its onsets [s], ascending."""
