"""Which differences of amplitude are felt, against Israr, Tan and Reed, J. Acoust. Soc. Am. 120
(2006) 2789, doi 10.1121/1.2354022."""

import pytest
from haptic_tracing.core.perception import (
    DIFFERENCE_THRESHOLDS,
    MASKED_DIFFERENCE_THRESHOLD,
    are_felt_alike,
    are_felt_different,
)

# Lowest and highest of those from 2 to 300 Hz, in decibels, by the level above the threshold of
# feeling.
PUBLISHED = {20: (1.82, 2.98), 35: (1.65, 2.71)}
MASKED = {20: 3.63, 35: 3.72}


def test_the_thresholds_span_the_published_ones():
    assert min(low for low, _ in PUBLISHED.values()) == DIFFERENCE_THRESHOLDS[0]
    assert max(high for _, high in PUBLISHED.values()) == DIFFERENCE_THRESHOLDS[1]
    assert max(MASKED.values()) == MASKED_DIFFERENCE_THRESHOLD


@pytest.mark.parametrize("sign", [1, -1])
def test_between_the_thresholds_it_depends(sign):
    assert are_felt_alike(sign * 1.6) and not are_felt_different(sign * 1.6)
    for decibels in (1.7, 2.3, 2.9):
        assert not are_felt_alike(sign * decibels) and not are_felt_different(sign * decibels)
    assert are_felt_different(sign * 3.0) and not are_felt_alike(sign * 3.0)
    assert not are_felt_different(sign * 3.0, masked=True) and are_felt_different(
        sign * 3.8, masked=True
    )
