"""The report as a self-contained HTML file."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ..core.formats.io.atomic import write_bytes
from ..core.forms import JsonObject
from ..core.render import lane
from .body_map import body_map, shade_numbers, shades
from .checks import FINDINGS, LIMITS, Check, felt_anywhere, measured_checks
from .measures import CLASS_WIDTH, dynamic_range, felt_count, patterns, spatial_spread, variety
from .plots import OPENING
from .rendition import MODES, TITLES, Ride
from .sensitivity import CHOSEN, Variation
from .side_by_side import TITLES as WAYS
from .side_by_side import felt_verdict, numbers, reasons, sensations, wall_verdict, walls_apart

NONE: Mapping[str, Ride] = MappingProxyType({})
MEASURES = (
    "felt",
    "most felt",
    "spread [m]",
    "range [dB]",
    "variety [bits]",
    "patterns [bits]",
)


def measures_of(ride: Ride) -> list[JsonObject]:
    """A row per section (and one for all of them) and mode, with the `MEASURES`."""
    parts = [(title, first, last) for _, title, first, last in ride.sections]
    if len(parts) > 1:
        parts.append(("All", int(ride.frames[0]), int(ride.frames[-1])))
    rows = []
    for title, first, last in parts:
        frames = ride.rows(first, last)
        for mode in MODES:
            rendition, margins = ride.renditions[mode], ride.margins(mode, first, last)
            count = felt_count(rendition.margin[frames])
            felt = count > 0
            spread = spatial_spread(rendition.rms[frames], ride.positions)
            values = (
                float(count[felt].mean()) if felt.any() else 0.0,
                int(count.max(initial=0)),
                float(spread[felt].mean()) if felt.any() else 0.0,
                dynamic_range(margins),
                variety(margins),
                patterns(margins),
            )
            rows.append(
                {"section": title, "mode": str(mode), **dict(zip(MEASURES, values, strict=True))}
            )
    return rows


def write_numbers(
    path: Path, ride: Ride, checks: Sequence[Check], rides: Mapping[str, Ride] = NONE
) -> None:
    """Write checks, measures and impacts, and what is measured on ``rides`` by way, as JSON."""
    document = {
        "frames": [int(ride.frames[0]), int(ride.frames[-1])],
        "frame_rate": ride.frame_rate,
        "listeners": list(ride.listeners),
        "checks": [
            {
                "name": c.name,
                "by_definition": c.by_definition,
                "statement": c.statement,
                "measured": c.measured,
                "holds": c.holds,
            }
            for c in checks
        ],
        "measures": measures_of(ride),
        "materials": numbers(rides),
        "impacts": [
            {
                "frame": s.frame,
                "objects": list(s.objects),
                "amplitude": s.amplitude,
                "amplitudes": {
                    str(mode): s.amplitudes[number].round(6).tolist()
                    for number, mode in enumerate(MODES)
                },
            }
            for s in ride.soundings
            if s.began
        ],
    }
    write_bytes(path, (json.dumps(document, indent=1, allow_nan=False) + "\n").encode())


def write_report(
    path: Path,
    ride: Ride,
    checks: Sequence[Check],
    figures: Sequence[tuple[str, str, bytes]],
    pictures: Mapping[int, bytes],
    notes: Sequence[str] = (),
    varied: Sequence[tuple[Variation, Ride]] = (),
    rides: Mapping[str, Ride] = NONE,
) -> None:
    """Write the report as a page.

    Args:
        path: of the page.
        ride: what it is about.
        checks: what was checked, and the results.
        figures: title, caption and PNG.
        pictures: PNG by frame.
        notes: missing parts, and why.
        varied: the ride under variations.
        rides: the ride with other ways to choose materials, by way.
    """
    body = [
        "<h1>The study's ride, rendered in four ways</h1>",
        f"<p>Frames {ride.frames[0]} to {ride.frames[-1]} of the mine ride "
        f"({len(ride.frames) / ride.frame_rate:.1f} s). "
        "Contacts, impacts and sources are the same in all four; what differs is how they reach "
        "the ten actuators. <b>Felt</b> means above the threshold of feeling.</p>",
        "<dl class=modes>",
        *(f"<dt>{mode}</dt><dd>{escape(TITLES[mode])}</dd>" for mode in MODES),
        "</dl>",
        *(f"<p class=note>{escape(note)}</p>" for note in notes),
        *map(_figure, figures[:OPENING]),
        "<h2>The ride</h2>",
        _player(ride, pictures),
        "<h2>Over time</h2>",
        _lanes(ride),
        "<h2>Moments</h2>",
        _strip(ride, pictures),
        *map(_figure, figures[OPENING:]),
        "<h2>By measurement: what differs between the modes</h2>",
        _checks_table([check for check in checks if not check.by_definition]),
        "<h2>By definition: the modes do what they should</h2>",
        _checks_table([check for check in checks if check.by_definition]),
        "<h2>Measures</h2>",
        _measures_table(ride),
        "<p class=note>felt: mean number of actuators at which anything is felt while any is; "
        "spread: how far over the body the "
        "vibration reaches; range: from the 5th to the 95th percentile of the margins that "
        "effects have where they are felt; variety: "
        f"entropy of those margins in classes of {CLASS_WIDTH:g} dB, the highest typical "
        "difference threshold; patterns: entropy of the actuators' margins "
        "beside the strongest.</p>",
        "<p>Gains that bring the mean energy felt in each mode to that of HT: "
        f"{', '.join(f'{mode} {ride.equalising_gain(mode):+.1f} dB' for mode in MODES[1:])}.</p>",
        *_materials({"paper": ride, **rides}),
        *_sensitivity(ride, varied),
        "<h2>Not reproducible here: what people said</h2>",
        "<p>The paper's results are ratings by 40 people. No rendering can compute them; they "
        "stand here as published.</p>",
        _table(("", "The paper"), FINDINGS),
        "<h2>Limits</h2>",
        f"<ul>{''.join(f'<li>{escape(limit)}</li>' for limit in LIMITS)}</ul>",
    ]
    head = (
        "<meta charset=utf-8><title>Haptic Tracing: "
        f"study</title><style>{_text('report.css')}</style>"
    )
    write_bytes(
        path,
        "<!doctype html><html "
        f"lang=en><head>{head}</head><body>{''.join(body)}</body></html>\n".encode(),
    )


def _lanes(ride: Ride) -> str:
    """The level of every listener over the ride, by mode."""
    tracks = [ride.renditions[mode].tracks for mode in MODES]
    rows: list[list[Cell]] = [
        [
            name,
            *(
                ("", lane.svg(one.row(number).read(0, one.count), one.sample_rate))
                for one in tracks
            ),
        ]
        for number, name in enumerate(ride.listeners)
    ]
    return _table(("", *MODES), rows, "lanes") + (
        f"<p class=note>Level of the last quarter second from {lane.FLOOR:g} to 0 dB of full "
        f"scale, lines at {' and '.join(f'{level:g}' for level in lane.GRID)} dB; dashed: the "
        "threshold of feeling; filled: what is felt.</p>"
    )


def _figure(figure: tuple[str, str, bytes]) -> str:
    title, caption, png = figure
    return (
        f"<h2>{escape(title)}</h2><figure><img src='{_data(png)}' "
        f"alt=''><figcaption>{escape(caption)}</figcaption></figure>"
    )


Cell = str | tuple[str, str]
"""A cell of a table: its text, or its class and HTML."""


def _table(heads: Sequence[str], rows: Iterable[Sequence[Cell]], kind: str = "") -> str:
    """An HTML table of the class ``kind``."""
    head = "".join(f"<th>{escape(name)}" for name in heads)
    lines = "".join(f"<tr>{''.join(map(_cell, cells))}</tr>" for cells in rows)
    return f'<table class="{kind}"><tr>{head}</tr>{lines}</table>'


def _cell(cell: Cell) -> str:
    kind, html = ("", escape(cell)) if isinstance(cell, str) else cell
    return f'<td class="{kind}">{html}'


def _checks_table(checks: Sequence[Check]) -> str:
    sign = {True: ("yes", "holds"), False: ("no", "does not hold"), None: ("", "no data")}
    return _table(
        ("", "", "Statement", "Measured"),
        (
            (sign[c.holds], ("", f"<b>{escape(c.name)}</b>"), c.statement, c.measured)
            for c in checks
        ),
    )


def _materials(rides: Mapping[str, Ride]) -> list[str]:
    """The ride with different materials: checks, walls and levels of each variant."""
    ways = [WAYS[way] for way in rides]
    sign = {True: "", False: "does not hold: ", None: ""}
    columns = [measured_checks(ride) for ride in rides.values()]
    checks = [
        (
            ("", f"<b>{escape(row[0].name)}</b><br>{escape(row[0].statement)}"),
            *(
                ("" if c.holds is not False else "fails", escape(sign[c.holds] + c.measured))
                for c in row
            ),
        )
        for row in zip(*columns, strict=True)
    ]
    felt = [[felt_verdict(levels) for _, levels in sensations(ride)] for ride in rides.values()]
    walls = [
        [wall_verdict(apart, felt_anywhere(ride)[1]) for _, apart in walls_apart(ride)]
        for ride in rides.values()
    ]
    first = next(iter(rides.values()))
    sections = [title for title, _ in sensations(first)]
    pairs = [pair for pair, _ in walls_apart(first)]
    return [
        "<h2>By material: the paper's function and measured materials</h2>",
        "<p>The same ride with the library's κ and ρ, with measured loss factors, speeds and "
        "impedances of the same materials. Blows play the templates of what strikes what. No "
        "material was tuned; what is said here may turn out either way.</p>",
        "<p>What is felt: the strongest actuator above the threshold of feeling, and at how many "
        "of them anything is:</p>",
        _table(("Section", *ways), zip(sections, *felt, strict=True)),
        "<p>Walls of different materials, where they are felt (most: three of four people "
        "notice; few: one of four):</p>",
        _table(("Walls", *ways), zip(pairs, *walls, strict=True)),
        "<p>The checks by measurement:</p>",
        _table(("Statement", *ways), checks),
        "<p>Why:</p>",
        f"<ul>{''.join(f'<li>{escape(reason)}</li>' for reason in reasons())}</ul>",
    ]


def _sensitivity(ride: Ride, varied: Sequence[tuple[Variation, Ride]]) -> list[str]:
    """The values of the materials, the checks by measurement under each variation, and levels by
    strategy."""
    if not varied:
        return []
    names = [check.name for check in measured_checks(ride)]
    sign = {True: ("yes", "yes"), False: ("no", "no"), None: ("", "-")}
    rows = [("as it is", "", ride), *((one.name, one.label, other) for one, other in varied)]
    lines: list[tuple[Cell, ...]] = [
        (name, label, *(sign[check.holds] for check in measured_checks(other)))
        for name, label, other in rows
    ]
    chosen = [
        (
            item.title,
            f"κ {item.kappa:g}, ρ {item.rho:g}: K = {item.k:.2f}, {20 * np.log10(item.k):.1f} dB",
        )
        for item in CHOSEN
    ]
    return [
        "<h2>Sensitivity</h2>",
        "<p>No material was tuned for this ride. Those of the library are chosen by design, so "
        "that neighbours differ:</p>",
        _table(("Material", "Value"), chosen),
        "<p>Which checks by measurement hold where a material takes half or double as many "
        "decibels, with other values of what was arranged, and by strategy:</p>",
        _table(("Varied", "To", *names), lines, "numbers"),
        "<p>Levels at the listeners over the whole range in decibels of full scale:</p>",
        _levels_table(ride, varied),
    ]


def _levels_table(ride: Ride, varied: Sequence[tuple[Variation, Ride]]) -> str:
    rows = [
        ("best path, the default", ride),
        *(
            (variation.label, other)
            for variation, other in varied
            if variation.strategy is not None
        ),
    ]
    lines = []
    for label, other in rows:
        with np.errstate(divide="ignore"):
            levels = 10 * np.log10((other.renditions[MODES[0]].rms ** 2).mean(axis=0))
        lines.append([label, *(f"{level:.1f}" for level in levels)])
    return _table(("Strategy", *ride.listeners), lines, "numbers")


def _measures_table(ride: Ride) -> str:
    rows = [
        (
            row["section"] if row["mode"] == MODES[0] else "",
            row["mode"],
            *(f"{row[name]:.{0 if isinstance(row[name], int) else 2}f}" for name in MEASURES),
        )
        for row in measures_of(ride)
    ]
    return _table(("Section", "Mode", *MEASURES), rows, "numbers measures")


def _strip(ride: Ride, pictures: Mapping[int, bytes]) -> str:
    """The liveliest frame of every section, or those that there are pictures of: picture and body
    maps."""
    rows: list[Sequence[Cell]] = []
    for _, title, first, last in ride.sections:
        chosen = [frame for frame in sorted(pictures) if first <= frame <= last] or [
            _liveliest(ride, first, last)
        ]
        for frame in chosen:
            row = int(np.searchsorted(ride.frames, frame))
            maps = [
                ("", body_map(ride.listeners, ride.renditions[mode].peak[row])) for mode in MODES
            ]
            picture = (
                f"<img src='{_data(pictures[frame])}' alt='frame {frame}'>"
                if frame in pictures
                else ""
            )
            seconds = f"{(frame - 1) / ride.frame_rate:.1f} s, frame {frame}"
            place = f"<b>{escape(title)}</b><br><small>{seconds}</small>"
            rows.append((("", place), ("picture", picture), *maps))
    return _table(("", "", *MODES), rows, "strip") + _legend()


def _liveliest(ride: Ride, first: int, last: int) -> int:
    rows = ride.rows(first, last)
    return int(ride.frames[rows][ride.renditions[MODES[0]].peak[rows].sum(axis=1).argmax()])


def _legend() -> str:
    stops = ",".join(shades()[1::9])
    bar = f"<span style='background:linear-gradient(90deg,{stops})'></span>"
    return (
        f"<p class=legend>-46 dB {bar} full scale, peak of the frame; bodies seen from behind</p>"
    )


def _player(ride: Ride, pictures: Mapping[int, bytes]) -> str:
    """The body maps of all modes, moving; the nearest earlier picture of the ride beside them."""
    levels = np.stack([shade_numbers(ride.renditions[mode].peak) for mode in MODES], axis=1)
    data = {
        "first": int(ride.frames[0]),
        "rate": ride.frame_rate,
        "count": len(ride.frames),
        "listeners": len(ride.listeners),
        "sections": [[title, first] for _, title, first, _ in ride.sections],
        "pictures": {str(frame): _data(png) for frame, png in sorted(pictures.items())},
        "shades": shades(),
        "levels": base64.b64encode(levels.tobytes()).decode(),
    }
    maps = "".join(
        f"<div class=map data-mode={number}><b>{mode}</b>{body_map(ride.listeners)}</div>"
        for number, mode in enumerate(MODES)
    )
    # "<" could end the script.
    text = json.dumps(data).replace("<", "\\u003c")
    return (
        f"<div id=player><img id=view alt=''>{maps}<div id=controls><button id=play>Play</button>"
        f"<input id=time type=range min=0 max={len(ride.frames) - 1} value=0><span "
        "id=where></span></div></div>"
        f"<script>const ride={text};\n{_text('player.js')}</script>"
    )


def _data(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode()}"


def _text(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
