"""Bodies of one piece and of several that touch: how far a cut changes what arrives at the other
end."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation.best_path import best_paths
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import physical
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st

R0 = 0.5
"""Radius of the area that a source drives, as `physical` has it."""


def level(
    name: str,
    size: tuple[float, float, float],
    pieces: int,
    joined: float = 1.0,
) -> float:
    """Level [dB] at the far end of a body that is cut across its first size into pieces, which
    touch over this part of their faces."""
    material, length = MATERIALS[name], size[0] / pieces
    own = (length, *size[1:])
    function = physical(name, own)
    objects = tuple(
        HapticObject(
            f"piece {k:02d}",
            material.kappa,
            material.rho,
            function,
            Box(own),
            Pose(((k + 0.5) * length, 0, 0)),
        )
        for k in range(pieces)
    )
    contacts = tuple(
        Contact(
            (one.name, other.name),
            (((k + 1) * length, 0, 0), ((k + 1) * length, 0, 0)),
            area=joined * size[1] * size[2],
            normal=(1.0, 0.0, 0.0),
        )
        for k, (one, other) in enumerate(itertools.pairwise(objects))
    )
    ends = (
        (Source("s", objects[0].name),),
        (Listener("l", objects[-1].name, (size[0], 0, 0), radius=0.0),),
    )
    graph = graph_of_scene(HapticScene(objects, contacts, *ends))
    cost, _, _ = best_paths(graph, np.ones((1, 1), dtype=np.bool_), math.inf).paths.sums(graph)
    return -20 / math.log(10) * float(cost[0])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.sampled_from(["steel", "hardwood", "concrete", "rubber"]),
    st.floats(1, 20),
    st.floats(0.02, R0),
    st.floats(0.02, R0),
)
def test_a_beam_no_thicker_than_the_driven_radius_may_be_cut(name, length, width, thickness):
    whole = level(name, (length, width, thickness), 1)
    for pieces in range(2, 9):
        if length / pieces >= max(width, thickness):
            assert abs(level(name, (length, width, thickness), pieces) - whole) < 1


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.floats(0.5, 8), st.floats(0.02, 2), st.floats(0.02, 1), st.integers(2, 8))
def test_a_cut_over_the_whole_section_changes_nothing(length, width, thickness, pieces):
    """Of pieces at least half as long as they are wide, and as long as they are thick."""
    width, thickness = length * width, length * min(width, thickness)
    size = (pieces * length, width, thickness)
    assert level("steel", size, pieces) == pytest.approx(level("steel", size, 1), abs=1e-6)


@pytest.mark.parametrize("pieces", [2, 3, 4])
@pytest.mark.parametrize("thickness", [0.02, 0.1, 0.4])
@pytest.mark.parametrize("side", [2.1, 4.0, 8.0, 20.0, 50.0])
def test_a_plate_in_strips(side, thickness, pieces):
    size = (side, side, thickness)
    assert abs(level("concrete", size, pieces) - level("concrete", size, 1)) < 3.02


@pytest.mark.parametrize("joined", [0.25, 0.5, 0.8])
def test_a_joint_over_a_part_of_the_width_loses_that_part(joined):
    """10 lg of it: the energy that has filled the width goes through the joint and spreads again."""
    size = (24.0, 8.0, 0.1)
    lost = level("steel", size, 3) - level("steel", size, 3, joined)
    assert lost == pytest.approx(-2 * 10 * math.log10(joined), abs=1e-6)


@pytest.mark.parametrize("pieces", [2, 3, 4])
@pytest.mark.parametrize("thickness", [0.02, 0.1, 0.4])
def test_a_plate_of_four_metres_in_strips_joined_at_points(pieces, thickness):
    size = (4.0, 4.0, thickness)
    whole = level("concrete", size, 1)
    assert abs(level("concrete", size, pieces, joined=0.0) - whole) < 4


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.floats(1, 30), st.floats(0.1, 10), st.floats(0.1, 10), st.integers(2, 8))
def test_pieces_joined_at_points_begin_to_spread_again_once_in_each(
    length, width, thickness, pieces
):
    """Per piece 10 dB for every tenfold of the least size above the driven radius through the
    volume, and 5 dB over the surface beyond."""
    c, b, _ = sorted((length / pieces, width, thickness))
    most = 20 * math.log10(max(c, R0) / R0) + 10 * math.log10(max(b, c, R0) / max(c, R0))
    found, steel = (
        level("steel", (length, width, thickness), pieces, joined=0.0),
        physical("steel", (length / pieces, width, thickness)),
    )
    assert found >= -pieces * most - 8.7 * steel.material_damping(30.0) * length - 1e-9
