"""Ten everyday scenes: their levels beside published ranges, and the order of their listeners."""

from __future__ import annotations

import pytest
from haptic_tracing.study.everyday import NEAR, scenes

EVERY = {scene.name: scene for scene in scenes()}


def test_there_are_ten_of_which_six_have_a_source():
    assert len(EVERY) == 10
    assert sum(scene.is_published for scene in EVERY.values()) >= 6


def test_most_published_levels_are_met_within_ten_decibels():
    near = [abs(scene.error) <= NEAR for scene in EVERY.values() if scene.is_published]
    assert sum(near) / len(near) >= 0.8


@pytest.mark.parametrize("name", EVERY)
def test_the_order_of_the_listeners_is_what_everybody_knows(name):
    assert EVERY[name].in_order
