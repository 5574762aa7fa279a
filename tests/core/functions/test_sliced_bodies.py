"""Bodies of one piece and of several that touch: how far a cut changes what arrives at the other
end."""

from __future__ import annotations

import itertools
import math

import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import physical
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st

R0 = 0.5
"""Radius of the area that a source drives, as `physical` has it."""


def level(name: str, size: tuple[float, float, float], pieces: int) -> float:
    """Level [dB] at the far end of a body that is cut across its first size into pieces, which
    touch over their faces."""
    material, length = MATERIALS[name], size[0] / pieces
    function = physical(name, (length, *size[1:]))
    objects = tuple(
        HapticObject(f"piece {k:02d}", material.kappa, material.rho, function)
        for k in range(pieces)
    )
    contacts = tuple(
        Contact((one.name, other.name), (((k + 1) * length, 0, 0), ((k + 1) * length, 0, 0)))
        for k, (one, other) in enumerate(itertools.pairwise(objects))
    )
    ends = (
        (Source("s", objects[0].name),),
        (Listener("l", objects[-1].name, (size[0], 0, 0), radius=0.0),),
    )
    result = propagate(
        graph_of_scene(HapticScene(objects, contacts, *ends)), Settings(threshold=0.0)
    )
    return 20 * math.log10(result.gain[0, 0])


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


@pytest.mark.parametrize("pieces", [2, 3, 4])
@pytest.mark.parametrize("thickness", [0.02, 0.1, 0.4])
def test_a_plate_of_four_metres_in_strips(pieces, thickness):
    assert (
        abs(
            level("concrete", (4.0, 4.0, thickness), pieces)
            - level("concrete", (4.0, 4.0, thickness), 1)
        )
        < 4
    )


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.floats(1, 30), st.floats(0.1, 10), st.floats(0.1, 10), st.integers(2, 8))
def test_thicker_pieces_begin_to_spread_again_once_in_each(length, width, thickness, pieces):
    """Per piece 10 dB for every tenfold of the least size above the driven radius through the
    volume, and 5 dB over the surface beyond."""
    c, b, _ = sorted((length / pieces, width, thickness))
    most = 20 * math.log10(max(c, R0) / R0) + 10 * math.log10(max(b, c, R0) / max(c, R0))
    found, steel = (
        level("steel", (length, width, thickness), pieces),
        physical("steel", (length / pieces, width, thickness)),
    )
    assert found >= -pieces * most - 8.7 * steel.material_damping(30.0) * length - 1e-9
