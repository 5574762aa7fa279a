"""What accuracy costs with the default strategy: level errors in decibels against run time.

    python -m benchmarks.bench_accuracy [--bodies 30 100 300 1000 3000 10000] [--no-blender]

**Propagation.** Boxes of five materials in a pile on soil, measured and in bands, with contacts by
impedance; two sources with tones, two with impact templates, ten listeners. The most exact way
takes the best path in each of the six frequency bands by itself; compared are the default, which
takes that of the band in which a source is strong, and one path for all sources. A level is that of
the amplitude that arrives from one source at one listener [dB of full scale]; what is below the
lowest threshold of feeling counts as if it were at the threshold. Times are those of graph and
propagation together, best of some runs, measured in turns.

**Time.** Spheres that Blender drops from 0.3 to 2.5 m, against the energies m g h of free fall, and
a vibrating sled that passes a listener at 3 m/s, against the gain at every instant in closed form;
by frame rate and substeps of the simulation.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.arrays import FloatArray
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable
from haptic_tracing.core.perception import BEST_LEVEL
from haptic_tracing.core.propagation import Propagation, propagate
from haptic_tracing.core.render.arrival import arriving
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.functions import Impedance
from haptic_tracing.core.scene.measured import physical
from haptic_tracing.core.scene.values import Settings
from haptic_tracing.core.signals import Sine, impact_template

from .families import Family, pile
from .report import publish, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BODIES = (30, 100, 300, 1000, 3000, 10_000)
SIGNALS = (
    Sine(60.0),
    impact_template("stone", "soil"),
    Sine(250.0),
    impact_template("wood", "stone"),
)
MATERIALS = ("softwood", "stone", "rubber", "plastic", "steel")
RADIUS = 0.1
DRAWN = 1e-3
"""Error [dB] as which smaller ones are drawn."""
LEAST = 0.2
"""Seconds for which each setting runs at least, in the mean."""
RATES, SUBSTEPS = (24, 30, 60, 120), (2, 10, 40)


@dataclass(frozen=True, slots=True)
class Point:
    """One setting: its run time relative to the default, and of the errors of its levels [dB] the
    largest and the root mean square."""

    bodies: int
    dial: str
    setting: str
    ratio: float
    milliseconds: float
    largest: float
    rms: float

    @classmethod
    def of(
        cls, bodies: int, dial: str, setting: str, seconds: tuple[float, float], error: FloatArray
    ) -> Point:
        """``seconds``: of this setting, and of the default."""
        rms = float(np.sqrt(np.mean(error**2)))
        return cls(
            bodies,
            dial,
            setting,
            seconds[0] / seconds[1],
            1000 * seconds[0],
            float(np.abs(error).max()),
            rms,
        )


def measured_pile(count: int) -> Family:
    """A pile of measured materials in bands, with contacts by impedance."""
    plain = pile(count)
    side = float(np.ceil(np.sqrt(count))) * 0.6
    boxes = [physical(name, (0.5, 0.5, 0.5)) for name in MATERIALS]
    functions = [
        physical("soil", (side, side, 2.0)),
        *(boxes[k % len(boxes)] for k in range(count)),
    ]
    objects = [
        replace(item, propagation=function)
        for item, function in zip(plain.table.objects, functions, strict=True)
    ]
    sources = tuple(
        replace(item, signal=signal) for item, signal in zip(plain.sources, SIGNALS, strict=True)
    )
    listeners = tuple(replace(item, radius=RADIUS) for item in plain.listeners)
    contacts = replace(plain.contacts, transmissions=(Impedance(),))
    return replace(
        plain,
        table=ObjectTable.of(objects, plain.table.epsilon),
        contacts=contacts,
        sources=sources,
        listeners=listeners,
    )


def levels(amplitude: FloatArray) -> FloatArray:
    """Levels [dB], those below the threshold of feeling at the threshold."""
    with np.errstate(divide="ignore"):
        return np.maximum(20 * np.log10(amplitude), BEST_LEVEL)


def in_turns(runs: Sequence[Callable[[], object]], least: float) -> list[float]:
    """Seconds of processor time of each of ``runs``, the best of several turns, each with one run
    for warming up, of at least ``least`` seconds for each in the mean."""
    best, begun = [np.inf] * len(runs), time.process_time()
    while not np.isfinite(best).all() or time.process_time() - begun < least * len(runs):
        for number, run in enumerate(runs):
            for _ in range(3):
                started = time.process_time()
                run()
                best[number] = min(best[number], time.process_time() - started)
    return best


def exact_arrivals(family: Family) -> FloatArray:
    """Amplitudes (s, l) with the best path of every band."""
    tones = [
        tuple(replace(item, signal=Sine(frequency)) for item in family.sources)
        for frequency in BAND_CENTRES
    ]
    found = [propagate(replace(family, sources=sources).graph(), Settings()) for sources in tones]
    assert all(item.band_gain is not None for item in found)
    bands = np.stack(
        [item.band_gain[..., k] for k, item in enumerate(found) if item.band_gain is not None],
        axis=-1,
    )
    return arriving(family.sources, replace(found[0], band_gain=bands))


@dataclass(frozen=True, slots=True)
class Way:
    """One setting of one dial: how it computes a frame."""

    dial: str
    setting: str
    compute: Callable[[], Propagation]


def ways(family: Family) -> Iterator[Way]:
    """The default, and the settings that are compared with it."""

    def way(
        dial: str,
        setting: str,
        prepared: Callable[[HapticGraph], HapticGraph] = lambda graph: graph,
    ) -> Way:
        return Way(dial, setting, lambda: propagate(prepared(family.graph()), Settings()))

    def without_bands(graph: HapticGraph) -> HapticGraph:
        return replace(graph, sources=tuple(replace(source, band=0) for source in graph.sources))

    yield way("default", "")
    yield way("bands", "one path for all", without_bands)


def propagation_points(count: int, least: float = LEAST) -> list[Point]:
    """Every setting of propagation in a pile of ``count`` boxes; ``least`` as in `in_turns`."""
    family = measured_pile(count)
    chosen = list(ways(family))
    seconds = in_turns([way.compute for way in chosen], least)
    exact = levels(exact_arrivals(family))
    return [
        Point.of(
            count,
            way.dial,
            way.setting,
            (used, seconds[0]),
            levels(arriving(family.sources, way.compute())) - exact,
        )
        for way, used in zip(chosen, seconds, strict=True)
    ]


DIALS = {"default": ("#1f5fa8", "o"), "bands": ("#b08900", "D")}


def draw(points: Sequence[Point], times: Sequence[FrameRow]) -> Figure:
    """Error against time, propagation of the smallest and the largest pile, the default by number
    of bodies, and frame rates."""
    from matplotlib.figure import Figure

    counts = sorted({point.bodies for point in points})
    figure = Figure(figsize=(13, 8.5), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    for axis, count in zip(axes, (counts[min(1, len(counts) - 1)], counts[-1]), strict=False):
        for dial, (colour, style) in DIALS.items():
            own = [point for point in points if point.bodies == count and point.dial == dial]
            if own:
                axis.plot(
                    [p.ratio for p in own],
                    [max(p.rms, DRAWN) for p in own],
                    style,
                    color=colour,
                    label=dial,
                    markersize=5,
                )
            for point in own:
                if point.rms > 0.02:
                    place = point.ratio, max(point.rms, DRAWN)
                    axis.annotate(
                        point.setting,
                        place,
                        (5, -3),
                        textcoords="offset points",
                        fontsize=8,
                        color=colour,
                    )
        axis.axvline(1, color="#999999", linewidth=0.7, linestyle=":")
        axis.set(
            title=f"{count:,} bodies",
            xlabel="run time, relative to the default",
            ylabel="error of levels, RMS [dB]",
        )
        axis.set(yscale="log", ylim=(DRAWN / 2, 60))
        axis.grid(alpha=0.25)
        axis.legend(frameon=False)
    for dial, setting, colour in (
        ("default", "", "black"),
        ("threshold", "0", "#1f5fa8"),
        ("threshold", "0.01", "#7fb0e0"),
    ):
        own = [point for point in points if (point.dial, point.setting) == (dial, setting)]
        axes[2].plot(
            [p.bodies for p in own],
            [p.milliseconds for p in own],
            "o-",
            color=colour,
            label=f"{dial} {setting}".strip(),
        )
    axes[2].set(
        xscale="log",
        yscale="log",
        title="Run time by number of bodies",
        xlabel="bodies",
        ylabel="graph and propagation [ms]",
    )
    for substeps in sorted({row.substeps for row in times}):
        rows = [row for row in times if row.substeps == substeps]
        axes[3].plot(
            [row.rate for row in rows],
            [row.energy for row in rows],
            "o-",
            label=f"impacts, {substeps} substeps",
        )
    rows = [row for row in times if row.substeps == SUBSTEPS[1]]
    axes[3].plot(
        [row.rate for row in rows],
        [row.passing for row in rows],
        "k^--",
        label="sled that passes at 3 m/s",
    )
    axes[3].set(
        title="Frame rate and substeps",
        xlabel="frames a second",
        ylabel="largest error of a level [dB]",
        yscale="log",
    )
    for axis in axes[2:]:
        axis.grid(alpha=0.25)
        axis.legend(frameon=False)
    return figure


@dataclass(frozen=True, slots=True)
class FrameRow:
    """A frame rate with so many substeps: impacts missed and invented; the largest errors of an
    impact's level [dB] and time [ms], and of the passing sled's level [dB]; and milliseconds that
    Blender and tracing take for a second of the drops."""

    rate: int
    substeps: int
    missed: int
    invented: int
    energy: float
    late: float
    passing: float
    blender: float
    tracing: float


def text_of(points: Sequence[Point], times: Sequence[FrameRow]) -> str:
    """Both tables."""
    counts = sorted({point.bodies for point in points})
    rows = []
    for dial, setting in dict.fromkeys((point.dial, point.setting) for point in points):
        own = {
            point.bodies: point
            for point in points
            if (point.dial, point.setting) == (dial, setting)
        }
        cells = [
            f"{own[n].rms:.2g} ({own[n].largest:.2g}), {own[n].ratio:.2f}" if n in own else "-"
            for n in counts
        ]
        rows.append((f"{dial} {setting}".strip(), *cells))
    default = [f"{point.milliseconds:.2f} ms" for point in points if point.dial == "default"]
    text = (
        "Errors of levels in dB: root mean square (largest), and run time relative to the "
        "default.\n\n"
        + table(
            ("bodies", *(f"{count:,}" for count in counts)),
            [*rows, ("run time of the default", *default)],
        )
    )
    if times:
        heading = (
            "frames a second",
            "substeps",
            "missed",
            "invented",
            "impact level [dB]",
            "impact time [ms]",
            "passing sled [dB]",
        )
        lines = [
            (
                str(r.rate),
                str(r.substeps),
                str(r.missed),
                str(r.invented),
                f"{r.energy:.2g}",
                f"{r.late:.2g}",
                f"{r.passing:.2g}",
                f"{r.blender:.0f}",
                f"{r.tracing:.0f}",
            )
            for r in times
        ]
        text += "\n\n" + table((*heading, "Blender [ms/s]", "tracing [ms/s]"), lines)
    return text


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", nargs="+", type=int, default=BODIES)
    parser.add_argument("--no-blender", action="store_true")
    chosen = parser.parse_args()
    points = [point for count in chosen.bodies for point in propagation_points(count)]
    times: list[FrameRow] = []
    if not chosen.no_blender:
        from .timelines import frame_row

        times = [FrameRow(*frame_row(rate, substeps)) for rate in RATES for substeps in SUBSTEPS]
    data = {
        "propagation": [asdict(point) for point in points],
        "frames": [asdict(row) for row in times],
    }
    publish(
        "accuracy",
        "Run time against error of levels",
        text_of(points, times),
        data,
        draw(points, times),
    )


if __name__ == "__main__":
    main()
