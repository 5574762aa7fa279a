"""The report's plots, as PNG. matplotlib draws them; it is not needed for the rest of the
report."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from ..core.scene.body_map import figure as body_figure
from ..core.scene.values import Mode
from .checks import MATERIALS, shock_rows, stalactites, wall_amplitudes
from .measures import (
    balance,
    dynamic_range,
    felt_count,
    patterns,
    spatial_spread,
    spectrogram,
    variety,
)
from .rendition import MODES, TITLES, Ride
from .side_by_side import sensations

COLOURS: Mapping[Mode, str] = {
    Mode.HT: "#d1495b",
    Mode.SD: "#2e86ab",
    Mode.MD: "#5f9e4a",
    Mode.MN: "#8a8a8a",
}
FLOOR = -46.0
LEAST_MARGIN = -30.0
"""Lower end of plotted margins [dB]."""
SHOWN_HERTZ = 500.0


def can_plot() -> bool:
    """True where matplotlib is installed."""
    return importlib.util.find_spec("matplotlib") is not None


OPENING = 3
"""Number of plots that the report opens with."""


def plots(ride: Ride) -> Iterator[tuple[str, str, bytes]]:
    """Title, caption and PNG of each plot that the ride's frames have data for."""
    yield (
        "What is felt, where and when",
        "Highest margin of each second at every actuator, in decibels above the threshold of "
        "feeling (the line at 0; what is grey below is not felt), by mode.",
        _over_time(ride),
    )
    yield (
        "Margins by section",
        "The highest margin at each of the actuators (dots) by section and mode; the number says "
        "at how many anything is felt.",
        _margins(ride),
    )
    yield (
        "Ranges",
        "Range and variety of what is felt, and of patterns over the body, by section.",
        _intensity(ride),
    )
    for _name, title, first, last in ride.sections:
        if last > first:
            caption = (
                "Peak drive of every actuator, at how many anything is felt, and how far over the "
                "body the vibration reaches."
            )
            yield title, caption, _section(ride, first, last)
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


def _bars(axis: Any, by_mode: Mapping[Mode, Sequence[float]], names: Sequence[str]) -> None:
    """A bar of each mode beside each other for every name."""
    for number, (mode, values) in enumerate(by_mode.items()):
        places = np.arange(len(values)) + 0.2 * (number - 1.5)
        axis.bar(places, values, 0.2, color=COLOURS[mode], label=str(mode))
    axis.set_xticks(range(len(names)), names, fontsize=7)
    _plain(axis)


def _head(axis: Any, mode: Mode) -> None:
    axis.set_title(
        f"{mode}  {TITLES[mode]}", loc="left", fontsize=9, color=COLOURS[mode], fontweight="bold"
    )


def _plain(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def _seconds(ride: Ride, rows: slice) -> Any:
    return (ride.frames[rows] - 1) / ride.frame_rate


def _section(ride: Ride, first: int, last: int) -> bytes:
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
        _head(axis, mode)
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
        axes[4].plot(seconds, felt_count(rendition.margin[rows]), drawstyle="steps-mid", **style)
        axes[5].plot(
            seconds,
            spatial_spread(rendition.rms[rows], ride.positions),
            drawstyle="steps-mid",
            **style,
        )
    axes[4].set(ylabel="felt", ylim=(-0.5, len(labels) + 0.5))
    axes[5].set(ylabel="spread [m]", xlabel="time [s]", ylim=(0, None))
    axes[4].legend(ncols=4, fontsize=7, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    for axis in axes[4:]:
        _plain(axis)
    return _png(figure)


def _over_time(ride: Ride) -> bytes:
    """The margins over time at every actuator, beside its place on the body."""
    figure, _ = _figure(1, 9.5)
    figure.clear()
    heights = {limb.part: limb.start[1] for limb in body_figure("back")}
    shown = sorted((name for name in ride.listeners if name in heights), key=lambda n: -heights[n])
    parts = list(dict.fromkeys(name.partition(".")[0] for name in shown))
    grid = figure.add_gridspec(len(parts), 3, width_ratios=[3, 1, 3])
    body = figure.add_subplot(grid[:, 1])
    _draw_body(body, ride.listeners)
    per = max(round(ride.frame_rate), 1)
    starts = np.arange(0, len(ride.frames), per)
    seconds = (ride.frames[starts] - 1) / ride.frame_rate
    for number, listener in enumerate(ride.listeners):
        part, _, side = listener.partition(".")
        if part not in parts:
            continue
        axis = figure.add_subplot(grid[parts.index(part), 0 if side == "L" else 2])
        axis.axhspan(LEAST_MARGIN, 0, color="#e8e8ec", zorder=0)
        for width, mode in zip((1.6, 1.4, 1.6, 1.2), MODES, strict=True):
            margin = np.maximum.reduceat(ride.renditions[mode].margin[:, number], starts)
            axis.plot(
                seconds,
                np.maximum(margin, LEAST_MARGIN),
                drawstyle="steps-post",
                color=COLOURS[mode],
                linewidth=width,
                label=str(mode),
            )
        _mark_sections(ride, axis, labelled=part == parts[0])
        axis.set(ylim=(LEAST_MARGIN, 50), ylabel="dB")
        axis.set_title(listener.replace("_", " "), loc="left", fontsize=8, fontweight="bold")
        if part != parts[-1]:
            axis.tick_params(labelbottom=False)
        else:
            axis.set_xlabel("time [s]")
        _plain(axis)
    handles, labels = figure.axes[-1].get_legend_handles_labels()
    body.legend(handles, labels, loc="lower center", ncols=2, fontsize=8, frameon=False)
    return _png(figure)


def _mark_sections(ride: Ride, axis: Any, labelled: bool) -> None:
    """Draw where sections begin, with their names."""
    for number, (_, title, first, _) in enumerate(ride.sections):
        second = (first - 1) / ride.frame_rate
        axis.axvline(second, color="#999", linewidth=0.6)
        if labelled:
            place = 46 - 7 * (number % 2)
            axis.text(second, place, f" {title.split(' ')[0]}", fontsize=6, va="top")


def _draw_body(axis: Any, listeners: Sequence[str]) -> None:
    """The body from behind with the places of the listeners, as in the body maps."""
    for limb in body_figure("back"):
        axis.plot(
            *zip(limb.start, limb.end, strict=True),
            color=COLOURS[Mode.HT] if limb.part in listeners else "#d5d5dc",
            linewidth=80 * limb.width,
            solid_capstyle="round",
            marker="o",  # a line without length isn't drawn
            markersize=80 * limb.width,
            markeredgewidth=0,
        )
    axis.set(aspect="equal", xlim=(-0.62, 0.62), ylim=(-0.4, 2.0))
    axis.set_title("from behind", fontsize=8)
    axis.axis("off")


def _margins(ride: Ride) -> bytes:
    figure, axis = _figure(1, 4.2)
    axis.axhspan(LEAST_MARGIN, 0, color="#e8e8ec", zorder=0)
    for number, mode in enumerate(MODES):
        for place, (_, margins) in enumerate(sensations(ride, mode)):
            x = place + 0.2 * (number - 1.5)
            shown = np.maximum(margins, LEAST_MARGIN)
            axis.scatter(
                np.full(len(shown), x),
                shown,
                s=16,
                color=COLOURS[mode],
                alpha=0.8,
                label=str(mode) if place == 0 else None,
            )
            axis.text(
                x, max(shown.max(), 0) + 1.5, str((margins > 0).sum()), ha="center", fontsize=8
            )
    axis.set_xticks(range(len(ride.sections)), [title for _, title, *_ in ride.sections])
    axis.set(ylabel="margin [dB above the threshold of feeling]", ylim=(LEAST_MARGIN, 55))
    axis.legend(ncols=4, fontsize=8, frameon=False, loc="upper right")
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
        values = {
            mode: [measure(ride.margins(mode, first, last)) for _, first, last in groups]
            for mode in MODES
        }
        _bars(axis, values, [title.split(" ")[0] for title, *_ in groups])
        axis.tick_params("x", rotation=35)
        axis.set_title(label, fontsize=9)
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
        _head(axis, mode)
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
    values = {
        mode: [walls[name][number].mean() for name in present] for number, mode in enumerate(MODES)
    }
    _bars(axes[0], values, [name.replace(" Wall", "") for name in present])
    axes[0].set(ylabel="mean amplitude")
    axes[0].legend(ncols=4, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
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
        values = {
            mode: [fall.amplitudes[number][column] for fall in falls]
            for number, mode in enumerate(MODES)
        }
        numbers = [
            next(name for name in fall.objects if name.startswith("Stalactite")).split(" ")[1]
            for fall in falls
        ]
        _bars(axis, values, numbers)
        axis.set_title(f"{'left' if side == 'L' else 'right'} leg", fontsize=9)
    axes[0].set(ylabel="amplitude that arrives")
    axes[1].legend(ncols=4, fontsize=8, frameon=False)
    return _png(figure)
