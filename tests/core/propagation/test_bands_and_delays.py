"""Bands and delays against the enumeration of all paths, each carrying its own."""

from __future__ import annotations

import dataclasses
import itertools
import math

import networkx
import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.connections import joined
from haptic_tracing.core.scene.bands import BAND_COUNT, BAND_EDGES
from haptic_tracing.core.scene.functions import Constant, Spectrum
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from haptic_tracing.core.signals import Sine
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene, meets, recursive_paths

SEEDS = st.integers(0, 10**6)
LIMITS = st.sampled_from([(None, 0.0), (32, 1e-3), (9, 0.0), (5, 1e-2)])


def filtered(scene: HapticScene, seed: int) -> HapticScene:
    """Spectra on some of the objects and contacts."""
    random = np.random.default_rng(seed)

    def spectrum() -> Spectrum:
        return Spectrum(
            band_gains=tuple(random.uniform(0, 1, BAND_COUNT).tolist())
            if random.random() < 0.5
            else (),
            band_decays=tuple(random.uniform(0, 2, BAND_COUNT).tolist())
            if random.random() < 0.5
            else (),
            wave_speed=float(random.choice([0.0, 5.0, 300.0])),
        )

    return dataclasses.replace(
        scene,
        objects=tuple(
            dataclasses.replace(
                o, propagation=dataclasses.replace(o.propagation, spectrum=spectrum())
            )
            for o in scene.objects
        ),
        contacts=tuple(
            dataclasses.replace(
                c, transmission=dataclasses.replace(c.transmission, spectrum=spectrum())
            )
            for c in scene.contacts
        ),
    )


def carried(
    scene: HapticScene, graph: HapticGraph, path: tuple[int, ...]
) -> tuple[np.ndarray, float]:
    """Band gains (relative) and delay of a path, from the scene's own values."""
    by_name = {o.name: o for o in scene.objects}
    bands, delay = np.ones(BAND_COUNT), 0.0
    for a, b in itertools.pairwise(path):
        distance = math.dist(graph.node_position[a], graph.node_position[b])
        if graph.partner[a] == b:
            names = frozenset(graph.table.names[graph.node_object[n]] for n in (a, b))
            places = {tuple(graph.node_position[n].tolist()) for n in (a, b)}
            spectrum = next(
                c.transmission.spectrum
                for c in scene.contacts
                if frozenset(c.objects) == names and set(c.positions) == places
            )
        else:
            spectrum = by_name[graph.table.names[graph.node_object[a]]].propagation.spectrum
        bands = bands * np.array(spectrum.band_gains or (1.0,) * BAND_COUNT)
        bands = bands * np.exp(-np.array(spectrum.band_decays or (0.0,) * BAND_COUNT) * distance)
        delay += distance / spectrum.wave_speed if spectrum.wave_speed else 0.0
    return bands, delay


@pytest.mark.slow
@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_sums_per_band_and_taps(seed, limits):
    scene = filtered(connected_scene(seed, (*METRIC[:3], *OTHER), extra=3), seed)
    graph = graph_of_scene(scene)
    chosen = Settings(
        strategy=Strategy.ALL_PATHS, max_connections=limits[0], threshold=limits[1], tolerance=0.0
    )
    result = propagate(graph, chosen)
    for column in range(len(graph.listeners)):
        kept = [
            (math.prod(gains), *carried(scene, graph, path))
            for path, gains in recursive_paths(graph, 0, column)
            if meets(gains, *limits) and math.prod(gains) > 0
        ]
        assert result.gain[0, column] == pytest.approx(
            math.fsum(gain for gain, _, _ in kept), rel=1e-9
        )
        if result.band_gain is not None:
            expected = sum((gain * bands for gain, bands, _ in kept), np.zeros(BAND_COUNT))
            assert np.allclose(result.band_gain[0, column], expected, rtol=1e-9, atol=1e-300)
        if result.delay is not None:
            taps = result.taps.get((0, column), ())
            strongest = sorted((gain for gain, _, _ in kept), reverse=True)[: len(taps)]
            assert len(taps) == min(len(kept), 8)
            assert [gain for _, gain in taps] == pytest.approx(strongest, rel=1e-9)
            remaining = [(gain, delay) for gain, _, delay in kept]
            for delay, gain in taps:
                match = next(
                    k
                    for k in remaining
                    if k
                    == (pytest.approx(gain, rel=1e-9), pytest.approx(delay, rel=1e-9, abs=1e-15))
                )
                remaining.remove(match)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS)
def test_best_path_carries_its_own(seed):
    scene = filtered(connected_scene(seed, METRIC[:3]), seed)
    graph = graph_of_scene(scene)
    result = propagate(
        graph, Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0)
    )
    for pair, path in result.best_path.items():
        bands, delay = carried(scene, graph, path)
        if result.band_gain is not None:
            assert np.allclose(result.band_gain[pair], result.gain[pair] * bands, rtol=1e-9)
        if result.delay is not None:
            assert result.delay[pair] == pytest.approx(delay, rel=1e-9, abs=1e-15)
            assert result.taps[pair] == (
                (pytest.approx(delay, abs=1e-15, rel=1e-9), result.gain[pair]),
            )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS)
def test_energies_per_band(seed):
    """Bands that all pass are the plain energy; bands that weaken give less."""
    plain = connected_scene(seed, METRIC[:3])
    graph = graph_of_scene(plain)
    whole = propagate(graph, Settings(strategy=Strategy.ENERGY_BALANCE))
    assert whole.band_gain is None
    assert whole.delay is None

    def with_bands(*gains: float) -> HapticScene:
        spectrum = Spectrum(band_gains=gains)
        objects = tuple(
            dataclasses.replace(
                o, propagation=dataclasses.replace(o.propagation, spectrum=spectrum)
            )
            for o in plain.objects
        )
        return dataclasses.replace(plain, objects=objects)

    result = propagate(
        graph_of_scene(with_bands(1.0, 0.9, 0.5, 0.2, 0.01, 0.0)),
        Settings(strategy=Strategy.ENERGY_BALANCE),
    )
    assert result.band_gain is not None
    assert np.allclose(result.gain, whole.gain, rtol=1e-12)
    assert np.allclose(result.band_gain[..., 0], whole.gain, rtol=1e-12)
    assert np.all(np.diff(result.band_gain, axis=-1) <= 1e-12)
    assert np.all(result.band_gain[..., -1] == 0)


@pytest.mark.slow
@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS)
def test_best_path_is_the_best_of_the_band_in_which_its_source_is_strong(seed):
    """Against the enumeration of all paths, for sources of several bands at once, from sources and
    from listeners."""
    scene = filtered(connected_scene(seed, METRIC[:3]), seed)
    random = np.random.default_rng(seed + 1)
    frequencies = random.choice([30.0, 57.0, 113.0, 226.0, 453.0, 800.0], 3)
    first, at = scene.sources[0], scene.listeners[0]
    sources = tuple(
        dataclasses.replace(first, name=f"s{k}", signal=Sine(f)) for k, f in enumerate(frequencies)
    )
    scene = dataclasses.replace(
        scene, sources=sources, listeners=scene.listeners if seed % 2 else (at,)
    )
    graph = graph_of_scene(scene)
    if not graph.uses_bands:
        return
    result = propagate(
        graph, Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0)
    )
    for row, frequency in enumerate(frequencies):
        band = int(np.searchsorted(BAND_EDGES, frequency, side="right")) - 1
        assert graph.sources[row].band == band
        for column in range(len(graph.listeners)):
            every = [
                math.prod(gains) * carried(scene, graph, path)[0][band]
                for path, gains in recursive_paths(graph, row, column)
            ]
            found = 0.0 if result.band_gain is None else result.band_gain[row, column, band]
            assert found == pytest.approx(max(every, default=0.0), rel=1e-9, abs=1e-300)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 40), st.floats(0, 1.5))
def test_what_hangs_together_by_contacts(seed, count, degree):
    random = np.random.default_rng(seed)
    names = [f"{number:02d}" for number in range(count)]
    pairs = [
        tuple(random.choice(names, 2, replace=False).tolist())
        for _ in range(int(degree * count))
        if count > 1
    ]
    contacts = tuple(
        Contact(pair, ((0.0, 0.0, float(k)), (0.0, 0.0, float(k)))) for k, pair in enumerate(pairs)
    )
    ends = (
        tuple(Source(f"s {name}", name) for name in names),
        tuple(Listener(f"l {name}", name) for name in names),
    )
    graph = graph_of_scene(
        HapticScene(tuple(HapticObject(name, 0.1, 0.9) for name in names), contacts, *ends)
    )
    expected = networkx.Graph(pairs)
    expected.add_nodes_from(names)
    wanted = random.integers(0, count, (random.integers(0, 9), 2))
    assert joined(graph, wanted).tolist() == [
        networkx.has_path(expected, names[a], names[b]) for a, b in wanted.tolist()
    ]


def test_what_only_low_frequencies_carry_still_arrives():
    """At 453 Hz, in which the source is strong, nothing meets the threshold; by the plain gain a
    path does."""
    spectrum = Spectrum(band_decays=(0.0, 0.0, 0.0, 0.0, 5.0, 5.0))
    wall = HapticObject("wall", 0.1, 0.9, propagation=Constant(gain_value=0.5, spectrum=spectrum))
    scene = HapticScene(
        (wall,),
        (),
        (Source("s", "wall", signal=Sine(453.0)),),
        (Listener("l", "wall", (2.0, 0.0, 0.0), radius=0.0),),
    )
    result = propagate(graph_of_scene(scene), Settings(threshold=1e-3))
    assert result.gain[0, 0] == pytest.approx(0.5)
    assert result.band_gain[0, 0].tolist() == pytest.approx([0.5] * 4 + [0.5 * math.exp(-10.0)] * 2)
