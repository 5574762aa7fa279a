"""The page `docs/validation.md` and its picture, from the series of `validation`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from io import StringIO
from typing import Any

from . import everyday
from .validation import (
    FOUNDATIONS,
    HALL_FREQUENCIES,
    HAND_ARM,
    HANDLE,
    HANDLE_TO_HEAD,
    HEAD,
    LEG,
    RESONANCES,
    TRUNK,
    Point,
    Series,
    all_series,
    body_level,
    ground,
    into_buildings,
    skin_level,
)

UNMODELLED = (
    (
        "Floors of houses",
        "+17 dB (concrete) and +22 dB (timber) at a floor's resonance, -5 dB well above (E DIN "
        "45672-3:2023, annex A)",
        "resonances are not modelled: a floor passes on what its material does, at every frequency",
    ),
    (
        "Peaks of a body at its resonances",
        "1.5 to 2 at head, wrist, ankle and knee (doi 10.1016/j.jsv.2010.02.001 as recalled, "
        "10.3390/app14209516)",
        "a part passes everything up to its resonance, then less and less: no gain exceeds 1",
    ),
    (
        "Transmission of a contact under load",
        "stiffness grows with the cube root of the force (Hertz)",
        "the function Pressing Force follows that law by the estimated force, but no published "
        "transmission was found to judge it",
    ),
    (
        "Rooms and beams with few modes",
        "peaks and gaps of 20 dB and more",
        "a path has no resonance",
    ),
)
"""Published effects, their figures, and why the model has none."""

GAPS = (
    ("Wrist, forearm and upper arm", "curves in Dong and others, Vibration 4 (2021) 482"),
    ("Seat to head", "data of 58 people, doi 10.3390/vibration6010012"),
    ("Feet to head, 1 to 50 Hz", "Garg and Ross, IEEE SMC-6 (1976) 102"),
    (
        "Skin, dB per cm by frequency",
        "figures of doi 10.1371/journal.pone.0031203 and sciadv.aaz1158",
    ),
    ("Ground classes", "Woods and Jedele (1985), Gutowski and Dym (1976): shown as recalled"),
    ("Surfaces and taps", "Cluster Haptic Texture Database, SENS3, RealImpact: recordings"),
)
"""Published measurements whose numbers could not be read here, and where they are."""

INTRODUCTION = """# Validation: the model beside what was measured

What the misses below mean for a designer:

1. Which listeners feel a thing, in which order, and what stands in the way, is right in all ten everyday scenes; their published levels are met within 10 dB.
2. Along the ground levels are within 7 dB of measured ones up to 76 m, by the paper's function they are not.
3. Floors, walls and rooms resonate, the model does not: at its resonance a timber floor shakes up to 22 dB more than is said here.
4. Where plates cross or branch, 11 to 14 dB more or less pass than is said here; set a rule of contacts where a building matters.
5. From a shaken hand to the head levels are 15 dB too high below 50 Hz and far too low above 100 Hz: put listeners where devices are.

What a comparison is worth stands under *kind*:

- **held out**: nothing in the model was chosen with it, and its numbers were read in their source or a transcription.
- **fit**: a number was fitted to some places; the others judge.
- **chosen**: a value of the model was chosen so; it proves nothing.
- **printed**: figures of a closed form or a textbook, computed again by the solver.
- **definition**: the same formula; shows that its factors are right.
- **shown**: no criterion, or a source that could not be read.

`make validate` computes this page. *As recalled*: the figure is known from the literature, but its document could not be opened.

Levels are amplitudes in decibels. Figures of standards come from transcriptions, named with each series. A figure agrees if its error is at most the
published scatter (the bars in the picture) or, without one, the limit.

![Attenuation on the ground, and from the ground into foundations, measured and modelled](pictures/validation.svg)

![Parts of a body, published and modelled](pictures/body.svg)

| series | kind | judged figures | largest error | limit | verdict | chosen with it |
|---|---|---|---|---|---|---|"""


def page() -> str:
    """The page as Markdown."""
    every = list(all_series())
    held = [series for series in every if series.uses is not None]
    agreeing = sum(series.verdict == "agrees" for series in held)
    lines = [
        INTRODUCTION,
        *(_summary(series) for series in every),
        "",
        "## Held out",
        "",
        f"{agreeing} of {len(held)} agree. A parameter fitted to one of them would stand in this "
        "line; what was seen while mending becomes a fit.",
        "",
        "| series | verdict | line | in |",
        "|---|---|---|---|",
        *(
            f"| {series.name} | {series.verdict} | `{series.uses[1]}` | `{series.uses[0]}` |"
            for series in held
            if series.uses is not None
        ),
        "",
        "Not here, because their numbers could not be read:",
        "",
        "| published | where |",
        "|---|---|",
        *(f"| {name} | {where} |" for name, where in GAPS),
    ]
    lines += [
        "",
        "## What the model can't say",
        "",
        "| published | figures | why the model has none |",
        "|---|---|---|",
    ]
    lines += [f"| {published} | {figures} | {why} |" for published, figures, why in UNMODELLED]
    lines += everyday.section()
    for series in every:
        lines += _section(series)
    return "\n".join(lines) + "\n"


def _summary(series: Series) -> str:
    judged = sum(point.judged for point in series.points)
    limit = "" if series.limit is None else _written(series, series.limit)
    spreads = [point.spread for point in series.points]
    if all(spreads):
        limit = f"scatter, {min(spreads):.1f} to {max(spreads):.1f} {series.unit}"
    return (
        f"| {series.name} | {series.kind} | {judged} | {_written(series, series.worst)} | "
        f"{limit} | {series.verdict} | {series.chosen} |"
    )


def _section(series: Series) -> Iterator[str]:
    yield from ("", f"## {series.name}", "")
    yield (
        ". ".join(
            text[:1].upper() + text[1:]
            for text in (
                series.source,
                series.conditions,
                series.remark,
                f"chosen with it: {series.chosen}",
            )
        )
        + "."
    )
    yield from ("", "| at | published | model | error |", "|---|---|---|---|")
    for point in series.points:
        error = _written(
            series, point.error / point.measured if series.unit == "relative" else point.error
        )
        yield (
            f"| {point.at} | {_number(point.measured)} | {_number(point.modelled)} | "
            f"{error}{'' if point.judged else NOT_JUDGED[series.kind]} |"
        )


NOT_JUDGED = {"fit": " (fitted)", "held out": " (reference)"}
"""What is said of a figure that isn't judged, by kind."""


def _number(value: float) -> str:
    return f"{value:.5g}" if abs(value) < 1 else f"{value:.2f}".rstrip("0").rstrip(".")


def _written(series: Series, error: float) -> str:
    if series.unit == "relative":
        return f"{100 * error:.3f} %"
    return f"{error:.0f} pairs" if series.unit == "pairs" else f"{error:.2f} {series.unit}"


BLUE, RED, GREEN, GREY = "#2e86ab", "#d1495b", "#4f8a3d", "#333333"


def _figure(columns: int, width: float) -> tuple[Any, Any]:
    """A figure with a row of ``columns`` axes, each with a logarithmic horizontal scale."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(width, 5.4), layout="constrained")
    axes = figure.subplots(1, columns, squeeze=False)[0]
    for axis in axes:
        axis.set_xscale("log")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(alpha=0.3)
    return figure, axes


def _svg(figure: Any, ticks: Sequence[Sequence[float]]) -> str:
    """The picture with a legend below each of its axes, which have ``ticks``; the same text in
    every run."""
    from matplotlib import rc_context

    for axis, places in zip(figure.axes, ticks, strict=True):
        axis.set_xticks(places, [f"{place:g}" for place in places])
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=len(figure.axes) % 2 + 1)
    file = StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "validation"}):
        figure.savefig(file, format="svg", metadata={"Date": None})
    return file.getvalue()


def _place(point: Point) -> float:
    """The distance or frequency of a figure."""
    return float(point.at.split(" ")[0])


def _draw(axis: Any, series: Series, colour: str, published: str, model: str = "") -> None:
    """Published figures with bars of their scatter, hollow where they were used for a fit or as
    reference, and the ``model`` as a line."""
    for judged, inside in ((True, colour), (False, "white")):
        points = [point for point in series.points if point.judged is judged]
        axis.errorbar(
            [_place(point) for point in points],
            [point.measured for point in points],
            [point.spread or math.nan for point in points],
            fmt="o",
            color=colour,
            markerfacecolor=inside,
            capsize=4,
            label=published if judged else None,
        )
    if model:
        axis.plot(*_curve(series), color=colour, label=model)


def _curve(series: Series) -> tuple[list[float], list[float]]:
    """The model over distance or frequency."""
    return [_place(point) for point in series.points], [point.modelled for point in series.points]


def picture() -> str:
    """Attenuation on the ground over distance, and from the ground into foundations over frequency,
    as SVG: published figures with their scatter as dots, the model as lines."""
    found = {series.name: series for series in (*ground(), *into_buildings())}
    figure, (far, into) = _figure(2, 12.0)
    far.set(
        title="On the ground",
        xlabel="distance [m]",
        ylabel="level, first place of each series 0 [dB]",
    )
    into.set(
        title="From the ground into a house",
        xlabel="frequency [Hz]",
        ylabel="foundation relative to the ground [dB]",
    )
    _draw(
        far,
        found["Construction machines"],
        BLUE,
        "construction machines (FTA 0123), published",
        "model, body wave, absorption fitted to the hollow dots",
    )
    _draw(
        far,
        found["Outside a machine hall"],
        RED,
        "outside a machine hall (DIN 4150-1, figure A.19), measured",
        "model, surface wave, absorption fitted to the hollow dots",
    )
    (places, least), *_, (_, most) = (
        _curve(found[f"The same by the library's soil at {f:g} Hz"]) for f in HALL_FREQUENCIES
    )
    soil = "model, the library's soil at 30 to 50 Hz, nothing fitted"
    far.fill_between(places, least, most, color=RED, alpha=0.25, label=soil)
    basement, ground_floor = (found[f"Ground to foundation, {place}"] for place in FOUNDATIONS)
    _draw(into, basement, BLUE, "basement, mean and scatter over buildings (E DIN 45672-3)")
    _draw(into, ground_floor, GREEN, "ground floor, mean and scatter over buildings")
    touching = "model, soil touches concrete, by impedance, nothing fitted"
    into.plot(*_curve(basement), color=GREY, label=touching)
    into.axhline(0.0, color=GREY, linestyle="--", label="model, the default contact")
    return _svg(figure, ((10, 20, 40, 80), (4, 8, 16, 31.5, 63)))


BODY_CURVES: tuple[tuple[str, str, Callable[[float], float]], ...] = (
    ("wrist", "#2e86ab", lambda f: body_level(HAND_ARM[:1], f)),
    ("elbow", "#d1495b", lambda f: body_level(HAND_ARM[:2], f)),
    ("shoulder", "#edae49", lambda f: body_level(HAND_ARM, f)),
    ("head, from the seat", "#66a182", lambda f: body_level(TRUNK, f)),
    ("ankle", "#8d6a9f", lambda f: body_level(LEG[:1], f)),
    ("knee", "#5c5c5c", lambda f: body_level(LEG[:2], f)),
    ("toes", "#1b7f5c", lambda f: body_level((("toes", 0.05),), f)),
    ("midfoot", "#c2185b", lambda f: body_level((("midfoot", 0.05),), f)),
    ("head, from the handle", "#3949ab", lambda f: body_level(HEAD, f)),
    ("skin, 4 cm", "#b07d62", lambda f: skin_level(f, 0.04)),
    ("skin, 8 cm", "#d8b192", lambda f: skin_level(f, 0.08)),
)
"""Name, colour and level [dB] over frequency [Hz]."""
LOW, HIGH, DEEPEST = 4.0, 500.0, -50.0
_RANGES = {
    "wrist, as recalled": 0,
    "elbow": 1,
    "head and trunk, as recalled": 3,
    "ankle": 4,
    "knee": 5,
    "toes": 6,
    "midfoot": 7,
}
"""Curve of the places of `RESONANCES` that have one."""


def body_picture() -> str:
    """Levels at parts of a body over frequency: the model as lines; published levels as dots, upper
    limits with an arrow downwards; published resonances as bars on top."""
    figure, (axis,) = _figure(1, 9.0)
    frequencies = [LOW * (HIGH / LOW) ** (k / 120) for k in range(121)]
    for name, colour, level in BODY_CURVES:
        axis.plot(frequencies, list(map(level, frequencies)), color=colour, label=name)
    for place, _, low, high in RESONANCES:
        if place in _RANGES:
            height, colour = 2 + _RANGES[place], BODY_CURVES[_RANGES[place]][1]
            axis.plot([low / 1.02, high * 1.02], [height, height], color=colour, linewidth=4)
    for _, count, frequency, known in HANDLE:
        axis.errorbar(
            frequency,
            known,
            3.0 if count > 1 else math.nan,
            fmt="o",
            color=BODY_CURVES[count - 1][1],
            markerfacecolor="white",
            uplims=True,
        )
    axis.plot(*zip(*HANDLE_TO_HEAD, strict=True), "o", color=BODY_CURVES[8][1])
    axis.plot([15, 20, 20, 15, 15], [-3.1, -3.1, -6.02, -6.02, -3.1], color=BODY_CURVES[3][1])
    axis.set(
        title="Lines: model. Bars on top: published resonances. Dots: published levels.\n"
        "Rings and box: the same, as recalled; with an arrow: at most.",
        xlabel="frequency [Hz]",
        ylabel="level [dB]",
        xlim=(LOW, HIGH),
        ylim=(DEEPEST, 11),
    )
    return _svg(figure, ((5, 10, 20, 50, 100, 200, 400),))
