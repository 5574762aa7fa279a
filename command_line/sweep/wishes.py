"""Settings for desired levels: the nearest variant of a table, and an interpolation between
variants."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from ...core.forms import Form
from ...core.frozen import frozen
from ...core.least_squares import bounded_least_squares

Row = Form
Variants = Sequence[Mapping[str, Row]]


@frozen
class Between:
    """``settings`` between the variants, the ``levels`` in dB that a linear fit expects of them by
    listener, and the greatest ``error`` of that fit at any variant, in dB."""

    settings: Mapping[str, float]
    levels: Mapping[str, float]
    error: float


def parsed(texts: Sequence[str], rows: Sequence[Row]) -> dict[str, float]:
    """Levels in dB by listener. Raises ValueError unless each text is LISTENER=LEVEL with a
    listener of the table."""
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


def felt_variants(rows: Sequence[Row], wishes: Mapping[str, float]) -> Variants:
    """The rows by listener of every variant in which all listeners with a wish feel something.
    Raises ValueError if there is none."""
    variants: dict[str, dict[str, Row]] = defaultdict(dict)
    for row in rows:
        if row["listener"] in wishes and row["level"] is not None:
            variants[row["key"]][row["listener"]] = row
    whole = [variant for variant in variants.values() if len(variant) == len(wishes)]
    if not whole:
        raise ValueError(f"--wish: in no variant is anything felt by all of {', '.join(wishes)}")
    return whole


def nearest(variants: Variants, wishes: Mapping[str, float]) -> Mapping[str, Row]:
    """The variant whose levels differ least from the wishes, by the sum of squares in dB."""
    return min(
        variants,
        key=lambda variant: sum(
            (variant[name]["level"] - level) ** 2 for name, level in wishes.items()
        ),
    )


def between(
    variants: Variants, wishes: Mapping[str, float], varied: Sequence[str]
) -> Between | None:
    """The numbers within their ranges that are nearest to the wishes, all else as in the nearest
    variant, from a linear fit to the variants that differ only in numbers; None if these are too
    few for a fit."""
    best = _any_row(nearest(variants, wishes))
    numbers = [name for name in varied if name != "seed" and type(best[name]) in (int, float)]
    rest = [name for name in varied if name != "seed" and name not in numbers]
    alike = [
        variant
        for variant in variants
        if all(_any_row(variant)[name] == best[name] for name in rest)
    ]
    places = np.array(
        [[_any_row(variant)[name] for name in numbers] for variant in alike], dtype=np.float64
    )
    low, high = places.min(axis=0), places.max(axis=0)
    numbers = [name for name, least, most in zip(numbers, low, high, strict=True) if most > least]
    places, low, high = places[:, high > low], low[high > low], high[high > low]
    if not numbers or len(alike) < len(numbers) + 2:
        return None
    start = np.array([best[name] for name in numbers], dtype=np.float64)
    shares = np.column_stack([(places - start) / (high - low), np.ones(len(alike))])
    levels = np.array([[variant[name]["level"] for name in wishes] for variant in alike])
    fit = np.linalg.lstsq(shares, levels, rcond=None)[0]
    slopes, offset = fit[:-1].T, fit[-1]
    target = np.array(list(wishes.values())) - offset
    change = bounded_least_squares(
        slopes, target, (low - start) / (high - low), (high - start) / (high - low)
    )
    found = dict(zip(numbers, (start + change * (high - low)).tolist(), strict=True))
    expected = dict(zip(wishes, (offset + slopes @ change).tolist(), strict=True))
    return Between(found, expected, float(np.abs(shares @ fit - levels).max()))


def _any_row(variant: Mapping[str, Row]) -> Row:
    return next(iter(variant.values()))
