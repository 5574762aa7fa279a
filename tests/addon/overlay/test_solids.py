"""The graph as geometry: closed surfaces where they should be, true to place and colour, and accepted by Blender as it is."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.overlay import geometry
from haptic_tracing.addon.overlay.colour_map import linear
from haptic_tracing.addon.overlay.render_data import Options, Shape, render_data
from haptic_tracing.addon.overlay.solids import octahedron, solid_graph, sphere, spiked_ball, three_rings, torus, tubes

from .conftest import BRIDGE, random_scene, traced

FORMS = {
    "octahedron": (octahedron(), 2),
    "sphere": (sphere(2), 2),
    "spiked ball": (spiked_ball(), 2),
    "torus": (torus(0.9, 0.1), 0),
    "three rings": (three_rings(0.9, 0.1), 0),
}


@pytest.mark.parametrize(("form", "characteristic"), FORMS.values(), ids=FORMS)
def test_forms_are_closed_and_face_outwards(form, characteristic):
    vertices, triangles = form
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    directed = set(map(tuple, edges.tolist()))
    assert len(directed) == len(edges)
    assert {(b, a) for a, b in directed} == directed  # every edge once in either direction: closed and oriented
    assert len(vertices) - len(edges) // 2 + len(triangles) == characteristic
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0  # six times the volume
    assert np.linalg.norm(vertices, axis=1).max() == pytest.approx(1.0)


def test_sphere_approaches_a_sphere():
    vertices, triangles = sphere(4)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(4 * np.pi, rel=0.01)


def test_tubes_run_along_their_lines(bridge):
    data = render_data(bridge, BRIDGE.settings, Options())
    solid = tubes(data.paths, 0.01)
    sides = len(solid.vertices) // (2 * len(data.paths.width))
    rings = solid.vertices.reshape(-1, 2, sides, 3)
    assert rings.mean(axis=2) == pytest.approx(data.paths.position, abs=1e-6)
    radius = np.linalg.norm(rings - rings.mean(axis=2, keepdims=True), axis=3)
    assert radius == pytest.approx(np.broadcast_to((data.paths.width * 0.005)[:, None, None], radius.shape), rel=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_blender_finds_nothing_to_correct(seed):
    result = traced(random_scene(seed))
    solid = solid_graph(render_data(result, BRIDGE.settings, Options()), 0.01)
    mesh = geometry.solid_mesh(solid)
    assert not mesh.validate(verbose=False)
    assert len(mesh.vertices) == len(solid.vertices)
    assert len(mesh.polygons) == len(solid.triangles)
    colours = np.empty(4 * len(solid.vertices), dtype=np.float32)
    mesh.color_attributes[geometry.COLOUR_ATTRIBUTE].data.foreach_get("color", colours)
    assert colours.reshape(-1, 4)[:, :3] == pytest.approx(linear(solid.colours), abs=1e-6)


def test_operator_says_why_it_can_not_run():
    with pytest.raises(RuntimeError, match="Nothing has been traced yet"):
        bpy.ops.haptic.graph_to_geometry()


def test_operator_makes_and_replaces_the_graph(scene, camera, shown):
    shown()
    assert bpy.ops.haptic.graph_to_geometry() == {"FINISHED"}
    collection = bpy.data.collections["Haptic Graph"]
    names = {obj.name for obj in collection.objects}
    assert {"Haptic Graph", "Haptic Graph: truck", "Haptic Graph: driver"} <= names
    assert len(names) == 1 + len(BRIDGE.sources) + len(BRIDGE.listeners)
    before = len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)
    shown()
    assert bpy.ops.haptic.graph_to_geometry(thickness=2.0) == {"FINISHED"}
    assert {obj.name for obj in collection.objects} == names
    assert (len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)) == before
    shown()
    bpy.ops.haptic.graph_to_geometry(labels=False)
    assert [obj.name for obj in collection.objects] == ["Haptic Graph"]
    assert not bpy.data.curves


def test_geometry_stands_where_the_nodes_are(scene, camera, shown):
    result = shown()
    bpy.ops.haptic.graph_to_geometry(labels=False)
    obj = bpy.data.objects["Haptic Graph"]
    bpy.context.view_layer.update()
    found = np.array([vertex.co for vertex in obj.data.vertices])
    reach = 0.5 * np.linalg.norm(np.ptp(result.graph.node_position, axis=0)) / 900 * 26 + 1e-3
    for position in result.graph.node_position:
        assert np.linalg.norm(found - position, axis=1).min() < reach
    assert (found.min(axis=0) > result.graph.node_position.min(axis=0) - reach).all()
    assert (found.max(axis=0) < result.graph.node_position.max(axis=0) + reach).all()
    data = render_data(result, BRIDGE.settings, Options())
    assert (data.points.shape == Shape.SOURCE).sum() == 2
