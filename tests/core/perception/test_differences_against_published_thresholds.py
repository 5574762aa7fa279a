"""Which differences of amplitude are noticed, against Israr, Tan and Reed, J. Acoust. Soc. Am. 120
(2006) 2789, doi 10.1121/1.2354022, and Forta, Griffin and Morioka 2012."""

import math

import pytest
from haptic_tracing.core.perception import (
    DIFFERENCE_THRESHOLDS,
    FEW,
    MASKED_DIFFERENCE_THRESHOLD,
    MOST,
    PEOPLE,
    are_felt_alike,
    are_felt_different,
    noticing,
)
from scipy.stats import norm

# Lowest and highest of those from 2 to 300 Hz, in decibels, by the level above the threshold of
# feeling.
ISRAR = {20: (1.82, 2.98), 35: (1.65, 2.71)}
MASKED = {20: 3.63, 35: 3.72}
# Medians of Weber fractions by frequency.
FORTA = {10: 0.58, 125: 0.20}


def decibels(weber):
    return 20 * math.log10(1 + weber)


def test_the_thresholds_span_the_published_ones():
    below, above = DIFFERENCE_THRESHOLDS
    low, high = min(low for low, _ in ISRAR.values()), max(high for _, high in ISRAR.values())
    assert below == (low, pytest.approx(decibels(FORTA[10]), abs=0.005))
    assert above == (pytest.approx(decibels(FORTA[125]), abs=0.005), high)
    assert max(MASKED.values()) == MASKED_DIFFERENCE_THRESHOLD


@pytest.mark.parametrize("hertz", [10, 39, 40, 250])
@pytest.mark.parametrize("difference", [-6.0, -3.0, 0.5, 1.65, 2.98, 3.97, 12.0])
def test_shares_of_people_are_those_of_a_log_normal_spread(hertz, difference):
    thresholds = DIFFERENCE_THRESHOLDS[hertz >= 40]
    weber = [10 ** (abs(x) / 20) - 1 for x in (difference, *thresholds)]
    expected = [norm.cdf(math.log(weber[0] / x) / math.log(PEOPLE)) for x in weber[:0:-1]]
    assert noticing(difference, hertz) == pytest.approx(expected)
    assert are_felt_different(difference, hertz) == (expected[0] >= MOST)
    assert are_felt_alike(difference, hertz) == (expected[1] <= FEW)


def test_half_of_the_people_notice_the_typical_threshold_and_nobody_no_difference():
    assert noticing(3.97, 10)[0] == noticing(1.58, 125)[1] == pytest.approx(0.5)
    assert noticing(0.0, 100) == (0.0, 0.0)
    assert noticing(math.inf, 100) == pytest.approx((1.0, 1.0))
