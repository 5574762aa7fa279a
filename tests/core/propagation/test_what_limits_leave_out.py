"""Error bounds of what a threshold, a limit of connections or a setting cuts away: never 0 where
the result without limits differs."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.formats.scene.scene_json import write_scene
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Constant, HapticTracing, Spectrum
from haptic_tracing.core.scene.values import (
    Contact,
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
from path_reference import METRIC, OTHER, connected_scene

HERE = (0.0, 0.0, 0.0)
ALONE = HapticObject("alone", 0.1, 0.9)


def chain(count: int, gain: float, amplitude: float = 1.0) -> HapticScene:
    """Objects with one gain each; a listener at the last one, and one at an object that nothing
    touches."""
    objects = tuple(
        HapticObject(f"o{k}", 0.0, 1.0, Constant(gain_value=gain)) for k in range(count)
    )
    contacts = tuple(
        Contact((one.name, other.name), (HERE, HERE)) for one, other in itertools.pairwise(objects)
    )
    listeners = Listener("end", objects[-1].name), Listener("away", "alone")
    return HapticScene(
        (*objects, ALONE), contacts, (Source("s", "o0", amplitude=amplitude),), listeners
    )


@pytest.mark.parametrize("strategy", [Strategy.AUTO, Strategy.BEST_PATH])
def test_a_path_below_the_threshold_has_the_threshold_as_its_bound(strategy):
    graph = graph_of_scene(chain(3, 0.2))
    found = propagate(graph, Settings(strategy=strategy, threshold=0.01))
    assert (found.gain[0, 0], found.error_bound[0, 0], found.limited[0, 0]) == (0.0, 0.01, True)
    # No contact leads there.
    assert (found.gain[0, 1], found.error_bound[0, 1], found.limited[0, 1]) == (0.0, 0.0, False)
    found = propagate(graph, Settings(strategy=strategy, threshold=0.001))
    assert found.gain[0, 0] == pytest.approx(0.008, rel=1e-14)
    assert (found.error_bound[0, 0], found.limited[0, 0]) == (0.0, False)


def test_a_path_of_too_many_connections_is_known():
    graph = graph_of_scene(chain(3, 0.2))
    for most, bound in ((5, 0.0), (4, 0.008), (1, 0.008), (0, 1.0)):
        found = propagate(graph, Settings(strategy=Strategy.BEST_PATH, max_connections=most))
        assert found.error_bound[0].tolist() == pytest.approx([bound, 0.0], rel=1e-14)
        assert found.limited[0].tolist() == [bound > 0, False]


@pytest.mark.parametrize("most", [None, 4, 0])
def test_a_sum_is_exact_where_no_contacts_lead(most):
    found = propagate(
        graph_of_scene(chain(3, 0.2)),
        Settings(strategy=Strategy.ALL_PATHS, max_connections=most, threshold=0.01),
    )
    assert found.limited[0].tolist() == [True, False]
    assert found.error_bound[0, 1] == 0
    assert found.error_bound[0, 0] >= 0.008 * (1 - 1e-12)


def test_a_straight_way_below_the_threshold_is_known():
    scene = chain(1, 1.0)
    scene = replace(scene, listeners=(Listener("l", "o0", (3.0, 0.0, 0.0)),))
    for mode, gain in ((Mode.MD, math.exp(-0.6)), (Mode.MN, 1.0)):
        for limits in ({"threshold": 0.7}, {"max_connections": 0}):
            found = propagate(graph_of_scene(scene), Settings(mode=mode, **limits))
            cut = mode is Mode.MD or "max_connections" in limits
            assert found.limited[0, 0] == cut
            assert found.error_bound[0, 0] == (pytest.approx(gain, rel=1e-14) if cut else 0)


def banded(seed: int, refined: bool = False) -> HapticScene:
    """Random objects whose gains in the six bands differ, some that are no metric, two sources with
    tones in two bands, and a listener with a volume."""
    random = np.random.default_rng(seed)
    scene = connected_scene(seed, (*METRIC, *OTHER), extra=4, listeners=3, refined=refined)
    gains = random.uniform(0.01, 1.0, (len(scene.objects), 6)).tolist()
    objects = tuple(
        item
        if item.propagation in OTHER
        else replace(item, propagation=HapticTracing(spectrum=Spectrum(band_gains=tuple(band))))
        for item, band in zip(scene.objects, gains, strict=True)
    )
    sources = tuple(
        replace(scene.sources[0], name=f"s{f}", signal=Sine(frequency=f)) for f in (30.0, 200.0)
    )
    first, *others = scene.listeners
    return replace(
        scene,
        objects=objects,
        sources=sources,
        listeners=(replace(first, radius=0.3, extent="mean_power"), *others),
    )


LIMITS = st.sampled_from(
    [(None, 0.001), (None, 0.1), (None, 0.5), (3, 0.0), (3, 0.1), (1, 0.3), (0, 0.0)]
)
SEEDS = st.integers(0, 10**6)


def assert_bounded(scene: HapticScene, chosen: Settings, limits: tuple[int | None, float]) -> None:
    """The gains without limits lie within the bounds of those with limits."""
    graph = graph_of_scene(scene)
    free = propagate(graph, replace(chosen, max_connections=None, threshold=0.0), 10**7)
    found = propagate(graph, replace(chosen, max_connections=limits[0], threshold=limits[1]))
    assert np.array_equal(found.silenced, free.silenced)
    heard = ~free.silenced
    assert np.isinf(found.error_bound[~heard]).all() and not found.gain[~heard].any()
    assert (
        np.abs(free.gain - found.gain) <= found.error_bound + free.error_bound + 1e-9 * free.gain
    )[heard].all()


@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS, LIMITS, st.sampled_from([0.0, 0.4, 1.0]), st.sampled_from(list(Mode)))
def test_best_paths_chosen_by_band(seed, limits, localise, mode):
    assert_bounded(
        banded(seed), Settings(strategy=Strategy.BEST_PATH, localise=localise, mode=mode), limits
    )


@pytest.mark.slow
@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    SEEDS, LIMITS, st.sampled_from([Strategy.ALL_PATHS, Strategy.AS_IN_THE_PAPER]), st.booleans()
)
def test_sums(seed, limits, strategy, by_band):
    scene = (
        banded(seed)
        if by_band
        else connected_scene(seed, (*METRIC[:4], *OTHER), extra=4, listeners=3)
    )
    assert_bounded(scene, Settings(strategy=strategy, tolerance=0.0), limits)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_functions_that_are_no_metric_and_patches(seed, limits):
    for scene in (
        connected_scene(seed, (*METRIC, *OTHER, *OTHER), size=3.0),
        banded(seed, refined=True),
    ):
        assert_bounded(scene, Settings(strategy=Strategy.BEST_PATH), limits)


@pytest.mark.parametrize(("mode", "localise"), [(Mode.SD, 0.0), (Mode.HT, 1.0)])
def test_what_a_setting_silences_is_marked(mode, localise):
    listeners = Listener("near", "o0", (1.0, 0.0, 0.0)), Listener("far", "o0", (2.0, 0.0, 0.0))
    scene = replace(chain(1, 0.9), listeners=listeners)
    found = propagate(graph_of_scene(scene), Settings(mode=mode, localise=localise))
    assert found.silenced.tolist() == [[False, True]]
    assert found.error_bound.tolist() == [[0.0, math.inf]]


def printed(scene: HapticScene, path, capsys, *arguments: str) -> list[dict]:
    """The gains that ``propagate`` prints."""
    write_scene(scene, path)
    assert main(["propagate", str(path), *arguments]) == 0
    return json.loads(capsys.readouterr().out)["gains"]


def test_printed_bounds_are_amplitudes(tmp_path, capsys):
    scene = chain(3, 0.2, amplitude=0.5)
    end, away = printed(scene, tmp_path / "s.json", capsys, "--threshold", "0.01")
    assert (end["gain"], end["error_bound"], end["limited"], end["silenced"]) == (
        0.0,
        0.005,
        True,
        False,
    )
    assert (away["gain"], away["error_bound"], away["limited"], away["silenced"]) == (
        0.0,
        0.0,
        False,
        False,
    )
    muted = replace(scene, listeners=(replace(scene.listeners[0], gain=0.0), scene.listeners[1]))
    assert [item["silenced"] for item in printed(muted, tmp_path / "m.json", capsys)] == [
        True,
        False,
    ]
    quiet = replace(scene, sources=(replace(scene.sources[0], amplitude=0.0),))
    assert [item["silenced"] for item in printed(quiet, tmp_path / "q.json", capsys)] == [
        True,
        True,
    ]
    nearest = printed(scene, tmp_path / "n.json", capsys, "--mode", "SD")
    assert sorted((item["silenced"], item["error_bound"]) for item in nearest)[1] == (True, None)
