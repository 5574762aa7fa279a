"""Bit by bit the same result wherever the arrays lie in memory, however their elements are spaced
there, and whoever computes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from haptic_tracing.core.propagation import Propagation, propagate
from haptic_tracing.core.scene.functions import Exponential, HapticTracing, Spectrum
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
from path_reference import METRIC, OTHER, connected_scene

SEEDS = st.integers(0, 10**6)
OFFSETS = st.integers(1, 7).map(lambda words: 8 * words)
LIMITS = st.sampled_from([(None, 0.0), (32, 1e-3), (9, 0.0)])
STRATEGIES = st.sampled_from(list(Strategy))
BANDED = Exponential(
    alpha=0.3, spectrum=Spectrum(band_gains=(1.0, 0.9, 0.8, 0.7, 0.6, 0.5), wave_speed=340.0)
)


def moved(array: np.ndarray, offset: int) -> np.ndarray:
    """A copy whose first byte lies ``offset`` bytes beyond a multiple of 64."""
    raw = np.empty(array.nbytes + 128, dtype=np.uint8)
    begin = -raw.ctypes.data % 64 + offset
    copy = raw[begin : begin + array.nbytes].view(array.dtype).reshape(array.shape)
    copy[...] = array
    return copy


def spaced(array: np.ndarray) -> np.ndarray:
    """A copy of which no two elements are neighbours in memory."""
    copy = np.empty((*array.shape, 3), dtype=array.dtype)[..., 1]
    copy[...] = array
    return copy


def elsewhere(value, place):
    """The dataclass with all of its arrays at other places."""
    changed = {}
    for field in dataclasses.fields(value):
        part = getattr(value, field.name)
        if isinstance(part, np.ndarray):
            changed[field.name] = place(part)
        elif isinstance(part, ObjectTable):
            changed[field.name] = elsewhere(part, place)
    return dataclasses.replace(value, **changed)


def assert_same_bits(a: Propagation, b: Propagation) -> None:
    for key in ("gain", "limited", "paths", "band_gain", "delay"):
        one, other = getattr(a, key), getattr(b, key)
        assert (one is None) == (other is None)
        assert one is None or one.tobytes() == other.tobytes()
    assert dict(a.best_path) == dict(b.best_path)


def graph_from(scene: HapticScene, place) -> HapticGraph:
    table = ObjectTable.of(scene.objects, scene.settings.epsilon)
    contacts = elsewhere(ContactSet.from_contacts(scene.contacts, table.index()), place)
    return elsewhere(
        build_graph(elsewhere(table, place), contacts, scene.sources, scene.listeners), place
    )


@pytest.mark.slow
@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, STRATEGIES, LIMITS, OFFSETS, st.booleans())
def test_same_bits_at_every_offset(seed, strategy, limits, offset, bands):
    functions = (*METRIC, *OTHER, *([BANDED] if bands else []))
    scene = connected_scene(seed, functions, listeners=4, refined=True)
    chosen = Settings(strategy=strategy, max_connections=limits[0], threshold=limits[1])
    expected = propagate(graph_from(scene, np.copy), chosen)
    for place in (lambda array: moved(array, offset), spaced):
        assert_same_bits(propagate(graph_from(scene, place), chosen), expected)


def heap(count: int = 120) -> HapticScene:
    """Boxes on a ground, many of which touch each other."""
    random = np.random.default_rng(3)
    spots = random.uniform(0, 2, (count, 3))
    names = [f"box {k:03d}" for k in range(count)]
    boxes = [
        HapticObject(name, 0.1, 0.9, BANDED if k % 9 == 0 else HapticTracing())
        for k, name in enumerate(names)
    ]
    objects = [HapticObject("ground", 0.2, 0.9), *boxes]
    contacts = [
        Contact(("ground", name), (tuple(spot),) * 2)
        for name, spot in zip(names, spots.tolist(), strict=True)
    ]
    near = [
        (a, b) for a in range(count) for b in range(a) if np.linalg.norm(spots[a] - spots[b]) < 0.5
    ]
    contacts += [
        Contact((names[a], names[b]), (tuple(((spots[a] + spots[b]) / 2).tolist()),) * 2)
        for a, b in near
    ]
    sources = tuple(Source(f"s{k}", names[k], tuple(spots[k].tolist())) for k in range(3))
    listeners = tuple(
        Listener(f"l{k}", names[-1 - k], tuple(spots[-1 - k].tolist()), radius=0.0)
        for k in range(10)
    )
    return HapticScene(tuple(objects), tuple(contacts), sources, listeners)


@pytest.mark.slow
def test_same_bits_in_a_heap():
    scene = heap()
    for strategy in Strategy:
        chosen = Settings(strategy=strategy, threshold=0.1)
        expected = propagate(graph_from(scene, np.copy), chosen)
        assert np.count_nonzero(expected.gain) > 10
        for place in (
            *(lambda array, offset=offset: moved(array, offset) for offset in (8, 40)),
            spaced,
        ):
            assert_same_bits(propagate(graph_from(scene, place), chosen), expected)
