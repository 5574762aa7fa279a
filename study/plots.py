"""The report's plots, as PNG. matplotlib draws them; it is not needed for the rest of the
report."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Mapping
from io import BytesIO
from typing import Any

import numpy as np

from ..core.scene.values import Mode
from .checks import MATERIALS, shock_rows, stalactites, wall_amplitudes
from .measures import (
    active_count,
    balance,
    dynamic_range,
    patterns,
    spatial_spread,
    spectrogram,
    variety,
)
from .rendition import MODES, TITLES, Ride

COLOURS: Mapping[Mode, str] = {
    Mode.HT: "#d1495b",
    Mode.SD: "#2e86ab",
    Mode.MD: "#5f9e4a",
    Mode.MN: "#8a8a8a",
}
FLOOR = -46.0
SHOWN_HERTZ = 500.0


def can_plot() -> bool:
    """True where matplotlib is installed."""
    return importlib.util.find_spec("matplotlib") is not None


def plots(ride: Ride) -> Iterator[tuple[str, str, bytes]]:
    """Title, caption and PNG of each plot that the ride's frames have data for."""
    for name, title, first, last in ride.sections:
        if last > first:
            caption = (
                "Peak drive of every actuator, how many are active, and how far over the "
                "body the vibration reaches."
            )
            yield title, caption, _section(ride, name, first, last)
    yield (
        "Intensity",
        "Range and variety of intensity, and of patterns over the body, by section.",
        _intensity(ride),
    )
    yield (
        "Spectrogram",
        "All actuators together; decibels of a full-scale sine.",
        _spectrograms(ride),
    )
    if shock_rows(ride) is not None:
        yield (
            "Shock wave",
            "From left (-1) to right (+1) while the shock wave passes.",
            _shock_wave(ride),
        )
    if wall_amplitudes(ride):
        yield (
            "Walls",
            "What is felt of the impacts with each wall: mean over the actuators, and at each "
            "actuator.",
            _walls(ride),
        )
    if stalactites(ride):
        yield (
            "Stalactites",
            "Amplitude at the upper legs of each stalactite that strikes the ground.",
            _stalactites(ride),
        )


def _figure(rows: int, height: float, **options: Any) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, height), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, **options)


def _png(figure: Any) -> bytes:
    file = BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()


def _plain(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def _seconds(ride: Ride, rows: slice) -> Any:
    return (ride.frames[rows] - 1) / ride.frame_rate


def _section(ride: Ride, name: str, first: int, last: int) -> bytes:
    rows = ride.rows(first, last)
    seconds = _seconds(ride, rows)
    figure, axes = _figure(
        6, 10.5, sharex=True, gridspec_kw={"height_ratios": [2, 2, 2, 2, 1.1, 1.1]}
    )
    labels = [listener.replace("_", " ") for listener in ride.listeners]
    step = 1 / ride.frame_rate
    extent = (seconds[0] - step / 2, seconds[-1] + step / 2, len(labels) - 0.5, -0.5)
    for axis, mode in zip(axes[:4], MODES, strict=True):
        level = 20 * np.log10(np.maximum(ride.renditions[mode].peak[rows].T, 1e-6))
        image = axis.imshow(
            level,
            aspect="auto",
            cmap="magma",
            vmin=FLOOR,
            vmax=0,
            extent=extent,
            interpolation="nearest",
        )
        axis.set_yticks(range(len(labels)), labels, fontsize=7)
        axis.set_title(
            f"{mode}  {TITLES[mode]}",
            loc="left",
            fontsize=9,
            color=COLOURS[mode],
            fontweight="bold",
        )
    figure.colorbar(image, ax=axes[:4], label="peak [dB of full scale]", pad=0.01, fraction=0.03)
    # Coincident lines differ in width.
    for width, mode in zip((1.2, 1.6, 2.4, 3.6), MODES, strict=True):
        rendition = ride.renditions[mode]
        style = {
            "color": COLOURS[mode],
            "linewidth": width,
            "label": str(mode),
            "zorder": 5 - width,
        }
        axes[4].plot(seconds, active_count(rendition.peak[rows]), drawstyle="steps-mid", **style)
        axes[5].plot(
            seconds,
            spatial_spread(rendition.rms[rows], ride.positions),
            drawstyle="steps-mid",
            **style,
        )
    axes[4].set(ylabel="active", ylim=(-0.5, len(labels) + 0.5))
    axes[5].set(ylabel="spread [m]", xlabel="time [s]", ylim=(0, None))
    axes[4].legend(ncols=4, fontsize=7, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    for axis in axes[4:]:
        _plain(axis)
    return _png(figure)


def _intensity(ride: Ride) -> bytes:
    figure, axes = _figure(1, 3.6, ncols=3)
    groups = [(title, first, last) for _, title, first, last in ride.sections]
    groups.append(("all", int(ride.frames[0]), int(ride.frames[-1])))
    measures = (
        ("range [dB]", dynamic_range),
        ("variety [bits]", variety),
        ("patterns [bits]", patterns),
    )
    for axis, (label, measure) in zip(axes, measures, strict=True):
        for number, mode in enumerate(MODES):
            values = [measure(ride.effects(mode, first, last)) for _, first, last in groups]
            axis.bar(
                np.arange(len(groups)) + 0.2 * (number - 1.5),
                values,
                0.2,
                color=COLOURS[mode],
                label=str(mode),
            )
        axis.set_xticks(
            range(len(groups)),
            [title.split(" ")[0] for title, *_ in groups],
            rotation=35,
            ha="right",
            fontsize=7,
        )
        axis.set_title(label, fontsize=9)
        _plain(axis)
    axes[0].legend(fontsize=7, ncols=2)
    return _png(figure)


def _spectrograms(ride: Ride) -> bytes:
    figure, axes = _figure(4, 8, sharex=True)
    for axis, mode in zip(axes, MODES, strict=True):
        tracks = ride.renditions[mode].tracks
        seconds, hertz, power = spectrogram(tracks.samples, tracks.sample_rate)
        shown = hertz <= SHOWN_HERTZ
        if len(seconds):
            extent = (tracks.start + seconds[0], tracks.start + seconds[-1], 0, hertz[shown][-1])
            image = axis.imshow(
                _pooled(power[shown]),
                aspect="auto",
                origin="lower",
                cmap="magma",
                vmin=-80,
                vmax=-10,
                extent=extent,
            )
        axis.set(ylabel="Hz")
        axis.set_title(
            f"{mode}  {TITLES[mode]}",
            loc="left",
            fontsize=9,
            color=COLOURS[mode],
            fontweight="bold",
        )
    axes[-1].set(xlabel="time [s]")
    if len(seconds):
        figure.colorbar(image, ax=axes, label="dB", pad=0.01, fraction=0.03)
    return _png(figure)


def _pooled(power: Any, columns: int = 1000) -> Any:
    """Reduce columns to the picture's pixels by their maxima, so that no short impact is lost."""
    size = -(-power.shape[1] // columns)
    padded = np.pad(power, ((0, 0), (0, -power.shape[1] % size)), mode="edge")
    return padded.reshape(len(power), -1, size).max(axis=2)


def _shock_wave(ride: Ride) -> bytes:
    rows = shock_rows(ride)
    assert rows is not None
    seconds = _seconds(ride, rows)
    figure, axis = _figure(1, 3.4)
    for width, mode in zip((1.6, 1.8, 2.4, 3.4), MODES, strict=True):
        values = balance(ride.renditions[mode].rms[rows], ride.listeners)
        axis.plot(
            seconds, values, color=COLOURS[mode], linewidth=width, label=str(mode), zorder=5 - width
        )
    axis.axhline(0, color="#444", linewidth=0.6)
    axis.set(xlabel="time [s]", ylabel="left   balance   right", ylim=(-1.05, 1.05))
    axis.legend(ncols=4, fontsize=8, frameon=False)
    _plain(axis)
    return _png(figure)


def _walls(ride: Ride) -> bytes:
    walls = wall_amplitudes(ride)
    names = [f"{material} Wall {number}" for material in MATERIALS for number in (1, 2, 3)]
    present = [name for name in names if name in walls]
    figure, axes = _figure(2, 5.6, gridspec_kw={"height_ratios": [1, 1.3]})
    for number, mode in enumerate(MODES):
        values = [walls[name][number].mean() for name in present]
        axes[0].bar(
            np.arange(len(present)) + 0.2 * (number - 1.5),
            values,
            0.2,
            color=COLOURS[mode],
            label=str(mode),
        )
    axes[0].set_xticks(range(len(present)), [name.replace(" Wall", "") for name in present])
    axes[0].set(ylabel="mean amplitude")
    axes[0].legend(ncols=4, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    _plain(axes[0])
    shown = np.concatenate([[walls[name][number] for name in present] for number in range(4)]).T
    image = axes[1].imshow(shown, aspect="auto", cmap="magma", vmin=0)
    axes[1].set_yticks(
        range(len(ride.listeners)),
        [listener.replace("_", " ") for listener in ride.listeners],
        fontsize=7,
    )
    ticks = [len(present) * (k + 0.5) - 0.5 for k in range(4)]
    axes[1].set_xticks(ticks, [f"{mode}: {len(present)} walls" for mode in MODES])
    for k in range(1, 4):
        axes[1].axvline(len(present) * k - 0.5, color="white", linewidth=1.5)
    figure.colorbar(image, ax=axes[1], label="amplitude", pad=0.01, fraction=0.03)
    return _png(figure)


def _stalactites(ride: Ride) -> bytes:
    falls = stalactites(ride)
    figure, axes = _figure(1, 3.2, ncols=2, sharey=True)
    for axis, side in zip(axes, "LR", strict=True):
        column = ride.listeners.index(f"upper_leg.{side}")
        for number, mode in enumerate(MODES):
            values = [fall.amplitudes[number][column] for fall in falls]
            axis.bar(
                np.arange(len(falls)) + 0.2 * (number - 1.5),
                values,
                0.2,
                color=COLOURS[mode],
                label=str(mode),
            )
        numbers = [
            next(name for name in fall.objects if name.startswith("Stalactite")).split(" ")[1]
            for fall in falls
        ]
        axis.set_xticks(range(len(falls)), numbers, fontsize=7)
        axis.set_title(f"{'left' if side == 'L' else 'right'} leg", fontsize=9)
        _plain(axis)
    axes[0].set(ylabel="amplitude that arrives")
    axes[1].legend(ncols=4, fontsize=8, frameon=False)
    return _png(figure)
