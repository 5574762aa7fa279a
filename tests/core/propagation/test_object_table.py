"""The table of propagation functions against the functions themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import NoGain, ObjectTable
from haptic_tracing.core.scene.functions import Expression, Physical, Wave
from haptic_tracing.core.scene.functions.spreading import Spreading
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
    thickness=st.floats(0.01, 3),
)
SIZES = st.one_of(st.just(0.0), st.floats(0, 20))


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


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    PHYSICAL, st.tuples(SIZES, SIZES, SIZES), st.floats(0, 20), st.floats(0, 20), st.floats(-1, 1)
)
def test_the_cost_between_patches_is_a_metric(function, sizes, a, b, cosine):
    """Of patches of these sizes in the corners of a triangle."""
    spreading = Spreading([function.spreading_law()])
    fronts = spreading.fronts(np.zeros(3, dtype=np.int64), np.array(sizes)).T
    third = math.sqrt(max(a * a + b * b - 2 * a * b * cosine, 0.0))
    ways = ((0, 1, a), (1, 2, b), (0, 2, third), (0, 0, 0.0))
    cost = [float(spreading.cost(0, np.array(way), (fronts[i], fronts[j]))) for i, j, way in ways]
    assert cost[2] <= (cost[0] + cost[1]) * (1 + 1e-12) + 1e-12
    assert min(cost) >= 0 and cost[3] == 0
    if not max(sizes):
        plain = [float(spreading.cost(0, np.array(way))) for _, _, way in ways]
        assert cost == pytest.approx(plain, rel=1e-12, abs=1e-13)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(0.02, 3), st.floats(0.02, 9), st.floats(0, 20), SIZES, SIZES)
def test_energy_between_patches_goes_as_the_area_of_the_front(thickness, width, d, one, other):
    """A front that is s metres large has the area s min(s, thickness). The energy is the geometric
    mean of the areas of both patches, by that of the largest front on the way."""
    r = 0.5
    thickness, width = sorted((thickness, width))
    function = Physical(wave=Wave.BOUNDED, thickness=thickness, extent=width)
    law = Spreading([function.spreading_law()])

    def area(s: float) -> float:
        return s * min(s, thickness) if thickness > r else s

    sizes = max(one, r), max(other, r)
    fronts = law.fronts(np.zeros(2, dtype=np.int64), np.array([one, other])).T
    largest = max(*sizes, min(d + sum(sizes) / 2, max(r, width)))
    expected = math.sqrt(area(sizes[0]) * area(sizes[1])) / area(largest)
    found = math.exp(-2 * float(law.cost(0, np.array(d), (fronts[0], fronts[1]))))
    assert found == pytest.approx(expected, rel=1e-9)


LATE = "where(d > 2000, -1, 1)"
"""A formula that has no gain farther away than formulas are checked."""


def test_the_object_without_a_gain_is_named():
    table = ObjectTable.of(
        [HapticObject("a", 0, 1), HapticObject("odd", 0, 1, Expression(expression=LATE))], 0.1
    )
    with pytest.raises(NoGain, match="object 'odd'"):
        table.gains(np.array([0, 1]), np.array([3.0, 2100.0]))
