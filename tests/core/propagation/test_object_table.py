"""The table of propagation functions against the functions themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import NoGain, ObjectTable
from haptic_tracing.core.scene.functions import Expression, Physical, Wave
from haptic_tracing.core.scene.values import HapticObject
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER

PHYSICAL = st.builds(
    Physical,
    wave=st.sampled_from(Wave),
    loss_factor=st.floats(0, 0.5),
    phase_speed=st.floats(50, 5000),
    reference_distance=st.floats(0.01, 2),
    extent=st.sampled_from([0.0, 0.3, 5.0]),
)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.data())
def test_gains_and_costs_are_those_of_the_functions(data):
    functions = data.draw(
        st.lists(st.one_of(st.sampled_from((*METRIC, *OTHER)), PHYSICAL), min_size=1, max_size=6)
    )
    parts = [(data.draw(st.floats(0, 1)), data.draw(st.floats(0, 1))) for _ in functions]
    objects = [
        HapticObject(f"o{k}", *part, function)
        for k, (part, function) in enumerate(zip(parts, functions, strict=True))
    ]
    table = ObjectTable.of(objects, 0.1)
    index = np.array(data.draw(st.lists(st.integers(0, len(objects) - 1), min_size=1, max_size=12)))
    distance = np.array([data.draw(st.floats(0, 20)) for _ in index])
    expected = [
        float(objects[k].propagation.gain(np.array(d), *parts[k], 0.1))
        for k, d in zip(index, distance, strict=True)
    ]
    gains = table.gains(index, distance)
    assert gains == pytest.approx(expected, rel=1e-12, abs=1e-300)
    constant, varying = table.costs(index, distance)
    assert np.exp(-(constant + varying)) == pytest.approx(expected, rel=1e-11, abs=1e-300)
    assert [
        float(table.gain(k, np.array(d))) for k, d in zip(index.tolist(), distance, strict=True)
    ] == pytest.approx(gains, rel=1e-15)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(PHYSICAL, st.floats(0, 20), st.floats(0, 20), st.floats(-1, 1))
def test_the_cost_of_a_closed_form_is_a_constant_and_a_metric(function, a, b, cosine):
    """The triangle inequality, which the search for shortest paths relies on."""
    table = ObjectTable.of([HapticObject("o", 0.2, 0.7, function)], 0.1)
    third = math.sqrt(max(a * a + b * b - 2 * a * b * cosine, 0.0))
    cost = table.costs(np.zeros(3, dtype=np.int64), np.array([a, b, third]))[1]
    assert cost[2] <= (cost[0] + cost[1]) * (1 + 1e-12) + 1e-12


def test_the_object_without_a_gain_is_named():
    table = ObjectTable.of(
        [HapticObject("a", 0, 1), HapticObject("odd", 0, 1, Expression(expression="1 - d"))], 0.1
    )
    with pytest.raises(NoGain, match="object 'odd'"):
        table.gains(np.array([0, 1]), np.array([3.0, 2.0]))
