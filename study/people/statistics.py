"""Tests, effect sizes and power for ratings of several conditions by the same people."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from pandas import DataFrame, Series
from scipy import special, stats

from ...core.forms import JsonObject

_TAIL = 0.025
"""Probability beyond each end of an interval of 95 %."""
_EFFICIENCY = 3 / math.pi
"""Asymptotic relative efficiency of Wilcoxon's test to the t test for normal differences."""


def estimate(name: str, value: float, low: float, high: float) -> JsonObject:
    """An estimate with its confidence interval, as columns of a table."""
    return {name: value, f"{name} low": low, f"{name} high": high}


def friedman(ratings: DataFrame) -> JsonObject:
    """Friedman's test of ratings (people, conditions), corrected for ties, with Kendall's W.

    W is the squared length of the mean rank vector. Its interval inverts the noncentral F
    distribution of W / v, where v is the jackknife's variance of that length; at W above about 0.4
    it covers more than it says.
    """
    people, count = ratings.shape
    ranks = stats.rankdata(ratings, axis=1) - (count + 1) / 2
    squares, sums = (ranks**2).sum(axis=1), ranks.sum(axis=0)
    if not squares.any():
        return {"people": people, "chi-square": 0.0, "p": 1.0, **estimate("W", 0.0, 0.0, 1.0)}
    w = sums @ sums / (people * squares.sum())
    others = np.maximum(squares.sum() - squares, 0.5)
    lengths = np.sqrt(((sums - ranks) ** 2).sum(axis=1) / ((people - 1) * others))
    variance = max(lengths.var() * (people - 1), w / 1000)  # also where all agree
    degrees = count - 1, (people - 1) * (count - 1)
    distances = special.ncfdtrinc(*degrees, [1 - _TAIL, _TAIL], w / variance / degrees[0])
    square = w * people * degrees[0]
    p = stats.chi2.sf(square, degrees[0])
    bounds = np.minimum(distances * variance, 1.0)
    return {"people": people, "chi-square": square, "p": p, **estimate("W", w, *bounds)}


def holm(p: Series) -> Series:
    """p values corrected by S. Holm, Scand. J. Statist. 6 (1979) 65."""
    ordered = p.sort_values()
    factors = np.arange(len(p), 0, -1)
    return (ordered * factors).cummax().clip(upper=1.0).reindex(p.index)


def differences(ratings: DataFrame) -> DataFrame:
    """Differences of the ratings of all pairs of conditions, rounded, so that equal differences of
    means are equal."""
    return DataFrame(
        {f"{a} - {b}": (ratings[a] - ratings[b]).round(9) for a, b in combinations(ratings, 2)}
    )


def pairs(ratings: DataFrame, effect: float) -> list[JsonObject]:
    """All pairs of conditions compared by Wilcoxon's signed-rank test of ratings (people,
    conditions), which leaves out differences of zero: p of the pair alone and corrected over all
    pairs, the mean difference, the matched-pairs rank-biserial correlation, and the power for a
    mean difference ``effect`` at the strictest step of the correction."""
    found = differences(ratings)
    p = found.apply(lambda column: stats.wilcoxon(column).pvalue if column.any() else 1.0)
    return [
        {
            "pair": name,
            "p": p[name],
            "Holm": corrected,
            **mean(found[name]),
            **biserial(found[name]),
            "power": power(len(ratings), effect, found[name].std(), 0.05 / len(p)),
        }
        for name, corrected in holm(p).items()
    ]


def mean(values: Series) -> JsonObject:
    """Mean of differences (n,) with Student's interval."""
    middle = values.mean()
    half = values.sem() * special.stdtrit(len(values) - 1, 1 - _TAIL)
    return estimate("difference", middle, middle - half, middle + half)


def biserial(values: Series) -> JsonObject:
    """Matched-pairs rank-biserial correlation of differences (n,), from -1 to 1: the rank sum of
    positive differences less that of negative ones, divided by their sum.

    Its interval are the correlations at which the score test keeps the one found, with the variance
    of signs that are independent of each other and of the ranks.
    """
    moved = values.to_numpy()[values != 0]
    if not len(moved):
        return estimate("rank-biserial", 0.0, -1.0, 1.0)
    weights = stats.rankdata(np.abs(moved))
    weights /= weights.sum()
    value = weights @ np.sign(moved)
    spread = special.ndtri(_TAIL) ** 2 * (weights @ weights)
    half = math.sqrt(spread * (spread + 1 - value**2))
    low, high = (value - half) / (1 + spread), (value + half) / (1 + spread)
    return estimate("rank-biserial", value, low, high)


def share(name: str, count: int, people: int) -> JsonObject:
    """A share of people with Wilson's interval."""
    found = stats.binomtest(count, people).proportion_ci(method="wilson")
    return estimate(name, count / people, *found)


def power(people: int, effect: float, spread: float, alpha: float) -> float:
    """Probability that Wilcoxon's two-sided test finds a mean difference ``effect`` of normal
    differences with the standard deviation ``spread``, at the level ``alpha``."""
    counted = people * _EFFICIENCY
    degrees, shift = (1, counted - 1), counted * (effect / (spread or 1e-3)) ** 2
    limit = special.fdtri(*degrees, 1 - alpha)
    return 1 - float(special.ncfdtr(*degrees, shift, limit))
