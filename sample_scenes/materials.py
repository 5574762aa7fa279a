"""Surfaces (Blender materials) and substances (presets of the haptic library) of sample scenes."""

from __future__ import annotations

import bpy
from bpy.types import Material, Node, NodeTree, Object, Scene, World

from ..addon.authoring import materials as library
from ..core.scene.materials import MATERIALS
from ..core.scene.materials import Material as Substance

STEEL = MATERIALS["steel"]
STONE = MATERIALS["stone"]
CONCRETE = MATERIALS["concrete"]
CERAMIC = MATERIALS["ceramic"]
HARDWOOD = MATERIALS["hardwood"]
SOFTWOOD = MATERIALS["softwood"]
SOIL = MATERIALS["soil"]
RUBBER = MATERIALS["rubber"]
RIBBON = MATERIALS["ribbon"]
FABRIC = MATERIALS["fabric"]
FLESH = MATERIALS["flesh"]


WEAK_BRIGHTNESS = 0.6
"""Brightness of weak impacts above 100 Hz: a slower impact has a longer contact."""


def tag(scene: Scene, obj: Object, substance: Substance) -> Object:
    """Make ``obj`` a haptic object of a material of the library of ``scene``, with the preset's
    values and the paper's function."""
    obj.haptics.function = "haptic_tracing"
    obj.haptics.enabled = True
    library.apply([obj], library.preset_in(scene, substance))
    return obj


def measure(scene: Scene, body: str) -> None:
    """Give the objects of ``scene`` the measured functions of their materials; ``body``: how people
    feel, as in *Bodies*."""
    bpy.context.view_layer.update()
    objects = [obj for obj in scene.objects if obj.haptics.enabled]
    library.make_physical(objects)
    library.set_bodies(objects, body)


def bind(scene: Scene, substance: Substance) -> None:
    """Let contacts of a substance pass on everything, as of what is embedded in it."""
    rule = scene.haptics.transmission_table.items.add()
    rule.first_kind, rule.first, rule.function = "MATERIAL", substance.title, "identity"


def isolate(scene: Scene, substance: Substance, frequency: float) -> None:
    """Make contacts of a substance springs of a resonance at ``frequency`` [Hz]."""
    rule = scene.haptics.transmission_table.items.add()
    rule.first_kind, rule.first, rule.function = "MATERIAL", substance.title, "resilient"
    rule.spring_frequency = frequency


def vary_impacts(scene: Scene, variation: float) -> None:
    """Vary the impacts of ``scene``, and make weak ones duller than strong ones."""
    rule = scene.haptics.impact_table.items.add()
    rule.brightness = (WEAK_BRIGHTNESS, 1.0)
    rule.variation = variation


def node_tree(owner: Material | World) -> NodeTree:
    """The shader nodes of a material or world, which has them from the start in newer versions
    only."""
    if owner.node_tree is None:
        owner.use_nodes = True
    return owner.node_tree


def linear_colour(code: str) -> tuple[float, float, float, float]:
    """An sRGB colour such as ``#e0a030`` in the linear values that Blender computes with."""
    channels = (int(code[k : k + 2], 16) / 255 for k in (1, 3, 5))
    red, green, blue = (
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels
    )
    return (red, green, blue, 1.0)


def surface(
    name: str,
    colour: str,
    roughness: float = 0.6,
    metallic: float = 0.0,
    *,
    glow: float = 0.0,
    mottle: float = 0.0,
    mottle_scale: float = 6.0,
) -> Material:
    """A new material, which looks alike in the solid viewport.

    colour: sRGB. glow: strength of the light it gives off. mottle: how far, in [0, 1], a noise of
    ``mottle_scale`` blotches per metre darkens it.
    """
    material = bpy.data.materials.new(name)
    # The viewport's studio light is dimmer than the scenes' own.
    material.diffuse_color = tuple(channel**0.8 for channel in linear_colour(colour))
    material.roughness = roughness
    material.metallic = metallic
    tree = node_tree(material)
    shader = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = linear_colour(colour)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    if glow > 0:
        shader.inputs["Emission Color"].default_value = linear_colour(colour)
        shader.inputs["Emission Strength"].default_value = glow
    if mottle > 0:
        _add_mottle(tree, shader, colour, mottle, mottle_scale)
    return material


def _add_mottle(tree: NodeTree, shader: Node, colour: str, amount: float, scale: float) -> None:
    place = tree.nodes.new("ShaderNodeTexCoord")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = scale
    noise.inputs["Detail"].default_value = 6.0
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    bright = linear_colour(colour)
    ramp.color_ramp.elements[0].position = 0.35
    ramp.color_ramp.elements[0].color = (*(channel * (1 - amount) for channel in bright[:3]), 1.0)
    ramp.color_ramp.elements[1].position = 0.65
    ramp.color_ramp.elements[1].color = bright
    tree.links.new(place.outputs["Object"], noise.inputs["Vector"])
    tree.links.new(noise.outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], shader.inputs["Base Color"])
    for column, node in enumerate((place, noise, ramp)):
        node.location = (-900 + 250 * column, 300)
