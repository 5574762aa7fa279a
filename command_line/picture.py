"""Pictures of exports: waveforms and spectra of the rendered signal, of the decoded files, and of
their difference."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import FloatArray
from ..core.formats import registry
from ..core.formats.io.catalogue import named, readers
from ..core.formats.tracks.fidelity import ListenerFidelity
from ..core.formats.tracks.listener_tracks import Tracks

COLUMNS = 1500
"""Columns of a waveform, each with the least and the largest sample of its time."""
SHOWN_HERTZ = 1000.0
WINDOW = 4096


def check_matplotlib(option: str) -> None:
    """Raise ValueError that names the option if matplotlib is missing."""
    if importlib.util.find_spec("matplotlib") is None:
        raise ValueError(f"{option}: matplotlib is not installed: pip install matplotlib")


def write_picture(
    name: str, tracks: Tracks, written: registry.Written, folder: Path, stem: str
) -> Path | None:
    """Write a picture of what a format keeps of each listener; None for a format that cannot be
    decoded, or not by listener.

    Args:
        name: of the format.
        tracks: that were exported.
        written: its files.
        folder: of the picture.
        stem: of its name, ``<stem>.<name>.png``.
    """
    readable = [
        path
        for path in written.files
        if readers().get(path.suffix) == name and ".transients." not in path.name
    ]
    channels = [channel for path in readable for channel in registry.read(path).channels]
    if not channels or len(channels) != len(tracks.listeners):
        return None
    pairs = []
    for number, channel in enumerate(channels):
        original = tracks.row(number).read(0, tracks.count)
        decoded = np.zeros(len(original))
        found = channel.at_rate(tracks.sample_rate)[: len(original)]
        decoded[: len(found)] = found
        pairs.append((tracks.listeners[number].name, original, decoded))
    path = folder / f"{stem}.{name}.png"
    losses = (
        {}
        if written.fidelity is None
        else {listener.name: listener for listener in written.fidelity.listeners}
    )
    _draw(pairs, losses, tracks.sample_rate, f"{stem}, {named(name).label}", path)
    return path


def _draw(
    pairs: Sequence[tuple[str, FloatArray, FloatArray]],
    losses: Mapping[str, ListenerFidelity],
    rate: int,
    title: str,
    path: Path,
) -> None:
    """Draw wave and spectra of each listener, before and after.

    Args:
        pairs: name, samples as exported, and samples as decoded.
        losses: what was measured, by name of the listener.
        rate: samples per second.
        title: of the picture.
        path: of the file.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 1 + 2.2 * len(pairs)), dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, parse_math=False)
    axes = figure.subplots(len(pairs), 3, squeeze=False)
    for row, (name, original, decoded) in zip(axes, pairs, strict=True):
        _wave(row[0], original, rate, "original", "C0")
        _wave(row[0], decoded, rate, "decoded", "C1")
        row[0].set_ylabel(name, parse_math=False)
        if name in losses:
            _mark(row[0], losses[name])
        for samples, label in ((original, "original"), (decoded, "decoded")):
            row[1].plot(*_spectrum(samples, rate), label=label, linewidth=0.9)
        row[1].set_xlim(0, min(SHOWN_HERTZ, rate / 2))
        _wave(row[2], decoded - original, rate, "difference", "C3")
        row[2].set_ylim(
            *(
                choose(row[k].get_ylim()[end] for k in (0, 2))
                for end, choose in ((0, min), (1, max))
            )
        )
    for axis, heading in zip(
        axes[0], ("wave", "spectrum [dB]", "decoded less original"), strict=True
    ):
        axis.set_title(heading)
    for axis, unit in zip(axes[-1], ("s", "Hz", "s"), strict=True):
        axis.set_xlabel(unit)
    axes[0][0].legend(loc="upper right")
    figure.savefig(path, format="png", metadata={"Software": None})


def _mark(axis: Any, found: ListenerFidelity) -> None:
    """The change of level, and lines at the onsets that are missing or invented."""
    axis.text(
        0.01, 0.97, f"{found.level:+z.1f} dB", transform=axis.transAxes, va="top", fontweight="bold"
    )
    for times, label, colour in (
        (found.missing, "missing onset", "C3"),
        (found.invented, "invented onset", "C4"),
    ):
        for number, time in enumerate(times):
            axis.axvline(
                time, color=colour, linestyle="--", linewidth=1.2, label=None if number else label
            )
    if found.missing or found.invented:
        axis.legend(loc="upper right")


def _wave(axis: Any, samples: FloatArray, rate: int, label: str, colour: str) -> None:
    """Draw the range of the samples in each column.

    Args:
        axis: to draw into.
        samples: (n,).
        rate: samples per second.
        label: of the wave.
        colour: of the wave.
    """
    step = max(-(-len(samples) // COLUMNS), 1)
    parts = np.pad(samples, (0, -len(samples) % step), mode="edge").reshape(-1, step)
    times = np.arange(len(parts)) * step / rate
    axis.fill_between(
        times,
        parts.min(axis=1),
        parts.max(axis=1),
        label=label,
        color=colour,
        alpha=0.6,
        linewidth=0.6,
    )


def _spectrum(samples: FloatArray, rate: int) -> tuple[FloatArray, FloatArray]:
    """Frequencies [Hz], and the mean power of Hann windows in decibels."""
    padded = np.pad(samples, (0, -len(samples) % WINDOW)).reshape(-1, WINDOW)
    power = (np.abs(np.fft.rfft(padded * np.hanning(WINDOW), axis=1)) ** 2).mean(axis=0) / WINDOW**2
    return np.asarray(np.fft.rfftfreq(WINDOW, 1 / rate), dtype=np.float64), np.asarray(
        10 * np.log10(np.maximum(power, 1e-14))
    )
