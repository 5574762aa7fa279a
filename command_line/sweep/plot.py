"""``haptic-tracing sweep plot TABLE.parquet``: level per listener over a parameter, run time against error, and what is
nearest to wished levels."""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pyarrow as pa
from matplotlib import pyplot as plt

from ...core.formats.io.atomic import atomic_file
from .table import read_table, varied_columns

mpl.use("svg")
Row = Mapping[str, Any]


def run(args: argparse.Namespace, path: Path) -> int:
    """Draw both pictures of a table, and print what is nearest to the wished levels. Exit code 0."""
    table = read_table(path)
    rows = table.to_pylist()
    wishes = _wishes(args.wish, rows)
    over = args.over or _first_number(table)
    if over is not None and over not in varied_columns(table):
        raise ValueError(f"--over: {path} has no column {over}; it has {', '.join(varied_columns(table))}")
    args.out.mkdir(parents=True, exist_ok=True)
    pictures = [(f"{path.stem}.time.svg", _time_against_error(rows, varied_columns(table)))]
    if over is not None:
        pictures.insert(0, (f"{path.stem}.levels.svg", _levels(rows, over)))
    for name, figure in pictures:
        with atomic_file(args.out / name) as file:
            figure.savefig(file, format="svg")
        plt.close(figure)
        print(f"wrote {args.out / name}")
    for row in pareto(rows):
        print(f"fastest for its error: {_words(row, varied_columns(table))}: {row['milliseconds']:.2f} ms, error {row['error_bound']:.3g}")
    if wishes:
        _print_nearest(nearest(rows, wishes), wishes, varied_columns(table))
    return 0


def _wishes(texts: Sequence[str], rows: Sequence[Row]) -> dict[str, float]:
    """Levels in dB by listener. Raises ValueError for what is not LISTENER=LEVEL of a listener in the table."""
    known, wishes = sorted({row["listener"] for row in rows}), {}
    for text in texts:
        name, _, level = text.rpartition("=")
        try:
            wishes[name] = float(level)
        except ValueError:
            wishes[name] = math.nan
        if name not in known or not math.isfinite(wishes[name]):
            raise ValueError(f"--wish {text}: must be LISTENER=LEVEL in dB, of {', '.join(known)}")
    return wishes


def _first_number(table: pa.Table) -> str | None:
    """The first varied column with several numbers."""
    names = (name for name in varied_columns(table) if pa.types.is_integer(table[name].type) or pa.types.is_floating(table[name].type))
    return next((name for name in names if len(table[name].unique()) > 1), None)


def _levels(rows: Sequence[Row], over: str) -> Any:
    """The level of each listener over a parameter: the mean of the variants with the same value, and from the least to the greatest."""
    levels: dict[str, dict[Any, list[float]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        if row["level"] is not None and row[over] is not None:
            levels[row["listener"]][row[over]].append(row["level"])
    figure, axes = plt.subplots(layout="constrained")
    for listener, by_value in levels.items():
        values = sorted(by_value)
        (line,) = axes.plot(values, [sum(by_value[value]) / len(by_value[value]) for value in values], marker="o", label=listener)
        ends = [min(by_value[value]) for value in values], [max(by_value[value]) for value in values]
        axes.fill_between(values, *ends, color=line.get_color(), alpha=0.15, linewidth=0)
    axes.set(xlabel=over, ylabel="level [dB]", title="Level of each listener: mean and range over all else that varies")
    if levels:
        axes.legend(fontsize="small")
    return figure


def by_variant(rows: Sequence[Row]) -> list[Row]:
    """One row per variant that has bounds of its errors: that of the listener with the greatest."""
    worst: dict[str, Row] = {}
    unbounded = {row["key"] for row in rows if row["error_bound"] is None}
    for row in rows:
        key = row["key"]
        if key not in unbounded and (key not in worst or row["error_bound"] > worst[key]["error_bound"]):
            worst[key] = row
    return list(worst.values())


def pareto(rows: Sequence[Row]) -> list[Row]:
    """The variants of which none is both faster and more exact, the fastest first."""
    best, found = math.inf, []
    for row in sorted(by_variant(rows), key=lambda row: (row["milliseconds"], row["error_bound"])):
        if row["error_bound"] < best:
            best = row["error_bound"]
            found.append(row)
    return found


def _time_against_error(rows: Sequence[Row], varied: Sequence[str]) -> Any:
    figure, axes = plt.subplots(layout="constrained")
    every, best = by_variant(rows), pareto(rows)
    axes.plot([row["milliseconds"] for row in every], [row["error_bound"] for row in every], "o", color="lightgray")
    axes.plot([row["milliseconds"] for row in best], [row["error_bound"] for row in best], "o-", color="tab:blue")
    for row in best:
        axes.annotate(_words(row, varied), (row["milliseconds"], row["error_bound"]), fontsize="x-small")
    axes.set(xlabel="tracing a frame, median [ms]", ylabel="greatest error bound of a gain", title="Run time against error")
    axes.set_yscale("symlog", linthresh=1e-12)
    return figure


def nearest(rows: Sequence[Row], wishes: Mapping[str, float]) -> list[Row]:
    """The rows of the wished listeners of the variant whose levels differ least from the wishes, in squares of dB."""
    variants: dict[str, dict[str, Row]] = defaultdict(dict)
    for row in rows:
        if row["listener"] in wishes and row["level"] is not None:
            variants[row["key"]][row["listener"]] = row
    whole = [variant for variant in variants.values() if len(variant) == len(wishes)]
    if not whole:
        raise ValueError(f"--wish: in no variant is anything felt by all of {', '.join(wishes)}")
    best = min(whole, key=lambda variant: sum((variant[name]["level"] - level) ** 2 for name, level in wishes.items()))
    return [best[name] for name in wishes]


def _print_nearest(best: Sequence[Row], wishes: Mapping[str, float], varied: Sequence[str]) -> None:
    print(f"nearest to the wishes: {_words(best[0], varied)}")
    for row in best:
        wished = wishes[row["listener"]]
        print(f"  {row['listener']}: {row['level']:.1f} dB, {row['level'] - wished:+.1f} dB from {wished:.1f} dB")


def _words(row: Row, varied: Sequence[str]) -> str:
    return ", ".join(f"{name} {row[name]}" for name in varied if row[name] is not None)
