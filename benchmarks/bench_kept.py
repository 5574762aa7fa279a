"""What each format with waves or envelopes keeps of pulse trains, tones, noise, blows and sweeps.

    python -m benchmarks.bench_kept [--formats haptic ahap ...]

The files are read back. `kept`: onsets of which the envelope rises by at least a quarter of the
original's rise (12 dB), by the measure that reports of losses use, given the true times. `false`:
onsets that only the file has. `dB`: change of the power above 1.5 Hz, for formats that keep waves
within their range of frequencies. `ST-SIM`: vibromaf,
over the blocks in which the source sounds; it compares waves, phases included. Needs vibromaf.
"""

from __future__ import annotations

import argparse
import tempfile

import numpy as np
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io.catalogue import named
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.signals import DEFAULT_IMPACT, Pulse
from haptic_tracing.plugins.keyframes.comparison import Comparison, Kind, Measures

from .bench_formats import BLOCK, similarity
from .report import publish, table

RATE = 8000
SECONDS = 4
TIME = np.arange(SECONDS * RATE) / RATE
FORMATS = ("haptic", "ahap", "wyvrn", "hjif")


def trains() -> dict[str, tuple[np.ndarray, np.ndarray, bool]]:
    """Samples, times of onsets, and whether these are known as impacts, by name."""
    blow = DEFAULT_IMPACT.sample(0, RATE // 4, RATE)
    times = np.array([0.5, 1.1, 1.4, 2.3, 3.1])
    blows = np.zeros(len(TIME))
    for begin in np.rint(times * RATE).astype(int):
        blows[begin : begin + len(blow)] += 0.8 * blow
    none = np.zeros(0)
    found = {
        f"pulses of {hertz} Hz": (
            0.5 * np.asarray(Pulse(hertz).sample(0, len(TIME), RATE)),
            np.arange(1, SECONDS * hertz) / hertz,
            False,
        )
        for hertz in (5, 15, 30, 60)
    }
    found["half pulses of 15 Hz"] = (
        0.5 * np.asarray(Pulse(15, duty=0.5).sample(0, len(TIME), RATE)),
        np.arange(1, SECONDS * 15) / 15,
        False,
    )
    noise = np.random.default_rng(1).normal(0, 0.15, len(TIME))
    spectrum = np.fft.rfft(noise)
    spectrum[np.fft.rfftfreq(len(TIME), 1 / RATE) > 400] = 0
    return {
        **found,
        "sine of 10 Hz": (0.5 * np.sin(2 * np.pi * 10 * TIME), none, False),
        "sine of 80 Hz": (0.5 * np.sin(2 * np.pi * 80 * TIME), none, False),
        "noise": (np.clip(noise, -1, 1), none, False),
        "noise up to 400 Hz": (np.fft.irfft(spectrum), none, False),
        "blows, known": (blows, times, True),
        "blows, unknown": (blows, times, False),
        "sweep, 30 to 300 Hz": (
            0.5 * np.sin(2 * np.pi * (30 * TIME + 270 / (2 * SECONDS) * TIME**2)),
            none,
            False,
        ),
    }


def power(samples: np.ndarray, low: float, high: float) -> float:
    """The power between two frequencies (hertz)."""
    spectrum = np.abs(np.fft.rfft(samples)) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / RATE)
    return float(spectrum[(hertz >= low) & (hertz <= high)].sum())


def measured(
    form: str, samples: np.ndarray, onsets: np.ndarray, known: bool
) -> tuple[int, int, float, float, float]:
    """Onsets kept and invented, change of level, similarity, and bytes."""
    impacts = np.column_stack([onsets, np.full(len(onsets), 0.8)])
    given = ListenerTrack("hand", "hand.L", impacts if known else np.zeros((0, 2)))
    with tempfile.TemporaryDirectory() as folder:
        written = registry.write(
            form, Export("one", tracks=Tracks((given,), RATE, samples[None])), folder
        )
        channels = [
            channel
            for path in written.files
            if path.name.endswith(named(form).suffix)
            for channel in registry.read(path).channels
        ]
        size = sum(path.stat().st_size for path in written.files if path.suffix != ".config")
    played = np.zeros(len(TIME))
    for channel in channels:
        wave = channel.at_rate(RATE)[: len(TIME)]
        played[: len(wave)] += wave
    timed = ListenerTrack("hand", "hand.L", impacts)
    comparison = Comparison(Tracks((timed,), RATE, samples[None]), Measures(Kind.WAVE))
    comparison.add(0, played[:: comparison.thinning])
    (listener,) = comparison.result().listeners
    told, waves = written.fidelity, written.fidelity.kind is Kind.WAVE
    span = (told.low, told.high) if waves else (1.5, RATE / 2)
    count = len(TIME) // BLOCK * BLOCK
    return (
        len(onsets) - len(listener.missing) if len(onsets) else 0,
        len(listener.invented),
        10 * np.log10(power(played, *span) / power(samples, *span)),
        similarity(samples[:count], played[:count]),
        size,
    )


def main() -> None:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--formats", nargs="+", default=list(FORMATS), choices=FORMATS)
    rows = []
    for form in parser.parse_args().formats:
        for name, (samples, onsets, known) in trains().items():
            kept, false, level, score, size = measured(form, samples, onsets, known)
            rows.append(
                (
                    form,
                    name,
                    f"{kept} of {len(onsets)}" if len(onsets) else "-",
                    f"{false}",
                    f"{level:+.1f}",
                    f"{score:.3f}",
                    f"{size / SECONDS / 1000:.1f}",
                )
            )
    headings = ("format", "signal", "kept", "false", "dB", "ST-SIM", "kB a second")
    publish("kept", "What formats keep of signals", table(headings, rows), {"rows": rows})


if __name__ == "__main__":
    main()
