"""Bands and delays against the enumeration of all paths, each carrying its own."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.bands import BAND_COUNT, BAND_EDGES
from haptic_tracing.core.scene.functions import Constant, Spectrum
from haptic_tracing.core.scene.values import (
    HapticObject,
    HapticScene,
    Listener,
    Mode,
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
def test_sums_per_band(seed, limits):
    scene = filtered(connected_scene(seed, (*METRIC[:3], *OTHER), extra=3), seed)
    graph = graph_of_scene(scene)
    chosen = Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, *limits)
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


@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS)
def test_best_path_carries_its_own(seed):
    scene = filtered(connected_scene(seed, METRIC[:3]), seed)
    graph = graph_of_scene(scene)
    result = propagate(graph, Settings())
    for pair, path in result.best_path.items():
        bands, delay = carried(scene, graph, path)
        if result.band_gain is not None:
            assert np.allclose(result.band_gain[pair], result.gain[pair] * bands, rtol=1e-9)
        if result.delay is not None:
            assert result.delay[pair] == pytest.approx(delay, rel=1e-9, abs=1e-15)


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
    result = propagate(graph, Settings())
    for row, frequency in enumerate(frequencies):
        band = int(np.searchsorted(BAND_EDGES, frequency, side="right")) - 1
        assert graph.sources[row].band == band
        for column in range(len(graph.listeners)):
            every = [
                math.prod(gains) * carried(scene, graph, path)[0][band]
                for path, gains in recursive_paths(graph, row, column)
            ]
            found = 0.0 if result.band_gain is None else result.band_gain[row, column, band]
            best = max(every, default=0.0)
            if best >= 1e-6:
                assert found == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("decay", [5.0, 10.0])
def test_what_only_low_frequencies_carry_still_arrives(decay):
    """At 453 Hz, in which the source is strong, -87 dB or -174 dB arrive; other bands still do."""
    spectrum = Spectrum(band_decays=(0.0, 0.0, 0.0, 0.0, decay, decay))
    wall = HapticObject("wall", 0.1, 0.9, propagation=Constant(gain_value=0.5, spectrum=spectrum))
    scene = HapticScene(
        (wall,),
        (),
        (Source("s", "wall", signal=Sine(453.0)),),
        (Listener("l", "wall", (2.0, 0.0, 0.0), radius=0.0),),
    )
    result = propagate(graph_of_scene(scene), Settings())
    assert result.gain[0, 0] == pytest.approx(0.5)
    expected = [0.5] * 4 + [0.5 * math.exp(-2 * decay)] * 2
    assert result.band_gain[0, 0].tolist() == pytest.approx(expected)
