"""What is drawn against the explicit graph."""

import math
from dataclasses import replace

import networkx
import numpy as np
import pytest
from explicit_graph import explicit_graph
from haptic_tracing.addon.view.colour_map import AmplitudeScale
from haptic_tracing.addon.view.render_data import (
    IMPACT_COLOUR,
    SILENT_COLOUR,
    SOURCE_COLOUR,
    Options,
    render_data,
)
from haptic_tracing.addon.view.symbols import Symbol
from haptic_tracing.core.diagnosis.connections import path_steps
from haptic_tracing.core.scene.values import Mode, Settings, SourceKind
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from .conftest import BRIDGE, random_scene, traced

random_scenes = settings(
    deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
seeds = st.integers(0, 2**32 - 1)


def _segments(lines):
    return {frozenset(map(tuple, np.round(ends, 4).tolist())) for ends in lines.position}


@random_scenes
@given(seeds)
def test_lines_are_connections_that_carry_signal(seed):
    result = traced(random_scene(seed))
    explicit = explicit_graph(result.graph)
    allowed = {
        frozenset(
            tuple(np.round(np.float32(explicit.nodes[n]["position"]), 4).tolist()) for n in edge
        )
        for edge in explicit.edges
        if explicit.edges[edge]["gain"] > 0
    }
    data = render_data(result, Settings(), Options())
    for lines in (data.tree, data.paths):
        assert _segments(lines) <= allowed
    sources = {
        node for source in result.graph.sources if source.amplitude > 0 for node in source.nodes
    }
    reachable = (
        set().union(*({node} | networkx.descendants(explicit, node) for node in sources))
        if sources
        else set()
    )
    assert len(data.tree.width) <= max(len(reachable) - 1, 0)


@random_scenes
@given(seeds)
def test_paths_end_with_the_gain_of_the_best_path(seed):
    result = traced(random_scene(seed, Settings(strategy="best_path")))
    paths = {pair: nodes for pair, nodes in result.propagation.best_path.items() if nodes}
    if not paths:
        return
    steps, gain, arc_length = path_steps(result, result.graph, Mode.HT, paths)
    explicit = explicit_graph(result.graph)
    ends = np.cumsum([len(nodes) - 1 for nodes in paths.values()]) - 1
    for end, (pair, nodes) in zip(ends, paths.items(), strict=True):
        product = math.prod(explicit.edges[edge]["gain"] for edge in networkx.utils.pairwise(nodes))
        length = sum(
            math.dist(*(explicit.nodes[n]["position"] for n in edge))
            for edge in networkx.utils.pairwise(nodes)
        )
        assert steps[end][1] == nodes[-1]
        assert gain[end, 1] == pytest.approx(result.sources[pair[0]].amplitude * product, rel=1e-9)
        assert gain[end, 1] == pytest.approx(result.amplitudes[pair], rel=1e-9)
        assert arc_length[end, 1] == pytest.approx(length, rel=1e-9)
    assert (arc_length[:, 1] >= arc_length[:, 0]).all()


@random_scenes
@given(seeds, st.booleans(), st.booleans(), st.sampled_from(list(Mode)))
def test_arrays_are_finite_and_fit_together(seed, show_intra, show_best_paths, mode):
    chosen = Settings(mode=mode)
    result = traced(random_scene(seed, chosen))
    data = render_data(result, chosen, Options(show_intra, show_best_paths))
    for lines in (data.tree, data.paths):
        count = len(lines.width)
        assert lines.position.shape == (count, 2, 3)
        assert lines.colour.shape == (count, 2, 4)
        assert lines.arc_length.shape == (count, 2)
        for values in (lines.position, lines.colour, lines.width):
            assert np.isfinite(values).all()
        assert ((lines.colour >= 0) & (lines.colour <= 1)).all()
        assert (lines.width > 0).all()
    points = data.points
    expected = result.graph.contact_count + len(result.listeners) + len(result.sources)
    assert (
        len(points.width)
        == len(points.shape)
        == len(points.position)
        == len(points.colour)
        == expected
    )
    assert np.isfinite(points.position).all()


def test_bridge_points(bridge):
    data = render_data(bridge, BRIDGE.settings, Options())
    scale = AmplitudeScale()
    by_place = {
        tuple(np.round(p.astype(float), 3).tolist()): k
        for k, p in enumerate(data.points.position[:, 0])
    }
    truck = by_place[(-1.5, 0.0, 1.0)]
    assert data.points.shape[truck] == Symbol.SOURCE
    assert data.points.colour[truck, 0] == pytest.approx([*SOURCE_COLOUR, 1])
    driver = by_place[(0.2, 0.0, 1.0)]
    expected = math.exp(-0.4 * 1.7)
    assert data.points.shape[driver] == Symbol.LISTENER
    assert data.points.colour[driver, 0, :3] == pytest.approx(
        scale.colour(np.array(expected)), abs=1e-6
    )
    for place, shape in (((-1.2, 0.0, -1.6), Symbol.LISTENER), ((0.0, 0.0, -1.6), Symbol.CONTACT)):
        unreached = by_place[place]
        assert data.points.shape[unreached] == shape
        assert data.points.colour[unreached, 0, :3] == pytest.approx(SILENT_COLOUR)
        assert data.points.colour[unreached, 0, 3] < 1
    siren = by_place[(-0.5, 0.0, 1.0)]
    assert data.points.colour[siren, 0, :3] == pytest.approx(SILENT_COLOUR)


def test_bridge_labels(bridge):
    data = render_data(bridge, BRIDGE.settings, Options())
    names = {label.name for label in data.labels}
    assert names == {"truck", "siren", "driver", "walker", "hermit"}
    (driver,) = render_data(bridge, BRIDGE.settings, Options(labelled="driver")).labels
    assert driver.name == "driver"


def test_selected_listener_shows_its_paths_alone(bridge):
    every = render_data(bridge, BRIDGE.settings, Options())
    walker = render_data(bridge, BRIDGE.settings, Options(listeners=frozenset({"walker"})))
    hermit = render_data(bridge, BRIDGE.settings, Options(listeners=frozenset({"hermit"})))
    assert _segments(walker.paths) < _segments(every.paths)
    assert ((1.0, 0.0, -1.0) in end for end in _segments(walker.paths))
    assert len(hermit.paths.width) == 0
    assert walker.tree.colour[..., 3].max() < every.tree.colour[..., 3].max()
    assert [label.name for label in walker.labels] == ["truck", "siren", "walker"]


def test_selected_source_spreads_alone(bridge):
    silent = render_data(bridge, BRIDGE.settings, Options(sources=frozenset({"siren"})))
    assert len(silent.tree.width) == len(silent.paths.width) == 0
    contacts = silent.points.shape == Symbol.CONTACT
    assert silent.points.colour[contacts, 0, :3] == pytest.approx(np.tile(SILENT_COLOUR, (3, 1)))


def test_impact_is_drawn_on_both_objects_once_they_part():
    for distance, count in ((0.0, 1), (0.3, 2)):
        impact = replace(
            BRIDGE.sources[0],
            kind=SourceKind.TEMPORARY,
            second_object="ground",
            second_position=(-1.5, 0, 1 - distance),
            position=(-1.5, 0, 1),
        )
        result = traced(replace(BRIDGE, sources=(impact,)))
        data = render_data(result, BRIDGE.settings, Options())
        impacts = data.points.shape == Symbol.IMPACT
        assert impacts.sum() == count
        assert data.points.colour[impacts, 0, :3] == pytest.approx(
            np.tile(IMPACT_COLOUR, (count, 1))
        )


@pytest.mark.parametrize("mode", [Mode.MD, Mode.MN])
def test_direct_modes_draw_straight_lines_with_their_gain(mode):
    scene = replace(BRIDGE, settings=replace(BRIDGE.settings, mode=mode))
    result = traced(scene)
    data = render_data(result, scene.settings, Options())
    truck = np.array([-1.5, 0, 1], dtype=np.float32)
    assert len(data.tree.width) == 0
    assert len(data.paths.width) == 3
    assert (data.paths.position[:, 0] == truck).all()
    for ends, colour in zip(data.paths.position, data.paths.colour, strict=True):
        gain = 1.0 if mode is Mode.MN else math.exp(-0.2 * math.dist(*ends.tolist()))
        assert colour[1, :3] == pytest.approx(data.scale.colour(np.array(gain)), abs=1e-6)


def test_single_nearest_draws_the_distance_only_graph():
    scene = replace(BRIDGE, settings=replace(BRIDGE.settings, mode=Mode.SD))
    data = render_data(traced(scene), scene.settings, Options())
    assert len(data.paths.width) == 1  # to the driver, the nearest
    assert data.paths.colour[0, 1, :3] == pytest.approx(
        data.scale.colour(np.array(math.exp(-0.2 * 1.7))), abs=1e-6
    )
    reached = data.points.shape == Symbol.LISTENER
    assert (data.points.colour[reached, 0, :3] == np.float32(SILENT_COLOUR)).all(axis=1).sum() == 2


def test_nothing_traced_is_nothing_drawn():
    result = traced(replace(BRIDGE, contacts=(), sources=(), listeners=()))
    data = render_data(result, BRIDGE.settings, Options())
    assert len(data.tree.width) == len(data.paths.width) == len(data.points.width) == 0
    assert data.labels == ()


def test_contacts_off_the_paths_of_the_selected_listener_are_dimmed(bridge):
    for chosen, opaque in (("driver", 0), ("walker", 2)):
        data = render_data(bridge, BRIDGE.settings, Options(listeners=frozenset({chosen})))
        opacity = data.points.colour[data.points.shape == Symbol.CONTACT, 0, 3]
        assert (opacity == 1).sum() == opaque
    everything = render_data(bridge, BRIDGE.settings, Options())
    assert (
        everything.points.colour[everything.points.shape == Symbol.CONTACT, 0, 3] == 1
    ).sum() == 2
