"""Refined patches: the points of a patch are one contact at their share-weighted centre, in every
strategy."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import objects_on, propagate
from haptic_tracing.core.propagation.spread import spread
from haptic_tracing.core.scene.functions import Constant, Exponential, Identity, Spectrum
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, connected_scene

BEST = Settings(threshold=0.0)
WAVES = Spectrum(band_gains=(1.0, 0.9, 0.8, 0.6, 0.4, 0.2), wave_speed=300.0)


def refined(
    scene: HapticScene, points: int, size: float, seed: int
) -> tuple[HapticScene, HapticScene]:
    """The scene with each contact as the points of a patch, of any shares; and with each patch as
    one contact at its centre."""
    random = np.random.default_rng(seed)
    patches, centres = [], []
    pairs = set()
    for contact in scene.contacts:
        if frozenset(contact.objects) in pairs:
            continue  # two patches of one pair of objects count as one
        pairs.add(frozenset(contact.objects))
        shares = random.dirichlet(np.ones(points))
        offsets = random.uniform(-size, size, (points, 3))
        for offset, share in zip(offsets, shares.tolist(), strict=True):
            places = tuple(map(tuple, (np.array(contact.positions) + offset).tolist()))
            point = dataclasses.replace(contact, positions=places, share=share, area=share * 0.02)
            if random.random() < 0.5:
                normal = tuple(-x for x in point.normal)
                point = dataclasses.replace(
                    point, objects=point.objects[::-1], positions=places[::-1], normal=normal
                )
            patches.append(point)
        centre = tuple(map(tuple, (np.array(contact.positions) + shares @ offsets).tolist()))
        centres.append(dataclasses.replace(contact, positions=centre, area=0.02))
    random.shuffle(patches)
    return dataclasses.replace(scene, contacts=tuple(patches)), dataclasses.replace(
        scene, contacts=tuple(centres)
    )


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(2, 5), st.sampled_from(list(Strategy)))
def test_points_of_a_patch_are_one_contact_at_their_centre(seed, points, strategy):
    through = (Constant(gain_value=0.9, spectrum=WAVES),)
    scene = connected_scene(
        seed, (*METRIC, Exponential(alpha=0.3, spectrum=WAVES)), through, listeners=3
    )
    fine, coarse = (graph_of_scene(item) for item in refined(scene, points, 0.3, seed))
    assert fine.contact_count == coarse.contact_count
    one, other = (
        propagate(graph, dataclasses.replace(BEST, strategy=strategy)) for graph in (fine, coarse)
    )
    np.testing.assert_allclose(one.gain, other.gain, rtol=1e-10)
    if one.delay is not None:
        np.testing.assert_allclose(one.delay, other.delay, rtol=1e-10)


def test_the_contact_of_a_patch_has_the_means_of_its_points_and_their_whole_area():
    half, most = Constant(gain_value=0.5), Constant(gain_value=0.25)
    points = (
        Contact(
            ("a", "b"), ((0, 0, 0), (0, 0, 1)), half, 0.1, (0, 0, 1), 0.002, share=0.25, weight=1.0
        ),
        Contact(
            ("b", "a"), ((4, 0, 1), (4, 0, 0)), most, 0.3, (0, 0, -1), 0.004, share=0.75, weight=0.5
        ),
        Contact(("a", "c"), ((7, 0, 0), (7, 0, 0)), share=1.0),
        Contact(("a", "c"), ((8, 0, 0), (8, 0, 0)), share=1.0),
        Contact(("b", "c"), ((9, 0, 0), (9, 0, 0)), half, share=0.5),
    )
    found = sorted(
        ContactSet.from_contacts(points, {"a": 0, "b": 1, "c": 2}).to_contacts("abc"),
        key=lambda item: item.positions,
    )
    expected = Contact(
        ("a", "b"), ((3, 0, 0), (3, 0, 1)), most, 0.4, (0, 0, 1), 0.0035, weight=0.625
    )
    assert found[0].objects in (("a", "b"), ("b", "a"))
    if found[0].objects == ("b", "a"):
        expected = dataclasses.replace(
            expected, objects=("b", "a"), positions=expected.positions[::-1], normal=(0, 0, -1)
        )
    assert (
        found[0].positions == expected.positions
        and found[0].normal == expected.normal
        and found[0].transmission == most
    )
    assert [found[0].area, found[0].depth, found[0].weight] == pytest.approx(
        [0.4, 0.0035, 0.625], rel=1e-15
    )
    assert [item.positions[0][0] for item in found[1:]] == [7, 8, 9] and found[
        3
    ].transmission == half


def test_points_without_a_share_have_a_centre_too():
    points = [Contact(("a", "b"), ((x, 0, 0), (x, 0, 0)), share=0.0) for x in (0.0, 1.0)]
    assert ContactSet.from_contacts(points, {"a": 0, "b": 1}).positions.tolist() == [
        [[0.5, 0, 0], [0.5, 0, 0]]
    ]


def plank_on_soil(points: int) -> HapticScene:
    """A plank that carries far lies on soil that doesn't; source and listener on the soil, at its
    ends."""
    x = np.linspace(-2, 2, points).tolist()
    contacts = tuple(
        Contact(("plank", "soil"), ((v, 0, 0), (v, 0, 0)), share=1 / points) for v in x
    )
    objects = (
        HapticObject("plank", 0, 1, Identity()),
        HapticObject("soil", 0, 1, Exponential(alpha=2.0)),
    )
    return HapticScene(
        objects,
        contacts,
        (Source("s", "soil", (-2, 0, 0)),),
        (Listener("l", "soil", (2, 0, 0), radius=0.0),),
    )


@pytest.mark.parametrize("strategy", list(Strategy))
def test_no_path_goes_in_by_one_point_and_out_by_another(strategy):
    graph = graph_of_scene(plank_on_soil(9))
    result = propagate(graph, dataclasses.replace(BEST, strategy=strategy))
    assert result.gain[0, 0] == pytest.approx(math.exp(-8), rel=1e-12)
    assert objects_on(graph, result.best_path[0, 0]) == ("soil",)
    shown = spread(graph)
    assert shown.amplitude[graph.listener_nodes[0]] == pytest.approx(math.exp(-8), rel=1e-12)
