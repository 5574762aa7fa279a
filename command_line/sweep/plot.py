"""``haptic-tracing sweep plot TABLE.parquet``: level per listener over a parameter."""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pyarrow as pa
from matplotlib import pyplot as plt

from ...core.formats.io.atomic import atomic_file
from ...core.forms import Form
from .. import answer
from .table import read_table, varied_columns

mpl.use("svg")
Row = Form


def run(args: argparse.Namespace, path: Path) -> int:
    """Draw the picture of a table. Exit code 0."""
    table = read_table(path)
    varied = varied_columns(table)
    over = args.over or _first_number(table)
    if over is None:
        raise ValueError(f"{path}: no number varies; --over names a column")
    if over not in varied:
        raise ValueError(f"--over: {path} has no column {over}; it has {', '.join(varied)}")
    args.out.mkdir(parents=True, exist_ok=True)
    picture = args.out / f"{path.stem}.levels.svg"
    figure = _levels(table.to_pylist(), over)
    with atomic_file(picture) as file:
        figure.savefig(file, format="svg")
    plt.close(figure)
    print(f"wrote {picture}")
    answer(args, {"files": [str(picture)]})
    return 0


def _first_number(table: pa.Table) -> str | None:
    """The first varied parameter that is a number and has more than one value; None if there is
    none."""
    names = (
        name
        for name in varied_columns(table)
        if pa.types.is_integer(table[name].type) or pa.types.is_floating(table[name].type)
    )
    return next((name for name in names if len(table[name].unique()) > 1), None)


def _levels(rows: Sequence[Row], over: str) -> Any:
    """The level of each listener over a parameter: the mean of the variants with the same value,
    and from the least to the greatest."""
    levels: dict[str, dict[Any, list[float]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        if row["level"] is not None and row[over] is not None:
            levels[row["listener"]][row[over]].append(row["level"])
    figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    for listener, by_value in levels.items():
        values = sorted(by_value)
        (line,) = axes.plot(
            values,
            [sum(by_value[value]) / len(by_value[value]) for value in values],
            marker="o",
            label=listener,
        )
        ends = (
            [min(by_value[value]) for value in values],
            [max(by_value[value]) for value in values],
        )
        axes.fill_between(values, *ends, color=line.get_color(), alpha=0.06, linewidth=0)
    axes.set(
        xlabel=over,
        ylabel="level [dB]",
        title="Mean level, and its range over all else that varies",
    )
    if levels:
        figure.legend(loc="outside right upper", fontsize="small")
    return figure
