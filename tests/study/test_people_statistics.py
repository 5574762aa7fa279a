"""The statistics of a study with people: against published examples, SciPy, definitions, and
simulated participants whose preferences are known."""

from itertools import combinations, product

import numpy as np
import pytest
from haptic_tracing.study.people.statistics import (
    biserial,
    differences,
    friedman,
    holm,
    mean,
    pairs,
    power,
    share,
)
from pandas import DataFrame, Series
from scipy import stats

# Seconds of 22 players to second base by three methods of rounding first base: M. Hollander and
# D. A. Wolfe, Nonparametric Statistical Methods (1973), p. 140.
ROUNDING_FIRST_BASE = np.fromstring(
    """
    5.40 5.50 5.55 5.85 5.70 5.75 5.20 5.60 5.50 5.55 5.50 5.40 5.90 5.85 5.70 5.45 5.55 5.60
    5.40 5.40 5.35 5.45 5.50 5.35 5.25 5.15 5.00 5.85 5.80 5.70 5.25 5.20 5.10 5.65 5.55 5.45
    5.60 5.35 5.45 5.05 5.00 4.95 5.50 5.50 5.40 5.45 5.55 5.50 5.55 5.55 5.35 5.45 5.50 5.55
    5.50 5.45 5.25 5.65 5.60 5.40 5.70 5.65 5.55 6.30 6.30 6.25
    """,
    sep=" ",
).reshape(22, 3)
# Depression scale at the first and second visit after therapy: the same book, p. 29.
FIRST = np.array([1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30])
SECOND = np.array([0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29])

MEANS = np.array([0.45, -0.45, 0.15, -0.15])
"""Of the simulated conditions, in steps: W is 0.125, near the paper's 0.129 and 0.117."""


def test_friedman_of_the_published_example():
    found = friedman(DataFrame(ROUNDING_FIRST_BASE))
    assert found["chi-square"] == pytest.approx(78 / 7, abs=1e-9)
    assert found["p"] == pytest.approx(np.exp(-39 / 7), abs=1e-9)  # chi-square of 2 degrees
    assert found["W"] == pytest.approx(78 / 7 / 44, abs=1e-9)


@pytest.mark.parametrize("count", [3, 4, 6])
def test_friedman_is_that_of_scipy(count):
    ratings = np.random.default_rng(count).integers(1, 6, (20, count)).astype(float)
    test, found = stats.friedmanchisquare(*ratings.T), friedman(DataFrame(ratings))
    assert (found["chi-square"], found["p"]) == pytest.approx(test, abs=1e-9)


def test_friedman_of_two_conditions_is_the_sign_test():
    """By definition: the square of (wins - losses) / sqrt(wins + losses)."""
    ratings = DataFrame({"a": [5, 6, 7, 4, 3, 5, 5], "b": [4, 5, 5, 5, 2, 5, 1]})
    found = friedman(ratings)
    assert found["chi-square"] == pytest.approx((5 - 1) ** 2 / 6, abs=1e-9)
    assert found["p"] == pytest.approx(2 * stats.norm.sf(4 / np.sqrt(6)), abs=1e-9)


def test_a_pair_of_the_published_example():
    (pair,) = pairs(DataFrame({"first": FIRST, "second": SECOND}), 1.0)
    assert pair["p"] == pytest.approx(20 / 2**9, abs=1e-9)
    assert pair["Holm"] == pair["p"]
    assert pair["rank-biserial"] == pytest.approx((40 - 5) / 45, abs=1e-9)


def test_p_is_the_share_of_signs_with_as_large_a_sum():
    differences = (FIRST - SECOND).round(9)
    ranks = stats.rankdata(np.abs(differences))
    sums = [ranks @ signs for signs in product((-1, 1), repeat=9)]
    own = abs(ranks @ np.sign(differences))
    expected = np.mean(np.abs(sums) >= own - 1e-9)
    (pair,) = pairs(DataFrame({"first": FIRST, "second": SECOND}), 1.0)
    assert pair["p"] == pytest.approx(expected, abs=1e-9)


def test_the_correction_of_holm_by_hand():
    assert holm(Series([0.01, 0.04, 0.03, 0.005])).tolist() == pytest.approx(
        [0.03, 0.06, 0.06, 0.02]
    )


@pytest.mark.parametrize(
    ("count", "people", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611)],
)
def test_shares_of_the_published_examples(count, people, low, high):
    """R. G. Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3."""
    found = share("share", count, people)
    assert (found["share low"], found["share high"]) == pytest.approx((low, high), abs=5e-5)


def test_means_and_p_are_those_of_scipys_tests():
    ratings = simulated(np.random.default_rng(2), 30, 1.0)
    found = pairs(DataFrame(ratings), 1.0)
    assert [pair["pair"] for pair in found] == [f"{a} - {b}" for a, b in combinations(range(4), 2)]
    for pair, (a, b) in zip(found, combinations(range(4), 2), strict=True):
        test = stats.ttest_rel(ratings[:, a], ratings[:, b])
        interval = test.confidence_interval()
        assert (pair["difference low"], pair["difference high"]) == pytest.approx(
            (interval.low, interval.high), abs=1e-9
        )
        difference = ratings[:, a] - ratings[:, b]
        assert pair["p"] == pytest.approx(stats.wilcoxon(difference.round(9)).pvalue, abs=1e-9)


def test_bounds_of_a_correlation_are_those_at_which_its_score_test_just_keeps_it():
    """By definition, over all signs of the ranks, each positive with the same probability."""
    differences = np.array([1.5, 3.0, 3.0, -0.5, 2.0, 0.0, -2.5, 4.0])
    ranks = stats.rankdata(np.abs(differences[differences != 0]))
    signs = np.array(list(product((-1, 1), repeat=len(ranks))))
    sums = signs @ ranks / ranks.sum()
    found = biserial(Series(differences))
    for bound, score in (("low", 1.959964), ("high", -1.959964)):
        positive = (1 + found[f"rank-biserial {bound}"]) / 2
        chances = np.where(signs > 0, positive, 1 - positive).prod(axis=1)
        mean = chances @ sums
        spread = np.sqrt(chances @ (sums - mean) ** 2)
        assert (found["rank-biserial"] - mean) / spread == pytest.approx(score, abs=1e-6)


@pytest.mark.parametrize(
    "ratings", [np.full((8, 4), 3.0), np.tile([1.0, 2.0, 3.0, 4.0], (8, 1)), np.zeros((6, 2))]
)
def test_ratings_without_any_variation_have_results(ratings):
    found = friedman(DataFrame(ratings))
    assert 0 <= found["W low"] <= found["W"] <= found["W high"] <= 1
    for pair in pairs(DataFrame(ratings), 1.0):
        low, high = pair["rank-biserial low"], pair["rank-biserial high"]
        assert -1 <= low <= pair["rank-biserial"] <= high <= 1
        assert 0 <= pair["p"] <= pair["Holm"] <= 1


@pytest.mark.slow
@pytest.mark.parametrize(("people", "alpha"), [(24, 0.05), (40, 0.05 / 6)])
def test_power_is_the_share_of_simulated_studies_that_find_the_effect(people, alpha):
    generator = np.random.default_rng(people)
    differences = generator.normal(0.5, 1.2, (people, 20_000))
    found = np.mean(stats.wilcoxon(differences, method="asymptotic").pvalue < alpha)
    assert power(people, 0.5, 1.2, alpha) == pytest.approx(found, abs=0.02)


def simulated(generator, people, strength):
    """Means of four items from 1 to 7, (people, conditions)."""
    level = generator.normal(0, 1, (people, 1))
    felt = 4 + strength * MEANS + level + generator.normal(0, 0.8, (people, 4))
    items = felt[:, :, None] + generator.normal(0, 0.9, (people, 4, 4))
    return np.clip(np.rint(items), 1, 7).mean(axis=2)


def holds(row, name, truth):
    """Whether the interval of an estimate does."""
    return row[f"{name} low"] <= truth <= row[f"{name} high"]


MORE = (pytest.mark.slow, pytest.mark.more)


@pytest.mark.parametrize(
    ("people", "count"),
    [
        pytest.param(40, 1_000, marks=pytest.mark.slow),
        pytest.param(24, 10_000, marks=MORE),
        pytest.param(40, 10_000, marks=MORE),
    ],
)
def test_intervals_cover_the_known_preferences(people, count, record_property):
    """Truth is what a million simulated people show."""
    generator = np.random.default_rng(39)
    everybody = simulated(generator, 1_000_000, 1.0)
    ranks = stats.rankdata(everybody, axis=1) - 2.5
    truth = (ranks.mean(axis=0) ** 2).sum() / (ranks**2).sum(axis=1).mean()
    means, correlations = [], []
    for a, b in combinations(range(4), 2):
        difference = everybody[:, a] - everybody[:, b]
        means.append(difference.mean())
        signed = stats.rankdata(np.abs(difference[difference != 0]))
        correlations.append((signed * np.sign(difference[difference != 0])).sum() / signed.sum())
    covered = {"W": 0, "mean": 0, "rank-biserial": 0, "share": 0}
    first = np.mean(everybody[:, 0] > everybody[:, 1:].max(axis=1))
    for _ in range(count):
        ratings = simulated(generator, people, 1.0)
        covered["W"] += holds(friedman(DataFrame(ratings)), "W", truth)
        apart = differences(DataFrame(ratings))
        for pair, difference, correlation in zip(apart, means, correlations, strict=True):
            found = mean(apart[pair]) | biserial(apart[pair])
            covered["mean"] += holds(found, "difference", difference) / 6
            covered["rank-biserial"] += holds(found, "rank-biserial", correlation) / 6
        chosen = share("share", int((ratings[:, 0] > ratings[:, 1:].max(axis=1)).sum()), people)
        covered["share"] += holds(chosen, "share", first)
    shares = {name: value / count for name, value in covered.items()}
    record_property("coverage", str(shares))
    assert all(0.93 <= value <= 0.97 for value in shares.values()), shares


@pytest.mark.parametrize(
    "count", [pytest.param(2_000, marks=pytest.mark.slow), pytest.param(10_000, marks=MORE)]
)
def test_without_an_effect_tests_find_one_as_often_as_they_say(count, record_property):
    generator = np.random.default_rng(24)
    whole = family = 0
    for _ in range(count):
        ratings = simulated(generator, 24, 0.0)
        whole += stats.friedmanchisquare(*ratings.T).pvalue < 0.05
        differences = np.column_stack(
            [ratings[:, a] - ratings[:, b] for a, b in combinations(range(4), 2)]
        )
        family += holm(Series(stats.wilcoxon(differences).pvalue)).min() < 0.05
    record_property("found", f"{whole / count:g} {family / count:g}")
    assert 0.04 <= whole / count <= 0.06
    assert family / count <= 0.06


def test_strong_effects_are_covered_too():
    """Where nearly everybody agrees, an interval still reaches below 1."""
    found = biserial(Series(np.arange(1.0, 21.0)))
    assert found["rank-biserial"] == found["rank-biserial high"] == 1.0
    assert 0.5 < found["rank-biserial low"] < 0.95
    assert mean(Series(np.arange(5.0)))["difference"] == 2.0
