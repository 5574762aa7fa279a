"""Results as Markdown, JSON and a picture, side by side in ``benchmarks/results``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .machine import described, machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULTS = Path(__file__).parent / "results"


def table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, the first column to the left and the others to the right."""
    cells = [list(heading), *map(list, rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(heading))]
    lines = [
        "| "
        + " | ".join(
            cell.ljust(w) if k == 0 else cell.rjust(w)
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        + " |"
        for row in cells
    ]
    rule = (
        "|"
        + "|".join("-" * (w + 2) if k == 0 else "-" * (w + 1) + ":" for k, w in enumerate(widths))
        + "|"
    )
    return "\n".join([lines[0], rule, *lines[1:]])


def milliseconds(seconds: float | None) -> str:
    """Three digits; a dash for what was not measured."""
    if seconds is None:
        return "-"
    value = 1000 * seconds
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def publish(name: str, title: str, text: str, data: Any, figure: Figure | None = None) -> None:
    """Print the Markdown ``text`` and write it, the ``data`` and the ``figure`` (SVG) under this
    name."""
    RESULTS.mkdir(exist_ok=True)
    picture = f"\n![{title}]({name}.svg)\n" if figure is not None else ""
    page = f"# {title}\n\n{described()}\n\n{text}\n{picture}"
    print(page)
    (RESULTS / f"{name}.md").write_text(page, encoding="utf-8")
    with (RESULTS / f"{name}.json").open("w", encoding="utf-8") as file:
        json.dump(
            {"title": title, "machine": machine(), "results": data}, file, indent=1, allow_nan=False
        )
        file.write("\n")
    if figure is not None:
        figure.savefig(RESULTS / f"{name}.svg", metadata={"Date": None})
