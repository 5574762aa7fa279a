"""Every sample: levels of the default strategy are ones that a designer
can compare."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.addon.io.frame_scene import scene_of_result
from haptic_tracing.addon.session import session
from haptic_tracing.addon.view import levels, paths
from haptic_tracing.addon.view.render_data import Options, render_data
from haptic_tracing.core.diagnosis.connections import path_steps
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import objects_on
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.sample_scenes import SAMPLES
from level_properties import (
    check_bounded,
    check_local,
    check_shown,
    check_steady,
    traced,
)

_specification = importlib.util.spec_from_file_location(
    "parts_of_samples", Path(__file__).with_name("short_parts.py")
)
short_parts = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(short_parts)


@pytest.fixture
def play(build, results):
    """Plays a sample's short part with the default strategy, up to the last frame with sources."""

    def played(name):
        first, last, count = short_parts.PARTS[name]
        scene = build(name, count)
        scene.haptics.strategy = "best_path"
        for result in results(scene, first, last):
            found = result
            if result.impacts:
                break
        assert found.sources and (found.amplitudes > 0).any()
        return scene, found

    return played


def _check_tables(shown):
    """The table of the way from each source to each listener that it reaches: its rounded rows add
    up to the level that is shown, and with the threshold to the margin; in the scenes of the
    samples best paths are the whole gain."""
    found = levels.shown_levels(shown, False)
    for row, column in np.argwhere(shown.result.amplitudes > 0).tolist():
        ends = shown.result.listeners[column].name, shown.result.sources[row].name, False
        path = paths.listener_path(shown, ends)
        table, level = paths.rows(path), found[column]
        tenths = [round(10 * item.decibels) for item in table if math.isfinite(item.decibels)]
        end = next(place for place, item in enumerate(table) if item.is_sum)
        if len(tenths) == len(table):
            assert sum(tenths[:end]) == tenths[end]
            assert tenths[end] / 10 == pytest.approx(level.rms, abs=0.051)
            assert tenths[end] - tenths[end + 1] == tenths[end + 2]
            assert tenths[end + 2] / 10 == pytest.approx(level.margin, abs=0.051)
        assert path.fall.gain == pytest.approx(20 * math.log10(shown.result.gains[row, column]))
        assert path.fall.hops


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_levels_compare_and_are_those_of_the_ways_shown(play, name):
    """The properties of `level_properties`; and every way of the overlay ends with the gain that
    the listener gets, over the objects that the Result panel names."""
    scene, result = play(name)
    haptic = scene_of_result(result, session.of(scene).reading, scene)
    largest = max(
        (item for item in haptic.objects if item.shape is not None),
        key=lambda item: float(np.prod(np.ptp(item.shape.local_bounds, axis=0))),
    )
    x, y, z = largest.pose.position
    check_bounded(haptic)
    check_steady(haptic, 1)
    for away in (20.0, 60.0, 200.0):
        check_local(haptic, largest.name, (x - away, y, z))
    graph = graph_of_scene(haptic)
    check_shown(graph, traced(haptic), 1e-6)
    ways = {pair: nodes for pair, nodes in result.propagation.best_path.items() if nodes}
    assert set(ways) == set(map(tuple, np.argwhere(result.amplitudes > 0).tolist()))
    steps, gain, _ = path_steps(result, result.graph, Mode.HT, ways)
    ends = np.cumsum([len(nodes) - 1 for nodes in ways.values()]) - 1
    for end, (pair, nodes) in zip(ends, ways.items(), strict=True):
        assert steps[end, 1] == nodes[-1]
        band, propagation = result.graph.sources[pair[0]].band, result.propagation
        reached = (
            propagation.gain[pair]
            if propagation.band_gain is None
            else propagation.band_gain[pair][band]
        )
        assert gain[end, 1] == pytest.approx(result.sources[pair[0]].amplitude * reached, rel=1e-9)
        assert result.path_objects(*pair) == objects_on(result.graph, nodes)
    _check_tables(session.of(scene).shown)
    drawn = render_data(result, session.of(scene).reading.settings, Options()).paths
    shown = {tuple(place) for place in np.round(drawn.position.reshape(-1, 3), 3).tolist()}
    for nodes in ways.values():
        assert {
            tuple(place)
            for place in np.round(
                result.graph.node_position[list(nodes)].astype(np.float32), 3
            ).tolist()
        } <= shown
