"""``haptic-tracing sweep plot TABLE.parquet``: level per listener over a parameter, and run time
against error."""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pyarrow as pa
from matplotlib import pyplot as plt

from ...core.formats.io.atomic import atomic_file
from ...core.forms import Form, JsonObject
from ...core.perception import BEST_LEVEL
from .. import answer
from .table import read_table, varied_columns

mpl.use("svg")
Row = Form


def run(args: argparse.Namespace, path: Path) -> int:
    """Draw both pictures of a table, and print the fastest variants. Exit code 0."""
    table = read_table(path)
    rows = table.to_pylist()
    varied = _differing(rows, varied_columns(table))
    over = args.over or _first_number(table)
    if over is not None and over not in varied_columns(table):
        raise ValueError(
            f"--over: {path} has no column {over}; it has {', '.join(varied_columns(table))}"
        )
    args.out.mkdir(parents=True, exist_ok=True)
    pictures = [(f"{path.stem}.time.svg", _time_against_error(rows))]
    if over is not None:
        pictures.insert(0, (f"{path.stem}.levels.svg", _levels(rows, over)))
    for name, figure in pictures:
        with atomic_file(args.out / name) as file:
            figure.savefig(file, format="svg")
        plt.close(figure)
        print(f"wrote {args.out / name}")
    result: JsonObject = {"files": [str(args.out / name) for name, _ in pictures]}
    result["fastest"] = best = pareto(rows)
    result["assumed"] = sorted({row["listener"] for row in rows if row.get("threshold") is None})
    if result["assumed"]:
        print(
            f"felt: above {BEST_LEVEL:g} dB of full scale, assumed: no Full Scale has "
            f"{', '.join(result['assumed'])}"
        )
    if not best:
        print(
            "no variant bounds the error and reaches every listener who feels something in "
            "another one"
        )
    for number, row in enumerate(best, 1):
        print(
            f"{number}: fastest for its error, {row['milliseconds']:.2f} ms, "
            f"{row['error_bound']:.3g}: {_words(row, varied)}"
        )
    answer(args, result)
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


def by_variant(rows: Sequence[Row]) -> list[Row]:
    """One row per variant with error bounds: that of the listener with the largest bound.

    Left out are variants with a listener for which nothing bounds the error, those in which nobody
    feels anything, and those whose limits cut off a listener who feels something in another
    variant: a small bound on nothing is no accuracy.
    """
    feeling = {row["listener"] for row in rows if _is_felt(row)}
    by_key: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        by_key[row["key"]].append(row)
    return [
        max(own, key=lambda row: row["error_bound"])
        for own in by_key.values()
        if any(map(_is_felt, own))
        and all(row["error_bound"] is not None for row in own)
        and not any(
            row["level"] is None and row["error_bound"] > 0 and row["listener"] in feeling
            for row in own
        )
    ]


def _is_felt(row: Row) -> bool:
    """Whether the level is above the lowest threshold of feeling, by the calibration of the
    listener's device, else an assumed one."""
    threshold = row.get("threshold")
    return row["level"] is not None and row["level"] > (
        BEST_LEVEL if threshold is None else threshold
    )


def pareto(rows: Sequence[Row]) -> list[Row]:
    """The Pareto-optimal variants in run time and error bound, the fastest first."""
    best, found = math.inf, []
    for row in sorted(by_variant(rows), key=lambda row: (row["milliseconds"], row["error_bound"])):
        if row["error_bound"] < best:
            best = row["error_bound"]
            found.append(row)
    return found


def _time_against_error(rows: Sequence[Row]) -> Any:
    """Plot of all variants, with numbers at the Pareto-optimal ones."""
    figure, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    every, best = by_variant(rows), pareto(rows)
    axes.plot(
        [row["milliseconds"] for row in every],
        [row["error_bound"] for row in every],
        "o",
        color="lightgray",
    )
    axes.plot(
        [row["milliseconds"] for row in best],
        [row["error_bound"] for row in best],
        "o-",
        color="tab:blue",
    )
    for number, row in enumerate(best, 1):
        axes.annotate(
            str(number),
            (row["milliseconds"], row["error_bound"]),
            (4, 4),
            textcoords="offset points",
        )
    axes.set(
        xlabel="tracing a frame, median [ms]",
        ylabel="greatest error bound of a gain",
        title="Run time against error",
    )
    axes.set_yscale("symlog", linthresh=1e-12)
    return figure


def _differing(rows: Sequence[Row], varied: Sequence[str]) -> list[str]:
    """The parameters with several values."""
    return [name for name in varied if len({row[name] for row in rows}) > 1]


def _words(row: Row, varied: Sequence[str]) -> str:
    values = {name: row[name] for name in varied if row[name] is not None}
    return ", ".join(
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in values.items()
    )
