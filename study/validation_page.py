"""The page `docs/validation.md` and its picture, from the series of `validation`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from .validation import (
    HAND_ARM,
    HANDLE,
    HANDLE_TO_HEAD,
    HEAD,
    LEG,
    RESONANCES,
    TRUNK,
    Series,
    all_series,
    body_level,
    ground,
    skin_level,
)

UNMODELLED = (
    (
        "Floors and foundations of houses",
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

INTRODUCTION = """# Validation: the model beside what was measured

`haptic-tracing validate --out docs` computes this page. What a comparison is worth stands under *kind*:

- **validation**: nothing was fitted.
- **fit**: one number was fitted to some places; the others judge.
- **printed**: figures of a closed form or a textbook, computed again by the solver.
- **definition**: the same formula; shows that its factors are right.
- **chosen**: the value was chosen so; it proves nothing.

*As recalled*: the figure is known from the literature, but its document could not be opened.

Levels are amplitudes in decibels. Figures of standards come from transcriptions, named with each series.

![Attenuation on the ground, measured and modelled](pictures/validation.svg)

![Parts of a body, published and modelled](pictures/body.svg)

| series | kind | judged figures | largest error | limit | verdict |
|---|---|---|---|---|---|"""


def page() -> str:
    """The page as Markdown."""
    every = list(all_series())
    lines = [INTRODUCTION, *(_summary(series) for series in every)]
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
    return (
        f"| {series.name} | {series.kind} | {judged} | {_written(series, series.worst)} | "
        f"{limit} | {series.verdict} |"
    )


def _section(series: Series) -> Iterator[str]:
    yield from ("", f"## {series.name}", "")
    yield (
        ". ".join(
            text[:1].upper() + text[1:]
            for text in (series.source, series.conditions, series.remark)
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
            f"{error}{'' if point.judged else ' (fitted)'} |"
        )


def _number(value: float) -> str:
    return f"{value:.5g}" if abs(value) < 1 else f"{value:.2f}".rstrip("0").rstrip(".")


def _written(series: Series, error: float) -> str:
    if series.unit == "relative":
        return f"{100 * error:.3f} %"
    return f"{error:.0f} pairs" if series.unit == "pairs" else f"{error:.2f} {series.unit}"


WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 300, 50, 20, 20, 40
NEAREST, FARTHEST, LOWEST = 7.0, 80.0, -40.0
COLOURS = ("#2e86ab", "#d1495b")


def picture() -> str:
    """The first two ground series as SVG: published places as dots, the model as lines."""
    levels = [_level_line(level) for level in (0, -10, -20, -30, -40)]
    places = [
        f'<text x="{_x(r):.1f}" y="{HEIGHT - 22}" text-anchor="middle">{r} m</text>'
        for r in (10, 20, 40, 80)
    ]
    curves = [_curve(k, series) for k, series in enumerate(list(ground())[:2])]
    caption = (
        "dB against distance. Lines: model. Dots: published; hollow ones were used to fit "
        "the model."
    )
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
            'font-family="sans-serif" font-size="12">',
            f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
            *levels,
            *places,
            *curves,
            f'<text x="{LEFT}" y="{HEIGHT - 6}">{caption}</text>',
            "</svg>\n",
        ]
    )


def _x(distance: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * math.log(distance / NEAREST) / math.log(
        FARTHEST / NEAREST
    )


def _y(level: float) -> float:
    return TOP + (HEIGHT - TOP - BOTTOM) * level / LOWEST


def _level_line(level: float) -> str:
    line = f'<path d="M{LEFT} {_y(level):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
    return f'{line}<text x="{LEFT - 8}" y="{_y(level) + 4:.1f}" text-anchor="end">{level}</text>'


def _curve(number: int, series: Series) -> str:
    colour = COLOURS[number]
    at: Sequence[float] = [float(point.at.removesuffix(" m")) for point in series.points]
    line = "L".join(
        f"{_x(r):.1f} {_y(point.modelled):.1f}" for r, point in zip(at, series.points, strict=True)
    )
    dots = [
        f'<circle cx="{_x(r):.1f}" cy="{_y(point.measured):.1f}" r="4" '
        f'fill="{colour if point.judged else "#fff"}" stroke="{colour}"/>'
        for r, point in zip(at, series.points, strict=True)
    ]
    name = (
        f'<text x="{WIDTH - 220}" y="{TOP + 16 * (number + 1)}" '
        f'fill="{colour}">{series.name}</text>'
    )
    return "".join(
        [f'<path d="M{line}" fill="none" stroke="{colour}" stroke-width="2"/>', *dots, name]
    )


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
