"""Every sample: levels of the default strategy and of the energy balance are ones that a designer can compare."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.addon.io.frame_scene import scene_of_result
from haptic_tracing.addon.session import session
from haptic_tracing.addon.view.render_data import Options, path_steps, render_data
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import objects_on
from haptic_tracing.core.scene.values import Mode, Strategy
from haptic_tracing.sample_scenes import SAMPLES
from level_properties import WELL_POSED, check_bounded, check_cut_offs, check_local, check_shown, check_steady, traced

_specification = importlib.util.spec_from_file_location("parts_of_samples", Path(__file__).with_name("short_parts.py"))
short_parts = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(short_parts)


@pytest.fixture
def play(build, results):
    """Plays a sample's short part with the default strategy, up to the last frame with sources."""

    def played(name):
        first, last, count = short_parts.PARTS[name]
        scene = build(name, count)
        scene.haptics.strategy = "auto"
        for result in results(scene, first, last):
            found = result
            if result.impacts:
                break
        assert found.sources and (found.gains > 0).any()
        return scene, found

    return played


@pytest.mark.parametrize("name", [name if name == "hammer_nail" else pytest.param(name, marks=pytest.mark.slow) for name in SAMPLES])
def test_levels_compare_and_are_those_of_the_ways_shown(play, name):
    """The properties of `level_properties`; and every way of the overlay ends with the gain that the listener gets, over the objects that
    the Result panel names."""
    scene, result = play(name)
    haptic = scene_of_result(result, session.of(scene).reading, scene)
    largest = max(
        (item for item in haptic.objects if item.shape is not None),
        key=lambda item: float(np.prod(np.ptp(item.shape.local_bounds(), axis=0))),
    )
    x, y, z = largest.pose.position
    for strategy in WELL_POSED:
        check_bounded(haptic, strategy)
        check_cut_offs(haptic, strategy)
        check_steady(haptic, strategy, 1)
        check_local(haptic, strategy, largest.name, (x - 60.0, y, z))
    graph = graph_of_scene(haptic)
    check_shown(graph, traced(haptic, Strategy.AUTO), haptic.settings.threshold)
    paths = {pair: nodes for pair, nodes in result.propagation.best_path.items() if nodes}
    assert set(paths) == set(map(tuple, np.argwhere(result.gains > 0).tolist()))
    steps, gain, _ = path_steps(result, result.graph, Mode.HT, paths)
    ends = np.cumsum([len(nodes) - 1 for nodes in paths.values()]) - 1
    for end, (pair, nodes) in zip(ends, paths.items(), strict=True):
        assert steps[end, 1] == nodes[-1]
        assert gain[end, 1] == pytest.approx(result.gains[pair], rel=1e-9)
        assert result.path_objects(*pair) == objects_on(result.graph, nodes)
    drawn = render_data(result, session.of(scene).reading.settings, Options()).paths
    shown = {tuple(place) for place in np.round(drawn.position.reshape(-1, 3), 3).tolist()}
    for nodes in paths.values():
        assert {tuple(place) for place in np.round(result.graph.node_position[list(nodes)].astype(np.float32), 3).tolist()} <= shown
