"""The haptic graph as geometry that Cycles and EEVEE render: one mesh with colours, and labels as
texts that face the camera."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.types import Collection, Material, Mesh, Object, Scene

from ...addon.blender.text import text_width
from ...addon.blender.units import metres_per_unit
from ...addon.scene_reader.settings import read_settings
from ...addon.view.annotations import placed_annotations
from ...addon.view.camera import camera_view, picture_scale
from ...addon.view.colour_map import linear
from ...addon.view.hud import INK, Hud
from ...addon.view.options import options_of
from ...addon.view.render_data import Label, render_data
from ...core.arrays import FloatArray
from ...core.render.frame_result import FrameResult
from .solids import UPRIGHT, Solid, extent_unit, flat, seen_unit, solid_graph

NAME = "Haptic Graph"
COLOUR_ATTRIBUTE = "Amplitude"
_MARK = "haptic_graph"
# Distance of the nearest part of a graph in front, in near clipping distances of the camera.
_FRONT = 4.0


def graph_in_collection(
    scene: Scene, result: FrameResult, thickness: float, *, in_front: bool, labels: bool
) -> tuple[Object, Collection]:
    """Convert the drawn graph of ``result`` to geometry in the scene's collection for it, which is
    emptied first.

    Args:
        scene: The scene that was traced.
        result: Its traced frame.
        thickness: Factor of lines and symbols.
        in_front: Whether the graph is brought close to the camera.
        labels: Whether names, amplitudes and the legend are added.

    Returns:
        The mesh object and its collection.
    """
    options = replace(options_of(scene, result), labelled=None)
    data = render_data(result, read_settings(scene), options)
    collection = _emptied_collection(scene)
    if scene.camera is None:
        unit = extent_unit(data) * thickness
        graph = add_graph(collection, solid_graph(data, unit, UPRIGHT))
        for label in data.labels if labels else ():
            _add_label(collection, label, unit)
        _from_metres(collection.objects, scene)
        return graph, collection
    size = scene.render.resolution_x, scene.render.resolution_y
    scale = picture_scale(size)
    view, projection = (np.array(matrix, dtype=np.float64) for matrix in camera_view(scene, size))
    metres = metres_per_unit(scene)
    view[:3, :3] /= metres
    graph = add_graph(
        collection,
        solid_graph(
            data,
            seen_unit(data, projection, view, size[1] / scale) * metres * thickness,
            view[:3, :3] * metres,
        ),
    )
    if in_front:
        _bring_to_front(graph, view, projection, scene.camera.data.clip_start)
    _from_metres((graph,), scene)
    if labels:
        items = placed_annotations(data, projection @ view, size, scale, (0.0, 0.0, *size))
        _add_annotations(collection, items, scale, scene.camera, projection, size)
    return graph, collection


def _from_metres(objects: Iterable[Object], scene: Scene) -> None:
    """Place and scale objects that were made in metres."""
    for obj in objects:
        obj.location /= metres_per_unit(scene)
        obj.scale /= metres_per_unit(scene)


def _emptied_collection(scene: Scene) -> Collection:
    """The scene's collection for the graph, emptied."""
    collection = next(
        (child for child in scene.collection.children_recursive if child.get(_MARK)), None
    )
    if collection is None:
        collection = bpy.data.collections.new(NAME)
        collection[_MARK] = True
        scene.collection.children.link(collection)
    shapes = {obj.data for obj in collection.objects} - {None}
    bpy.data.batch_remove(list(collection.objects))
    bpy.data.batch_remove([shape for shape in shapes if shape.users == 0])
    return collection


def add_graph(collection: Collection, solid: Solid) -> Object:
    """The graph as a mesh object in ``collection``."""
    obj = bpy.data.objects.new(NAME, solid_mesh(NAME, solid))
    obj.data.materials.append(flat_material(NAME))
    collection.objects.link(obj)
    return obj


def _bring_to_front(
    obj: Object, view: FloatArray, projection: FloatArray, clip_start: float
) -> None:
    """Move an object towards the camera and scale it down, so that its image stays the same."""
    values = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    obj.data.vertices.foreach_get("co", values)
    depth = -(values.reshape(-1, 3) @ view[2, :3] + view[2, 3])
    ahead = depth[depth > clip_start]
    nearest = float(ahead.min()) if len(ahead) else clip_start
    wanted = _FRONT * clip_start
    if projection[3, 3] == 1:
        towards = np.linalg.inv(view)[:3, 2]
        obj.location = tuple(towards * (nearest - wanted))
    else:
        factor = min(wanted / nearest, 1.0)
        camera = np.linalg.inv(view)[:3, 3]
        obj.location = tuple(camera * (1 - factor))
        obj.scale = (factor,) * 3
    _hide_from_light(obj)


def _hide_from_light(obj: Object) -> None:
    """Make an object visible to the camera alone: it casts no shadow and lights nothing."""
    for key in (
        "visible_diffuse",
        "visible_glossy",
        "visible_transmission",
        "visible_volume_scatter",
        "visible_shadow",
    ):
        setattr(obj, key, False)


def _add_annotations(
    collection: Collection,
    items: Hud,
    scale: float,
    camera: Object,
    projection: FloatArray,
    size: tuple[int, int],
) -> None:
    """Add labels and legend on a plane in front of the camera, parented to it.

    Args:
        collection: to which it is added.
        items: labels and legend [pixels].
        scale: pixels per point.
        camera: the scene's.
        projection: matrix of the camera (4, 4).
        size: of the picture [pixels].
    """
    clip_start = camera.data.clip_start
    distance = _FRONT * clip_start * 0.5
    orthographic = projection[3, 3] == 1
    depth = 1.0 if orthographic else distance
    shift = -projection[:2, 3] if orthographic else projection[:2, 2]
    extent = 2 * depth / np.diag(projection)[:2]  # visible size of the plane, in metres
    shapes = flat(items, scale)
    plane = bpy.data.objects.new("Haptic Labels", solid_mesh("Haptic Labels", shapes))
    plane.data.materials.append(flat_material("Haptic Labels"))
    plane.data.materials[0].surface_render_method = "BLENDED"
    plane.parent = camera
    plane.location = (*((shift - 1) * extent / 2), -distance)
    plane.scale = extent[0] / size[0], extent[1] / size[1], extent[1] / size[1]
    collection.objects.link(plane)
    _hide_from_light(plane)
    above = shapes.vertices[:, 2].max() + 0.01 * scale
    texts = [
        (_add_text(collection, text.words, text.size, (*text.colour, 1.0)), text)
        for text in items.texts
    ]
    bpy.context.view_layer.update()
    for obj, text in texts:
        natural = obj.dimensions.x / max(obj.scale.x, 1e-9)
        obj.scale = (text_width(text.words, text.size) / max(natural, 1e-9),) * 3
        obj.parent = plane
        obj.location = (*text.position, above)
        _hide_from_light(obj)


def _add_text(collection: Collection, words: str, size: float, colour: tuple[float, ...]) -> Object:
    curve = bpy.data.curves.new(f"{NAME}: {words}", "FONT")
    curve.body, curve.size = words, size
    curve.materials.append(text_material())
    obj = bpy.data.objects.new(curve.name, curve)
    obj.color = (*linear(np.array(colour[:3])), colour[3])
    collection.objects.link(obj)
    return obj


def _add_label(collection: Collection, label: Label, unit: float) -> None:
    """A text above its place, upright."""
    obj = _add_text(collection, label.name, 17 * unit, (*INK, 1.0))
    obj.data.align_x = "CENTER"
    x, y, z = label.position
    obj.location = x, y, z + (label.clearance + 5) * unit
    obj.rotation_euler = np.pi / 2, 0, 0


def solid_mesh(name: str, solid: Solid) -> Mesh:
    """A mesh of triangles with the colours as an attribute."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(solid.vertices.tolist(), [], solid.triangles.tolist(), shade_flat=False)
    colours = mesh.color_attributes.new(COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    values = np.column_stack([linear(solid.colours[:, :3]), solid.colours[:, 3]])
    colours.data.foreach_set("color", values.astype(np.float32).reshape(-1))
    mesh.color_attributes.active_color = colours
    return mesh


_EMITTING: Mapping[str, Any] = {
    "emission": ("Emission", (-440, 0), {}),
    "output": ("OutputMaterial", (0, 0), {}),
}
"""Nodes of materials: kinds without "ShaderNode", places and settings."""


def flat_material(name: str) -> Material:
    """A material that emits the colours of the mesh, with their opacity; back faces are not
    drawn."""
    nodes = {
        "colour": ("Attribute", (-880, 60), {"attribute_name": COLOUR_ATTRIBUTE}),
        "side": ("NewGeometry", (-880, -140), {}),
        "cover": ("Math", (-660, -60), {"operation": "SUBTRACT", "use_clamp": True}),
        "clear": ("BsdfTransparent", (-440, -160), {}),
        "mix": ("MixShader", (-220, 0), {}),
    }
    links = [
        ("colour", "Color", "emission", "Color"),
        ("colour", "Alpha", "cover", 0),
        ("side", "Backfacing", "cover", 1),
        ("cover", 0, "mix", "Fac"),
        ("clear", 0, "mix", 1),
        ("emission", 0, "mix", 2),
        ("mix", 0, "output", "Surface"),
    ]
    return _material(name, nodes, links)


def text_material() -> Material:
    """A material that emits the object's colour."""
    links = [("own", "Color", "emission", "Color"), ("emission", 0, "output", "Surface")]
    return _material("Haptic Text", {"own": ("ObjectInfo", (-660, 0), {})}, links)


def _material(name: str, nodes: Mapping[str, Any], links: Sequence[Any]) -> Material:
    """The material ``name``; if missing, created from ``nodes`` by name and ``links`` (from,
    output, to, input)."""
    material = bpy.data.materials.get(name)
    if material is not None:
        return material
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    made = {}
    tree = material.node_tree
    tree.nodes.clear()
    for key, (kind, place, settings) in {**_EMITTING, **nodes}.items():
        made[key] = tree.nodes.new(f"ShaderNode{kind}")
        for setting, value in {**settings, "location": place}.items():
            setattr(made[key], setting, value)
    for start, output, end, taken in links:
        tree.links.new(made[start].outputs[output], made[end].inputs[taken])
    return material
