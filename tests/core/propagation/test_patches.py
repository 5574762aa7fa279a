"""Refined patches: a contact given by the points of its patch, against the same contact at the share-weighted centre."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.contact_patches import merge_patches
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import objects_on, propagate
from haptic_tracing.core.propagation.spread import spread
from haptic_tracing.core.scene.functions import Constant, Exponential, HapticTracing, Identity, Spectrum
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener, Pose, Settings, Source, Strategy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene, meets, recursive_paths

SEEDS = st.integers(0, 10**6)
BEST = Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0)
WAVES = Spectrum(band_gains=(1.0, 0.9, 0.8, 0.6, 0.4, 0.2), wave_speed=300.0)


def refined(scene: HapticScene, points: int, size: float, seed: int) -> tuple[HapticScene, HapticScene]:
    """The scene with each contact as the points of a patch, of any shares; and with each patch as one contact at its centre."""
    random = np.random.default_rng(seed)
    patches, centres = [], []
    pairs = set()
    for contact in scene.contacts:
        if frozenset(contact.objects) in pairs:
            continue  # two patches of one pair of objects count as one
        pairs.add(frozenset(contact.objects))
        shares = random.dirichlet(np.ones(points))
        offsets = random.uniform(-size, size, (points, 3))
        places = [tuple(map(tuple, (np.array(contact.positions) + offset).tolist())) for offset in offsets]
        patches += [dataclasses.replace(contact, positions=p, share=float(s)) for p, s in zip(places, shares, strict=True)]
        centre = np.array(contact.positions) + shares @ offsets
        centres.append(dataclasses.replace(contact, positions=tuple(map(tuple, centre.tolist()))))
    return dataclasses.replace(scene, contacts=tuple(patches)), dataclasses.replace(scene, contacts=tuple(centres))


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS, st.integers(2, 5), st.booleans(), st.sampled_from([None, 3, 5, 7]))
@example(13098, 2, False, None)  # a source on two objects, whose paths are equally strong
def test_best_path_takes_a_patch_as_one_contact_at_its_centre(seed, points, waves, most):
    functions = (*METRIC, *OTHER, *([Exponential(alpha=0.3, spectrum=WAVES)] if waves else []))
    scene = connected_scene(seed, functions, (Constant(gain_value=0.9, spectrum=WAVES if waves else Spectrum()),), listeners=3)
    fine, coarse = (graph_of_scene(item) for item in refined(scene, points, 0.3, seed))
    chosen = dataclasses.replace(BEST, max_connections=most)
    one, other = propagate(fine, chosen), propagate(coarse, chosen)
    assert np.allclose(one.gain, other.gain, rtol=1e-12, atol=0)
    tied = set()
    for column in range(len(coarse.listeners)):
        products = [math.prod(gains) for _, gains in recursive_paths(coarse, 0, column) if meets(gains, most, 0.0)]
        assert one.gain[0, column] == pytest.approx(max(products, default=0.0), rel=1e-9, abs=0)
        if sum(product >= (1 - 1e-12) * max(products) for product in products) > 1:
            tied.add((0, column))  # either path is the best one
    for key in ("band_gain", "delay"):
        first, second = getattr(one, key), getattr(other, key)
        assert (first is None) == (second is None)
        assert first is None or np.allclose(first, second, rtol=1e-12, atol=0)
    assert one.best_path.keys() == other.best_path.keys()
    for pair, nodes in one.best_path.items():
        assert pair in tied or objects_on(fine, nodes) == objects_on(coarse, other.best_path[pair])
        assert all(fine.partner[a] == b for a, b in itertools.pairwise(nodes[1:-1]) if fine.node_object[a] != fine.node_object[b])


def metre_boxes(shape: tuple[int, int, int], seed: int, offsets: np.ndarray) -> HapticScene:
    """Boxes of 1 m side by side, each face that two have in common given by points at ``offsets`` (n, 2) from its middle, of equal shares.
    A source in the first, a listener in each other one."""
    random = np.random.default_rng(seed)
    cells = [np.array(cell) for cell in itertools.product(*map(range, shape))]
    names = {tuple(cell): f"b{number}" for number, cell in enumerate(cells)}
    boxes = tuple(HapticObject(name, *random.uniform([0.1, 0.5], [0.5, 0.9]).tolist(), shape=Box((1, 1, 1))) for name in names.values())
    boxes = tuple(dataclasses.replace(box, pose=Pose(tuple(cell.tolist()))) for box, cell in zip(boxes, cells, strict=True))
    contacts = []
    for cell, axis in itertools.product(cells, range(3)):
        beside = cell + np.eye(3, dtype=np.int64)[axis]
        if tuple(beside) in names:
            points = np.insert(offsets, axis, 0.0, axis=1) + (cell + beside) / 2
            pair = names[tuple(cell)], names[tuple(beside)]
            contacts += [Contact(pair, (point, point), share=1 / len(points)) for point in map(tuple, points.tolist())]
    inside = [tuple((cell + random.uniform(-0.4, 0.4, 3)).tolist()) for cell in cells]
    ends = list(zip(names.values(), inside, strict=True))
    return HapticScene(boxes, tuple(contacts), (Source("s", *ends[0]),), tuple(Listener(f"l {name}", name, at) for name, at in ends[1:]))


def levels(scene: HapticScene, strategy: Strategy) -> np.ndarray:
    """In dB, without limits."""
    result = propagate(graph_of_scene(scene), dataclasses.replace(BEST, strategy=strategy, tolerance=0.0))
    return 20 * np.log10(result.gain[0])


CORNERS = np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)]) / 2
MIDDLE = np.zeros((1, 2))


@pytest.mark.parametrize("shape", [(3, 1, 1), (3, 2, 1), (2, 2, 2)])
@pytest.mark.parametrize("seed", range(3))
def test_corners_of_a_patch_of_10_cm_between_boxes_of_a_metre(shape, seed):
    for strategy, allowed in ((Strategy.BEST_PATH, 1e-9), (Strategy.ENERGY_BALANCE, 1e-9), (Strategy.ALL_PATHS, 0.5)):
        coarse, fine = (levels(metre_boxes(shape, seed, offsets), strategy) for offsets in (MIDDLE, 0.1 * CORNERS))
        assert np.abs(fine - coarse).max() < allowed


@pytest.mark.parametrize("shape", [(3, 1, 1), (2, 2, 1)])
def test_points_all_over_a_face_converge(shape):
    """Faces divided into equal squares: the middle of the face gives what many points give, or comes near; best path and balance to
    rounding."""
    for strategy, allowed in ((Strategy.BEST_PATH, 1e-9), (Strategy.ENERGY_BALANCE, 1e-9), (Strategy.ALL_PATHS, 3.0)):
        found = []
        for divisions in (1, 2, 4):
            along = (np.arange(divisions) + 0.5) / divisions - 0.5
            found.append(levels(metre_boxes(shape, 1, np.array(list(itertools.product(along, along)))), strategy))
        first, second = np.abs(np.diff(found, axis=0)).max(axis=1)
        assert np.abs(found[-1] - found[0]).max() < allowed
        assert second <= max(first / 2, 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_contact_points_of_a_face_agree_with_its_middle_and_with_many_points(seed):
    """Faces of a metre as they are detected: sums with a few points differ from those over the face by less than 0.5 dB."""
    middle = metre_boxes((3, 1, 1), seed, MIDDLE)
    found = contacts_of_scene(dataclasses.replace(middle, contacts=()), patch_points=True)
    names = [item.name for item in middle.objects]
    contacts = tuple(
        Contact((names[a], names[b]), (tuple(first), tuple(second)), share=share)
        for (a, b), (first, second), share in zip(found.pairs.tolist(), found.positions.tolist(), found.share.tolist(), strict=True)
    )
    detected = dataclasses.replace(middle, contacts=contacts)
    assert len(contacts) == 8
    for strategy, allowed in ((Strategy.BEST_PATH, 1e-4), (Strategy.ENERGY_BALANCE, 1e-4), (Strategy.ALL_PATHS, 3.0)):
        assert np.abs(levels(detected, strategy) - levels(middle, strategy)).max() < allowed
    along = (np.arange(6) + 0.5) / 6 - 0.5
    face = metre_boxes((3, 1, 1), seed, np.array(list(itertools.product(along, along))))
    assert np.abs(levels(detected, Strategy.ALL_PATHS) - levels(face, Strategy.ALL_PATHS)).max() < 0.5


def plank_on_soil(points: int) -> HapticScene:
    """A plank that carries far lies on soil that doesn't; source and listener on the soil, at its ends."""
    x = np.linspace(-2, 2, points).tolist()
    contacts = tuple(Contact(("plank", "soil"), ((v, 0, 0), (v, 0, 0)), share=1 / points) for v in x)
    objects = (HapticObject("plank", 0, 1, Identity()), HapticObject("soil", 0, 1, Exponential(alpha=2.0)))
    return HapticScene(objects, contacts, (Source("s", "soil", (-2, 0, 0)),), (Listener("l", "soil", (2, 0, 0)),))


@pytest.mark.parametrize("strategy", [Strategy.BEST_PATH, Strategy.ALL_PATHS])
def test_no_path_goes_in_by_one_point_and_out_by_another(strategy):
    graph = graph_of_scene(plank_on_soil(9))
    result = propagate(graph, dataclasses.replace(BEST, strategy=strategy))
    assert result.gain[0, 0] == pytest.approx(math.exp(-8), rel=1e-12)
    assert objects_on(graph, result.best_path[0, 0]) == ("soil",)
    shown = spread(graph, BEST)
    assert shown.gain[graph.listener_nodes[0]] == pytest.approx(math.exp(-8), rel=1e-12)


@pytest.mark.slow
@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS)
def test_delay_taps_are_the_strongest_paths_with_their_shares(seed):
    scene = connected_scene(seed, (Exponential(alpha=0.3, spectrum=WAVES), HapticTracing()), most_objects=4, extra=1, listeners=2)
    graph = graph_of_scene(refined(scene, 2, 0.3, seed)[0])
    result = propagate(graph, Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0))
    if result.delay is None:
        return
    for column in range(len(graph.listeners)):
        taps = [gain for _, gain in result.taps.get((0, column), ())]
        products = []
        for path, gains in recursive_paths(graph, 0, column):
            crossed = [node for node, other in itertools.pairwise(path) if graph.partner[node] == other]
            pairs = [frozenset(graph.node_object[[node, graph.partner[node]]].tolist()) for node in crossed]
            if len(set(pairs)) == len(pairs):
                products.append(math.prod(gains) * math.prod(float(graph.share[graph.contact[node]]) for node in crossed))
        expected = sorted((gain for gain in products if gain > 0), reverse=True)[: len(taps)]
        assert len(taps) == min(8, sum(gain > 0 for gain in products))
        assert taps == pytest.approx(expected, rel=1e-9)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS)
def test_merging_keeps_what_is_no_refined_patch(seed):
    """Nodes keep their objects and kinds, every node has one that stands for it, and a graph without refined patches stays itself."""
    scene = connected_scene(seed, METRIC, listeners=3)
    plain = graph_of_scene(scene)
    assert merge_patches(plain).graph is plain
    graph = graph_of_scene(refined(scene, 4, 0.2, seed)[0])
    patches = merge_patches(graph)
    merged = patches.graph
    assert merged.contact_count == len({frozenset(contact.objects) for contact in scene.contacts})
    assert (merged.node_object == graph.node_object[patches.node]).all()
    assert (merged.node_kind == graph.node_kind[patches.node]).all()
    assert (merged.node_object[patches.merged] == graph.node_object).all()
    assert (patches.merged[patches.node] == np.arange(merged.node_count)).all()
    crossed = np.flatnonzero(merged.partner >= 0)
    assert (merged.partner[merged.partner[crossed]] == crossed).all()
    assert (patches.merged[graph.partner[patches.node[crossed]]] == merged.partner[crossed]).all()
    assert np.diff(merged.start).tolist() == np.bincount(merged.node_object, minlength=len(merged.table.names)).tolist()
