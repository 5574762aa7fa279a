"""The graph as geometry: closed surfaces where they should be, true to place and colour, and
accepted by Blender as it is."""

import dataclasses

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from haptic_tracing.addon.session import session
from haptic_tracing.addon.view.annotations import placed_annotations
from haptic_tracing.addon.view.camera import camera_view, picture_scale
from haptic_tracing.addon.view.colour_map import linear
from haptic_tracing.addon.view.render_data import NO_LINES, Options, render_data
from haptic_tracing.addon.view.symbols import LOOKS, Symbol
from haptic_tracing.plugins.graph_geometry import graph_mesh
from haptic_tracing.plugins.graph_geometry.solids import UPRIGHT, flat, solid_graph, tubes
from mathutils import Vector

from .conftest import BRIDGE, random_scene, traced_frame


@pytest.mark.parametrize("seed", range(3))
def test_symbols_face_the_viewer_and_lie_around_their_places(seed):
    """Vertices by a random view's own axes: every symbol is a stack of flat layers, as wide as its
    point, its triangles counterclockwise as the viewer sees them."""
    data = render_data(traced_frame(random_scene(seed)), BRIDGE.settings, Options())
    data = dataclasses.replace(data, tree=NO_LINES, paths=NO_LINES)
    axes, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    solid = solid_graph(data, 0.01, axes * np.linalg.det(axes))
    seen = solid.vertices @ (axes * np.linalg.det(axes)).T
    a, b, c = seen[solid.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > -1e-12).all()
    assert np.ptp(seen[solid.triangles][..., 2], axis=1).max() < 1e-9
    places = data.points.position[:, 0] @ (axes * np.linalg.det(axes)).T
    reach = (
        np.linalg.norm(seen[:, None, :2] - places[None, :, :2], axis=2) - data.points.width * 0.005
    )
    assert reach.min(axis=1).max() < 1e-6
    # The shader's diamond ends where (x + y - radius + corner) * 0.7071 - 0.2929 * corner is 0.
    corner = 0.22
    diamond = 1 - corner + corner * 0.29289 / 0.70710678
    for place, size, shape in zip(places, data.points.width, data.points.shape, strict=True):
        own = np.linalg.norm(seen[:, :2] - place[:2], axis=1)
        tip = diamond if shape == Symbol.LISTENER else 1.0
        assert (np.abs(own - tip * size * 0.005) < 1e-6).any()


def test_tubes_run_along_their_lines(bridge):
    data = render_data(bridge, BRIDGE.settings, Options())
    solid = tubes(data.paths, 0.01)
    long = np.linalg.norm(np.diff(data.paths.position, axis=1)[:, 0], axis=1) > 0
    assert 0 < long.sum() < len(long)  # both nodes of these contacts are at one place
    sides = len(solid.vertices) // (2 * long.sum())
    rings = solid.vertices.reshape(-1, 2, sides, 3)
    assert rings.mean(axis=2) == pytest.approx(data.paths.position[long], abs=1e-6)
    a, b, c = solid.vertices[solid.triangles].transpose(1, 0, 2)
    outward = a - np.repeat(rings.mean(axis=(1, 2)), 2 * sides, axis=0)
    assert (np.einsum("ij,ij->i", outward, np.cross(b - a, c - a)) > 0).all()
    radius = np.linalg.norm(rings - rings.mean(axis=2, keepdims=True), axis=3)
    np.testing.assert_allclose(
        radius,
        np.broadcast_to((data.paths.width[long] * 0.005)[:, None, None], radius.shape),
        rtol=1e-5,
        atol=1e-12,
    )


@pytest.mark.parametrize("seed", range(5))
def test_blender_finds_nothing_to_correct(seed):
    result = traced_frame(random_scene(seed))
    solid = solid_graph(render_data(result, BRIDGE.settings, Options()), 0.01, UPRIGHT)
    mesh = graph_mesh.solid_mesh("graph", solid)
    assert not mesh.validate(verbose=False)
    assert len(mesh.vertices) == len(solid.vertices)
    assert len(mesh.polygons) == len(solid.triangles)
    colours = np.empty(4 * len(solid.vertices), dtype=np.float32)
    mesh.color_attributes[graph_mesh.COLOUR_ATTRIBUTE].data.foreach_get("color", colours)
    np.testing.assert_allclose(
        colours.reshape(-1, 4)[:, :3], linear(solid.colours[:, :3]), rtol=0, atol=1e-6
    )
    np.testing.assert_allclose(colours.reshape(-1, 4)[:, 3], solid.colours[:, 3], rtol=1e-6)


def test_operator_says_why_it_can_not_run():
    with pytest.raises(RuntimeError, match="Nothing has been traced yet"):
        bpy.ops.haptic.graph_to_geometry()


def test_operator_makes_and_replaces_the_graph(scene, camera, shown):
    shown()
    assert bpy.ops.haptic.graph_to_geometry() == {"FINISHED"}
    collection = bpy.data.collections["Haptic Graph"]
    names = {obj.name for obj in collection.objects}
    assert {
        "Haptic Graph",
        "Haptic Labels",
        "Haptic Graph: truck",
        "Haptic Graph: driver",
        "Haptic Graph: Amplitude",
    } <= names
    assert all(obj.data.body for obj in collection.objects if obj.type == "FONT")
    before = len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)
    shown()
    assert bpy.ops.haptic.graph_to_geometry(thickness=2.0) == {"FINISHED"}
    assert {obj.name for obj in collection.objects} == names
    assert (len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)) == before
    shown()
    bpy.ops.haptic.graph_to_geometry(labels=False)
    assert [obj.name for obj in collection.objects] == ["Haptic Graph"]
    assert not bpy.data.curves


def test_without_a_camera_labels_stand_beside_their_places(scene, shown):
    result = shown()
    assert bpy.ops.haptic.graph_to_geometry() == {"FINISHED"}
    for item in (*result.sources, *result.listeners):
        text = next(
            obj
            for obj in bpy.data.objects
            if obj.type == "FONT" and obj.data.body.startswith(item.name)
        )
        assert text.location.xy[:] == pytest.approx(item.position[:2])
        assert 0 < text.location.z - item.position[2] < 0.3


def test_geometry_stands_where_the_nodes_are(scene, camera, shown):
    result = shown()
    bpy.ops.haptic.graph_to_geometry(labels=False, in_front=False)
    found = _world_vertices(bpy.data.objects["Haptic Graph"])
    reach = 0.15
    for position in result.graph.node_position:
        assert np.linalg.norm(found - position, axis=1).min() < reach
    assert (found.min(axis=0) > result.graph.node_position.min(axis=0) - reach).all()
    assert (found.max(axis=0) < result.graph.node_position.max(axis=0) + reach).all()


def _world_vertices(obj):
    bpy.context.view_layer.update()
    return np.array([obj.matrix_world @ vertex.co for vertex in obj.data.vertices])


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_graph_in_front_is_seen_at_the_same_place_and_nearer(scene, camera, shown, kind):
    camera.data.type, camera.data.shift_x = kind, 0.1
    camera.location, camera.rotation_euler = (3, -7, 2), (1.3, 0.1, 0.4)
    bpy.context.view_layer.update()
    seen = []
    for in_front in (False, True):
        shown()
        bpy.ops.haptic.graph_to_geometry(in_front=in_front, labels=False)
        vertices = _world_vertices(bpy.data.objects["Haptic Graph"])
        seen.append(
            np.array([world_to_camera_view(scene, camera, Vector(place)) for place in vertices])
        )
    assert seen[0][:, :2] == pytest.approx(seen[1][:, :2], abs=1e-4)
    assert seen[1][:, 2].min() == pytest.approx(4 * camera.data.clip_start, rel=0.01)
    assert (seen[1][:, 2] > camera.data.clip_start).all()


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_labels_lie_where_the_overlay_has_them_before_everything_else(scene, camera, shown, kind):
    camera.data.type, camera.data.shift_y, camera.data.ortho_scale = kind, 0.05, 6.0
    scene.render.resolution_x, scene.render.resolution_y = 900, 600
    bpy.context.view_layer.update()
    result = shown()
    bpy.ops.haptic.graph_to_geometry()
    plane = bpy.data.objects["Haptic Labels"]
    size, scale = (900, 600), picture_scale((900, 600))
    view, projection = camera_view(scene, size)
    data = render_data(result, BRIDGE.settings, Options())
    items = placed_annotations(
        data,
        np.array(projection @ view, dtype=np.float64),
        size,
        scale,
        (0.0, 0.0, *size),
    )
    seen = np.array(
        [world_to_camera_view(scene, camera, Vector(place)) for place in _world_vertices(plane)]
    )
    expected = flat(items, scale).vertices[:, :2] / size
    assert seen[:, :2] == pytest.approx(expected, abs=2e-3)
    graph = np.array(
        [
            world_to_camera_view(scene, camera, Vector(v))
            for v in _world_vertices(bpy.data.objects["Haptic Graph"])
        ]
    )
    assert camera.data.clip_start < seen[:, 2].min() <= seen[:, 2].max() < graph[:, 2].min()
    texts = {obj.data.body: obj for obj in bpy.data.objects if obj.type == "FONT"}
    words = [text.words for text in items.texts]
    for text in items.texts:
        if words.count(text.words) > 1:
            continue
        x, y, depth = world_to_camera_view(
            scene, camera, texts[text.words].matrix_world.translation
        )
        assert (x * 900, y * 600) == pytest.approx(text.position, abs=2)
        assert camera.data.clip_start < depth < seen[:, 2].min() + 1e-6


def test_every_symbol_has_its_look():
    """What the shader, the meshes and the painter need of each symbol."""
    assert LOOKS.keys() == set(Symbol) - {Symbol.LINE, Symbol.PLATE}
    for look in LOOKS.values():
        insets = [inset for inset, _, _ in look.layers]
        assert insets == sorted(insets)


def test_the_graph_becomes_geometry_after_undo_has_dropped_the_result(add_box, traced):
    bpy.context.scene.haptics.tracing = False
    add_box("box", (0, 0, 0), (1, 1, 1)).haptics.source.enabled = True
    with pytest.raises(RuntimeError, match="Nothing has been traced yet"):
        bpy.ops.haptic.graph_to_geometry()
    traced()
    session.cancel()
    assert bpy.ops.haptic.graph_to_geometry() == {"FINISHED"}
