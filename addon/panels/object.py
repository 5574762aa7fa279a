"""Panel "Haptic Object": the material of the active object, and how it transmits vibration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Object, Panel, Scene, UILayout

from ...core.scene.bands import BAND_EDGES
from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.values import HapticObject
from ..blender.polling import is_editable
from ..properties.preferences import gain_text, preferences
from ..scene_reader import functions
from ..session import sessions
from ..view import gain_plot, panel_picture
from .drawing import (
    ClosedPanel,
    HapticsPanel,
    draw_held,
    draw_pair,
    draw_properties,
    poll_object,
    warn,
)
from .formula import draw_parameters
from .texts import draw_sentence

if TYPE_CHECKING:
    from ...core.scene.functions import ModulationFunction
    from ..properties.materials import HapticMaterial, HapticObjectMaterial
    from ..properties.object import HapticObjectProperties

_SAME = 0.005
"""Difference of (1 - κ) ρ below which two materials feel the same."""


def library_owner(context: Context, obj: Object) -> Any:
    """The material of an object in the scene's library; None if it has none there, so that its own
    values count."""
    name = obj.haptics.material.name
    return context.scene.haptics.materials.items.get(name) if name else None


def _poll_haptic(cls: type[Panel], context: Context) -> bool:
    """There is an active object that is haptic, and not a skeleton."""
    return (
        context.object is not None
        and context.object.type != "ARMATURE"
        and context.object.haptics.enabled
    )


class HAPTIC_PT_object(HapticsPanel, Panel):
    bl_label = "Haptic Object"
    bl_order = 10

    poll = classmethod(poll_object)

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        obj = context.object
        haptics = obj.haptics
        if not is_editable(obj):
            warn(layout, "Linked: override it to edit it")
            layout.operator("object.make_override_library", icon="LIBRARY_DATA_OVERRIDE")
        if obj.type == "ARMATURE":
            layout.prop(haptics, "body")
            return
        if not haptics.enabled:
            return
        layout.label(text=obj.name, icon="OBJECT_DATA", translate=False)
        material = library_owner(context, obj)
        _draw_material(layout, context.scene, haptics.material, material)
        draw_properties(layout, material or haptics, "kappa", "rho")
        if material is not None:  # the library's values are shared and cannot be keyed
            layout.operator("haptic.unlink_material", text="Make Own, to Key It", icon="UNLINKED")
        layout.prop(haptics, "function")
        draw_parameters(layout, haptics, haptics.kappa, haptics.rho, context.scene.haptics.epsilon)
        draw_wave_speed(layout, haptics, material)
        draw_held(layout, haptics, HapticObject, kappa=None, rho=None)
        _draw_surface(layout, context, obj)
        for lines in advice(context, obj):
            warn(layout, *lines)


def _draw_surface(layout: UILayout, context: Context, obj: Object) -> None:
    """Draw what of an object touches others, and how far its convex hull is from its surface."""
    haptics, body = obj.haptics, obj.rigid_body
    if body is None and not haptics.medium:
        layout.prop(haptics, "surface")
        if haptics.surface in ("SEEN", "SOLID"):
            layout.prop(haptics, "sunk_in")
    traced = sessions.shown(context.scene)
    hull = (
        None
        if traced is None or traced.reading is None
        else traced.reading.hulls.get(obj.name_full)
    )
    is_hull = (
        haptics.surface == "CONVEX_HULL" if body is None else body.collision_shape == "CONVEX_HULL"
    )
    if (
        hull is None
        or haptics.medium
        or not is_hull
        or hull.deviation <= context.scene.haptics.contact_tolerance / 10
    ):
        return
    unit = context.scene.unit_settings.system
    length = bpy.utils.units.to_string(unit, "LENGTH", hull.deviation, precision=2)
    warn(layout, "Its convex hull touches,", iface_("up to {} beside its surface").format(length))
    if body is None:
        layout.operator("haptic.use_real_surface", icon="MESH_DATA")
    else:
        layout.operator("haptic.use_mesh", icon="MESH_DATA")


def draw_wave_speed(layout: UILayout, haptics: Any, material: Any) -> None:
    """Draw the wave speed: a material has a switch for it, an object's own is off at 0."""
    if material is None:
        layout.prop(haptics, "wave_speed")
        return
    row = layout.row(heading="Delay")
    row.prop(material, "use_delay", text="")
    side = row.row()
    side.active = material.use_delay
    side.prop(material, "wave_speed", text="")


def _draw_material(
    layout: UILayout, scene: Scene, chosen: HapticObjectMaterial, material: HapticMaterial | None
) -> None:
    row = layout.row(align=True)
    row.use_property_split = False
    if not chosen.name and not scene.haptics.materials.items:
        row.menu("HAPTIC_MT_materials", text="Choose Material", icon="MATERIAL")
    else:
        row.prop_search(chosen, "name", scene.haptics.materials, "items", text="", icon="MATERIAL")
        row.menu("HAPTIC_MT_materials", text="", icon="DOWNARROW_HLT")
    if chosen.name and material is None:
        row.operator("haptic.unlink_material", text="", icon="UNLINKED")
    if chosen.name and material is None:
        warn(layout, "Not in this scene's library:", "the object keeps its values")
        layout.operator("haptic.new_material", text="Add to Library", icon="ADD")


def advice(context: Context, obj: Object) -> Iterator[tuple[str, ...]]:
    """Remarks on the values of an object, each as lines that fit into the panel."""
    haptics = obj.haptics
    if not haptics.enabled:
        return
    if haptics.function == "haptic_tracing":
        if haptics.kappa == 1:
            yield "Passes on nothing: κ is 1", "and only (1 - κ) ρ counts"
        elif haptics.rho == 0:
            yield "Passes on nothing: ρ is 0", "and only (1 - κ) ρ counts"
        else:
            twin = _twin(context, haptics)
            if twin is not None:
                yield iface_("Feels the same as {}:").format(twin), "only (1 - κ) ρ counts"
    elif haptics.function == "constant" and haptics.constant == 0:
        yield ("Passes on nothing: the gain is 0",)
    if obj.rigid_body is not None and context.scene.rigidbody_world is None:
        yield "This rigid body does not move:", "the scene has no Rigid Body World"


def _twin(context: Context, haptics: Any) -> str | None:
    """Another material of the library with the same (1 - κ) ρ by other κ and ρ."""
    k = transfer_coefficient(haptics.kappa, haptics.rho)
    for item in context.scene.haptics.materials.items:
        if (
            item.name == haptics.material.name
            or abs(transfer_coefficient(item.kappa, item.rho) - k) > _SAME
        ):
            continue
        bands = tuple(item.band_decays) if item.use_bands else ()
        if bands == (tuple(haptics.material.band_decays) if haptics.material.use_bands else ()):
            return item.name
    return None


class HAPTIC_PT_gain(HapticsPanel, Panel):
    bl_parent_id = "HAPTIC_PT_object"
    bl_label = "Gain over Distance"

    poll = classmethod(_poll_haptic)

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.object.haptics
        key = _curve_key(haptics, context.scene)
        latest = None if key is None else gain_plot.latest_curve(key)
        if key is not None and latest is None:
            layout.label(text="Computing...", icon="SORTTIME")
            return
        curve = None if latest is None else latest.value
        if curve is None:
            layout.label(text="The formula gives no gain", icon="ERROR")
            return
        icon = gain_plot.icon(
            curve, tuple(preferences().curve_colour), panel_picture.theme_ink(context)
        )
        layout.template_icon(icon_value=icon, scale=7.0)
        row = layout.row()
        row.label(text="0 m, 0 to -60 dB")
        side = row.row()
        side.alignment = "RIGHT"
        side.label(text=f"{curve.length:g} m")
        column = layout.column(align=True)
        column.scale_y = 0.8
        if haptics.function == "haptic_tracing":
            draw_pair(
                column, "K = (1 - κ) ρ", f"{transfer_coefficient(haptics.kappa, haptics.rho):.2f}"
            )
        for distance in (0.0, curve.length / 10, curve.length / 2):
            draw_pair(column, f"{distance:g} m", gain_text(curve.at(distance)))
        if curve.bands is not None:
            column.label(text="Thin lines: 30, 100 and 300 Hz")
        if haptics.function == "haptic_tracing":
            crossing = _crossing(context, haptics)
            if crossing is not None:
                draw_sentence(
                    layout,
                    iface_("Crosses {} at {:.1f} m: the higher gain near by falls sooner").format(
                        *crossing
                    ),
                    "INFO",
                )


def _crossing(context: Context, haptics: Any) -> tuple[str, float] | None:
    """The material of the scene's library whose curve, by the paper's function, crosses the
    object's curve first, and the distance [m]."""
    k, least = transfer_coefficient(haptics.kappa, haptics.rho), context.scene.haptics.epsilon
    found = []
    for item in context.scene.haptics.materials.items:
        other = transfer_coefficient(item.kappa, item.rho)
        if k > 0 and other > 0 and abs(k - other) > _SAME and max(k, least) != max(other, least):
            found.append((math.log(k / other) / (max(k, least) - max(other, least)), item.name))
    return None if not found else min(found)[::-1]


def _curve_key(
    haptics: HapticObjectProperties, scene: Scene
) -> tuple[ModulationFunction, float, float, float] | None:
    """The values that determine the active object's curve; None if its function is invalid."""
    try:
        return functions.read_function(haptics), haptics.kappa, haptics.rho, scene.haptics.epsilon
    except ValueError:
        return None


class HAPTIC_PT_bands(ClosedPanel, Panel):
    bl_parent_id = "HAPTIC_PT_object"
    bl_label = "Frequency Bands"

    poll = classmethod(_poll_haptic)

    def draw_header(self, context: Context) -> None:
        owner = library_owner(context, context.object) or context.object.haptics.material
        self.layout.prop(owner, "use_bands", text="")

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        owner = library_owner(context, context.object) or context.object.haptics.material
        layout.active = owner.use_bands
        layout.label(text="Extra attenuation per metre")
        column = layout.column(align=True)
        for index, (low, high) in enumerate(pairwise(BAND_EDGES)):
            column.prop(owner, "band_decays", index=index, text=f"{low:g} - {high:g} Hz")
