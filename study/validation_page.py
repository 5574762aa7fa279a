"""The page `docs/validation.md` and its picture, from the series of `validation`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from ..core.frozen import frozen
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
        "an energy balance describes averages over many modes, and a path has no resonance",
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

`make validate` (`haptic-tracing validate --out docs`) computes this page. What a comparison is worth stands under *kind*:

- **held out**: nothing in the model was chosen with it, and its numbers were read in their source or a transcription.
- **fit**: a number was fitted to some places; the others judge.
- **chosen**: a value of the model was chosen so; it proves nothing.
- **printed**: figures of a closed form or a textbook, computed again by the solver.
- **definition**: the same formula; shows that its factors are right.
- **shown**: no criterion, or a source that could not be read.

*As recalled*: the figure is known from the literature, but its document could not be opened.

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


WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 300, 50, 20, 20, 40
RED, BLUE, GREEN = "#d1495b", "#2e86ab", "#4f8a3d"


@frozen
class Axes:
    """A plot with a logarithmic x axis: its left and top corner in the picture, the ranges of its
    axes, their labels and ticks."""

    corner: tuple[float, float]
    across: tuple[float, float]
    up: tuple[float, float]
    labels: tuple[str, str]
    ticks: tuple[Sequence[float], Sequence[float]]
    size: tuple[float, float] = (400, 300)

    def x(self, value: float) -> float:
        low, high = self.across
        return self.corner[0] + self.size[0] * math.log(value / low) / math.log(high / low)

    def y(self, value: float) -> float:
        low, high = self.up
        return self.corner[1] + self.size[1] * (high - min(max(value, low), high)) / (high - low)

    def frame(self) -> str:
        """The grid with the numbers and names of the axes."""
        (left, top), (width, height) = self.corner, self.size
        parts = [
            f'<path d="M{left} {self.y(v):.1f}h{width}" stroke="#ddd"/>'
            f'<text x="{left - 6}" y="{self.y(v) + 4:.1f}" text-anchor="end">{v:g}</text>'
            for v in self.ticks[1]
        ]
        parts += [
            f'<path d="M{self.x(v):.1f} {top}v{height}" stroke="#eee"/>'
            f'<text x="{self.x(v):.1f}" y="{top + height + 16}" text-anchor="middle">{v:g}</text>'
            for v in self.ticks[0]
        ]
        middle = top + height / 2
        parts.append(
            f'<path d="M{left} {top}v{height}h{width}" fill="none" stroke="#333"/>'
            f'<text x="{left + width / 2}" y="{top + height + 34}" text-anchor="middle">'
            f"{self.labels[0]}</text>"
            f'<text x="{left - 40}" y="{middle}" text-anchor="middle" '
            f'transform="rotate(-90 {left - 40} {middle})">{self.labels[1]}</text>'
        )
        return "".join(parts)

    def line(self, points: Sequence[tuple[float, float]], colour: str, dash: str = "") -> str:
        path = "L".join(f"{self.x(a):.1f} {self.y(b):.1f}" for a, b in points)
        style = f' stroke-dasharray="{dash}"' if dash else ""
        return f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"{style}/>'

    def dots(self, series: Series, colour: str) -> str:
        """Published figures, hollow where they were used for a fit or as reference, with bars of
        their scatter."""
        parts = []
        for point in series.points:
            x, y = self.x(_place(point)), self.y(point.measured)
            if point.spread:
                ends = [self.y(point.measured + k * point.spread) for k in (1, -1)]
                parts.append(
                    f'<path d="M{x - 4:.1f} {ends[0]:.1f}h8m-4 0V{ends[1]:.1f}m-4 0h8" '
                    f'fill="none" stroke="{colour}"/>'
                )
            fill = colour if point.judged else "#fff"
            parts.append(
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{fill}" stroke="{colour}"/>'
            )
        return "".join(parts)


def _place(point: Point) -> float:
    """The distance or frequency of a figure."""
    return float(point.at.split(" ")[0])


def _model(series: Series) -> list[tuple[float, float]]:
    return [(_place(point), point.modelled) for point in series.points]


def picture() -> str:
    """Attenuation on the ground over distance, and from the ground into foundations over frequency,
    as SVG: published figures with their scatter as dots, the model as lines."""
    found = {series.name: series for series in (*ground(), *into_buildings())}
    far = Axes(
        (60, 34),
        (7.0, 90.0),
        (-45.0, 0.0),
        ("distance [m]", "level, first place of each series 0 [dB]"),
        ((10, 20, 40, 80), (0, -10, -20, -30, -40)),
    )
    into = Axes(
        (540, 34),
        (3.6, 90.0),
        (-18.0, 6.0),
        ("frequency [Hz]", "foundation relative to the ground [dB]"),
        ((4, 8, 16, 31.5, 63), (5, 0, -5, -10, -15)),
    )
    machines, hall = found["Construction machines"], found["Outside a machine hall"]
    soil = [found[f"The same by the library's soil at {f:g} Hz"] for f in HALL_FREQUENCIES]
    edges = [*_model(soil[0]), *reversed(_model(soil[-1]))]
    area = "L".join(f"{far.x(a):.1f} {far.y(b):.1f}" for a, b in edges)
    foundations = [found[f"Ground to foundation, {place}"] for place in FOUNDATIONS]
    legend = (
        (60, "dot", BLUE, "construction machines (FTA 0123), published"),
        (60, "line", BLUE, "model, body wave, absorption fitted to the hollow dots"),
        (60, "dot", RED, "outside a machine hall (DIN 4150-1, figure A.19), measured"),
        (60, "line", RED, "model, surface wave, absorption fitted to the hollow dots"),
        (60, "area", RED, "model, the library's soil at 30 to 50 Hz, nothing fitted"),
        (540, "bar", BLUE, "basement, mean and scatter over buildings (E DIN 45672-3)"),
        (540, "bar", GREEN, "ground floor, mean and scatter over buildings"),
        (540, "line", "#333", "model, soil touches concrete, by impedance, nothing fitted"),
        (540, "dash", "#333", "model, the default contact"),
    )
    rows = {60: 0, 540: 0}
    words = []
    for left, kind, colour, text in legend:
        y = 400 + 18 * rows[left]
        rows[left] += 1
        words.append(_sample(kind, left, y, colour))
        words.append(f'<text x="{left + 34}" y="{y + 4}">{text}</text>')
    return "\n".join(
        [
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 490" '
            'font-family="sans-serif" font-size="12">',
            '<rect width="960" height="490" fill="#fff"/>',
            '<text x="60" y="20" font-weight="bold">On the ground</text>',
            '<text x="540" y="20" font-weight="bold">From the ground into a house</text>',
            far.frame(),
            into.frame(),
            f'<path d="M{area}Z" fill="{RED}" opacity="0.25"/>',
            far.line(_model(machines), BLUE),
            far.line(_model(hall), RED),
            far.dots(machines, BLUE),
            far.dots(hall, RED),
            into.line(_model(foundations[0]), "#333"),
            into.line([(_place(point), 0.0) for point in foundations[0].points], "#333", "6 4"),
            *(
                into.dots(series, colour)
                for series, colour in zip(foundations, (BLUE, GREEN), strict=True)
            ),
            *words,
            "</svg>\n",
        ]
    )


def _sample(kind: str, x: float, y: float, colour: str) -> str:
    """A sample of a mark in the legend."""
    match kind:
        case "dot":
            return f'<circle cx="{x + 14}" cy="{y}" r="4" fill="{colour}" stroke="{colour}"/>'
        case "area":
            return f'<path d="M{x} {y - 6}h28v12h-28Z" fill="{colour}" opacity="0.25"/>'
        case "bar":
            return (
                f'<path d="M{x + 10} {y - 7}h8m-4 0v14m-4 0h8" fill="none" stroke="{colour}"/>'
                f'<circle cx="{x + 14}" cy="{y}" r="4" fill="{colour}"/>'
            )
    dash = ' stroke-dasharray="6 4"' if kind == "dash" else ""
    return f'<path d="M{x} {y}h28" stroke="{colour}" stroke-width="2"{dash}/>'


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
    limits with a line downwards; published resonances as bars on top."""

    def x(frequency: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * math.log(frequency / LOW) / math.log(HIGH / LOW)

    def y(level: float) -> float:
        return TOP + 30 + (HEIGHT - TOP - 30 - BOTTOM) * max(level, DEEPEST) / DEEPEST

    lines = [
        f'<path d="M{LEFT} {y(grid):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
        f'<text x="{LEFT - 8}" y="{y(grid) + 4:.1f}" text-anchor="end">{grid}</text>'
        for grid in (0, -10, -20, -30, -40, -50)
    ]
    lines += [
        f'<text x="{x(f):.1f}" y="{HEIGHT - 22}" text-anchor="middle">{f} Hz</text>'
        for f in (5, 10, 20, 50, 100, 200, 400)
    ]
    frequencies = [LOW * (HIGH / LOW) ** (k / 120) for k in range(121)]
    for number, (name, colour, level) in enumerate(BODY_CURVES):
        points = [(x(f), y(level(f))) for f in frequencies if level(f) > DEEPEST]
        path = "L".join(f"{a:.1f} {b:.1f}" for a, b in points)
        lines.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        lines.append(
            f'<text x="{LEFT + 8}" y="{y(-17) + 13 * number:.1f}" fill="{colour}">{name}</text>'
        )
    for place, _, low, high in RESONANCES:
        if place in _RANGES:
            row = TOP + 5 * (_RANGES[place] % 6)
            colour = BODY_CURVES[_RANGES[place]][1]
            lines.append(
                f'<path d="M{x(low) - 2:.1f} {row}H{x(high) + 2:.1f}" stroke="{colour}" '
                'stroke-width="4"/>'
            )
    for _, count, frequency, known in HANDLE:
        colour = BODY_CURVES[count - 1][1]
        lines.append(
            f'<circle cx="{x(frequency):.1f}" cy="{y(known):.1f}" r="4" fill="#fff" '
            f'stroke="{colour}" stroke-width="2"/>'
        )
        if count > 1:
            lines.append(
                f'<path d="M{x(frequency):.1f} {y(known) + 4:.1f}v14" stroke="{colour}" '
                'stroke-width="2"/>'
            )
    for frequency, known in HANDLE_TO_HEAD:
        if known > DEEPEST:
            lines.append(
                f'<circle cx="{x(frequency):.1f}" cy="{y(known):.1f}" r="4" '
                f'fill="{BODY_CURVES[8][1]}"/>'
            )
    lines.append(
        f'<path d="M{x(15):.1f} {y(-3.1):.1f}H{x(20):.1f}V{y(-6.02):.1f}H{x(15):.1f}Z" '
        f'fill="none" stroke="{BODY_CURVES[3][1]}"/>'
    )
    captions = (
        "dB against frequency. Lines: model. Bars on top: published resonances.",
        "Dots: published levels. Rings and box: the same, as recalled; with a tail: at most.",
    )
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT + 20}" '
            'font-family="sans-serif" font-size="12">',
            f'<rect width="{WIDTH}" height="{HEIGHT + 20}" fill="#fff"/>',
            *lines,
            *(
                f'<text x="{LEFT}" y="{HEIGHT - 4 + 15 * number}">{text}</text>'
                for number, text in enumerate(captions)
            ),
            "</svg>\n",
        ]
    )
