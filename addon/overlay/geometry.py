"""The haptic graph as geometry that Cycles and EEVEE render: one mesh with colours, and labels as texts that face the camera."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty
from bpy.types import Collection, Context, Material, Mesh, Object, Operator, Scene

from .. import scene_reader, session
from .colour_map import linear
from .draw import options_of
from .render_data import Label, render_data
from .solids import Solid, extent_unit, solid_graph

NAME = "Haptic Graph"
COLOUR_ATTRIBUTE = "Gain"
_MARK = "haptic_graph"


class HAPTIC_OT_graph_to_geometry(Operator):
    """Make a mesh of the haptic graph as it is drawn now, for renderings; an earlier one of this scene is replaced"""

    bl_idname = "haptic.graph_to_geometry"
    bl_label = "Graph to Geometry"
    bl_options = {"REGISTER", "UNDO"}

    thickness: FloatProperty(
        name="Thickness", description="How thick lines and symbols are", default=1.0, min=0.01, soft_min=0.2, soft_max=5.0
    )
    labels: BoolProperty(name="Labels", description="Add names and gains as texts that face the camera", default=True)

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode first")
            return False
        if session.result_of(context.scene) is None:
            cls.poll_message_set("Nothing has been traced yet: tag objects, then play or change the frame")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        result = session.result_of(scene)
        data = render_data(result, scene_reader.read_settings(scene), options_of(scene, result))
        unit = extent_unit(data) * self.thickness
        collection = _emptied_collection(scene)
        graph = add_graph(collection, solid_graph(data, unit))
        if self.labels:
            for label in data.labels:
                _add_label(collection, label, unit, scene.camera)
        self.report({"INFO"}, f"{len(graph.data.vertices):,} vertices in collection {collection.name!r}")
        return {"FINISHED"}


def _emptied_collection(scene: Scene) -> Collection:
    """The scene's collection for the graph, without what was in it."""
    collection = next((child for child in scene.collection.children_recursive if child.get(_MARK)), None)
    if collection is None:
        collection = bpy.data.collections.new(NAME)
        collection[_MARK] = True
        scene.collection.children.link(collection)
    for obj in list(collection.objects):
        data = obj.data
        bpy.data.objects.remove(obj)
        if data is not None and data.users == 0:
            (bpy.data.meshes if isinstance(data, Mesh) else bpy.data.curves).remove(data)
    return collection


def add_graph(collection: Collection, solid: Solid) -> Object:
    """The graph as a mesh object in ``collection``."""
    obj = bpy.data.objects.new(NAME, solid_mesh(solid))
    obj.data.materials.append(graph_material())
    collection.objects.link(obj)
    return obj


def solid_mesh(solid: Solid) -> Mesh:
    """A mesh of triangles with the colours as an attribute."""
    mesh = bpy.data.meshes.new(NAME)
    count = len(solid.triangles)
    mesh.vertices.add(len(solid.vertices))
    mesh.loops.add(3 * count)
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", solid.vertices.astype(np.float32).reshape(-1))
    mesh.loops.foreach_set("vertex_index", solid.triangles.astype(np.int32).reshape(-1))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.polygons.foreach_set("use_smooth", solid.smooth)
    colours = mesh.color_attributes.new(COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    values = np.column_stack([linear(solid.colours), np.ones(len(solid.colours))])
    colours.data.foreach_set("color", values.astype(np.float32).reshape(-1))
    mesh.color_attributes.active_color = colours
    return mesh


def graph_material() -> Material:
    """Shines in the colours of the mesh, a little darker towards the edges, so that it looks round in any light."""
    material = bpy.data.materials.get(NAME)
    if material is not None:
        return material
    material, nodes, links = _empty_material(NAME)
    colour = nodes.new("ShaderNodeAttribute")
    colour.attribute_name = COLOUR_ATTRIBUTE
    facing = nodes.new("ShaderNodeLayerWeight")
    facing.inputs["Blend"].default_value = 0.35
    strength = nodes.new("ShaderNodeMath")
    strength.operation = "MULTIPLY_ADD"
    strength.inputs[1].default_value, strength.inputs[2].default_value = -0.7, 1.0
    emission = nodes.new("ShaderNodeEmission")
    output = nodes.new("ShaderNodeOutputMaterial")
    for place, node in enumerate((facing, strength, colour, emission, output)):
        node.location = (220 * max(place - 1, 0) - 500, -180 if node in (facing, strength) else 0)
    links.new(facing.outputs["Facing"], strength.inputs[0])
    links.new(strength.outputs[0], emission.inputs["Strength"])
    links.new(colour.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def _label_material() -> Material:
    name = "Haptic Label"
    material = bpy.data.materials.get(name)
    if material is not None:
        return material
    material, nodes, links = _empty_material(name)
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = (0.9, 0.9, 0.9, 1.0)
    emission.location = (-220, 0)
    links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def _empty_material(name: str) -> tuple[Material, Any, Any]:
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree.nodes, material.node_tree.links


def _add_label(collection: Collection, label: Label, unit: float, camera: Object | None) -> Object:
    """A text above its place."""
    curve = bpy.data.curves.new(f"{NAME}: {label.name}", "FONT")
    curve.body = f"{label.name}  {label.value}"
    curve.size = 17 * unit
    curve.align_x = "CENTER"
    curve.materials.append(_label_material())
    obj = bpy.data.objects.new(curve.name, curve)
    x, y, z = label.position
    obj.location = (x, y, z + (label.clearance + 5) * unit)
    if camera is not None:
        facing = obj.constraints.new("COPY_ROTATION")
        facing.target = camera
    else:
        obj.rotation_euler = (np.pi / 2, 0, 0)
    collection.objects.link(obj)
    return obj


def register() -> None:
    bpy.utils.register_class(HAPTIC_OT_graph_to_geometry)


def unregister() -> None:
    bpy.utils.unregister_class(HAPTIC_OT_graph_to_geometry)
