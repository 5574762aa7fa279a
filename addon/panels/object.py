"""Panel "Haptics" in Properties > Object: the material of the active object, and how it transmits
vibration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import bpy
from bpy.types import Context, Object, Panel, Scene, UILayout

from ...core.scene.coefficients import transfer_coefficient
from ...core.scene.functions import Physical
from ...core.scene.values import HapticObject, Listener, Source
from ..blender.polling import is_editable
from ..blender.words import ui_text
from ..session import sessions
from ..session.derived import Derived
from .drawing import (
    ObjectPanel,
    draw_held,
    draw_properties,
    poll_object,
    settings_layout,
    warn,
)
from .formula import draw_parameters
from .texts import draw_sentence, fitted

if TYPE_CHECKING:
    from ..properties.materials import HapticMaterial, HapticObjectMaterial

_AT_ORIGIN = 1e-4
"""Distance [m] up to which something stands at an origin."""
_SAME = 0.005
"""Difference of (1 - κ) ρ below which two materials feel the same."""


def library_owner(context: Context, obj: Object) -> Any:
    """The material of an object in the scene's library; None if it has none there, so that its own
    values count."""
    name = obj.haptics.material.name
    return context.scene.haptics.materials.items.get(name) if name else None


class HAPTIC_PT_object_settings(Panel):
    bl_label = "Haptics"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"

    poll = classmethod(poll_object)

    def draw(self, context: Context) -> None:
        draw_override(self.layout, context.object)
        if context.object.type == "ARMATURE":
            self.layout.prop(context.object.haptics, "body")


class HAPTIC_PT_object(ObjectPanel):
    bl_label = "Haptic Object"
    bl_options: Any = set()

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None and context.object.type != "ARMATURE"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.haptics, "enabled", text="")

    def draw(self, context: Context) -> None:
        layout = settings_layout(self, is_animated=True)
        obj = context.object
        haptics = obj.haptics
        if not haptics.enabled:
            return
        draw_transmission(layout, context, obj)
        material = library_owner(context, obj)
        # The library's values are shared and cannot be keyed.
        if material is not None and is_editable(obj):
            _draw_make_own(layout, ui_text("Make Own, to Key It"), "UNLINKED")
        layout.prop(haptics, "function")
        if haptics.function != "physical":  # whose parameters are those of the material
            draw_parameters(layout, haptics)
        draw_wave_speed(layout, haptics, material)
        draw_held(layout, haptics, HapticObject, kappa=None, rho=None)
        _draw_surface(layout, context, obj)
        _draw_origin(layout, context, obj)
        for lines in advice(context, obj):
            warn(layout, *lines)


def _draw_origin(layout: UILayout, context: Context, obj: Object) -> None:
    """Say that the origin of a source or listener is outside its body, and offer to move it."""
    traced, name = sessions.shown(context.scene), obj.name_full
    reading = None if traced is None else traced.reading
    if reading is None:
        return
    places: list[Source | Listener] = [*reading.sources, *reading.listeners]
    own = next((item for item in places if item.name == item.object == name), None)
    if own is None:
        return
    number = next(k for k, body in enumerate(reading.bodies) if body.name == name)
    away = math.dist(own.position, reading.transforms[number, :3, 3].tolist())
    if away > _AT_ORIGIN:
        unit = context.scene.unit_settings.system
        length = bpy.utils.units.to_string(unit, "LENGTH", away, precision=2)
        warn(layout, "Stands on its surface:", ui_text("its origin is {} outside", length))
        settled = layout.operator("object.origin_set", text="Set Origin", icon="OBJECT_ORIGIN")
        settled.type = "ORIGIN_GEOMETRY"


def draw_override(layout: UILayout, obj: Object) -> None:
    """Draw, for a linked object, the button that makes it editable."""
    if not is_editable(obj):
        warn(layout, "Linked: override it to edit it")
        layout.operator("object.make_override_library", icon="LIBRARY_DATA_OVERRIDE")


def draw_transmission(layout: UILayout, context: Context, obj: Object) -> None:
    """Draw the material of an object with its κ and ρ, those that a script may have set."""
    material, own = library_owner(context, obj), obj.haptics
    _draw_material(layout, context.scene, own.material, material)
    if own.function != "resilient":
        is_shared = material and (material.kappa, material.rho) == (own.kappa, own.rho)
        draw_properties(layout, material if is_shared else own, "kappa", "rho")
    if obj.haptics.function == "physical":
        _draw_dial(layout, obj)


def _draw_dial(layout: UILayout, obj: Object) -> None:
    """Draw what κ and ρ do beside the material's own values, if they differ from these."""
    haptics = obj.haptics
    k = transfer_coefficient(haptics.kappa, haptics.rho)
    if k < haptics.material_k - _SAME:
        lost = f"{20 * math.log10(haptics.material_k / k):.0f}" if k > 0 else "∞"
        draw_sentence(layout, ui_text("-{} dB through {}").format(lost, obj.name), "INFO")
    elif k > haptics.material_k + _SAME:
        words = ui_text("Below the material's own values only its loss over distance falls")
        draw_sentence(layout, words, "INFO")


def _draw_surface(layout: UILayout, context: Context, obj: Object) -> None:
    """Draw what of an object touches others, and how far its convex hull is from its surface."""
    haptics, body = obj.haptics, obj.rigid_body
    if body is None and not haptics.medium:
        layout.prop(haptics, "surface")
    traced = sessions.shown(context.scene)
    reading = None if traced is None else traced.reading
    hull = None if reading is None else reading.hulls.get(obj.name_full)
    rebuilding = 0.0 if reading is None else reading.rebuilt.get(obj.name_full, 0.0)
    if rebuilding > 1:
        words = ui_text("Its surface changes: to read it takes {:.0f} ms a frame")
        draw_sentence(layout, words.format(rebuilding), "INFO")
    is_hull = (
        haptics.surface == "CONVEX_HULL" if body is None else body.collision_shape == "CONVEX_HULL"
    )
    has_bones = body is None and hull is not None and hull.shape.type == "compound"
    if (
        hull is None
        or haptics.medium
        or not (is_hull or has_bones)
        or hull.deviation <= context.scene.haptics.contact_tolerance / 10
    ):
        return
    unit = context.scene.unit_settings.system
    length = bpy.utils.units.to_string(unit, "LENGTH", hull.deviation, precision=2)
    if has_bones:
        words = ui_text("A convex part for each bone touches, up to {} beside its surface")
        draw_sentence(layout, words.format(length), "INFO")
        return
    warn(layout, "Its convex hull touches,", ui_text("up to {} beside its surface", length))
    if body is not None:
        layout.prop(body, "collision_shape")


def draw_wave_speed(layout: UILayout, haptics: Any, material: Any) -> None:
    """Draw the wave speed of an object, or of its material."""
    layout.prop(haptics if material is None else material, "wave_speed")


def _draw_make_own(layout: UILayout, words: str, icon: str) -> None:
    """Draw the button that gives the active object a material of its own."""
    button = layout.operator("wm.context_set_string", text=words, icon=icon, translate=False)
    button.data_path = "object.haptics.material.name"


def _draw_material(
    layout: UILayout, scene: Scene, chosen: HapticObjectMaterial, material: HapticMaterial | None
) -> None:
    """Draw the material, and a button with the number of its objects if there are several, which
    gives this one its own."""
    row = layout.row(align=True)
    name = fitted(chosen.name, 0.8, icon=True, button=True) or ui_text("Its Own Material")
    row.menu("HAPTIC_MT_materials", text=name, icon="MATERIAL", translate=False)
    users = 0 if material is None else users_of(scene, chosen.name)
    if users > 1 or (chosen.name and material is None):
        words = str(users or "")
        icon = "NONE" if users else "UNLINKED"
        side = row.row(align=True)
        side.alignment = "RIGHT"
        side.enabled = is_editable(chosen.id_data)
        _draw_make_own(side, words, icon)
    if chosen.name and material is None:
        warn(layout, "Not in this scene's library:", "the object keeps its values")
        layout.operator("haptic.new_material", text="Add to Library", icon="ADD")


_USERS: Derived[str, int] = Derived(
    lambda traced, name, _: sum(item.material == name for item in traced.result.graph.table.objects)
)


def users_of(scene: Scene, material: str) -> int:
    """How many haptic objects of the shown frame are of a material, without waiting."""
    latest = _USERS.latest(scene, material)
    return 0 if latest is None else latest.value


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
                yield ui_text("Feels the same as {}:", twin), "only (1 - κ) ρ counts"
    elif haptics.function == "constant" and haptics.constant == 0:
        yield ("Passes on nothing: the gain is 0",)
    if obj.rigid_body is not None and context.scene.rigidbody_world is None:
        yield "This rigid body does not move:", "the scene has no Rigid Body World"


def _twin(context: Context, haptics: Any) -> str | None:
    """Another material of the library with the same (1 - κ) ρ by other κ and ρ."""
    k = transfer_coefficient(haptics.kappa, haptics.rho)
    for item in context.scene.haptics.materials.items:
        if (
            item.name != haptics.material.name
            and abs(transfer_coefficient(item.kappa, item.rho) - k) <= _SAME
        ):
            return str(item.name)
    return None


class HAPTIC_PT_constants(ObjectPanel):
    bl_parent_id = "HAPTIC_PT_object"
    bl_label = "Physical Constants"
    bl_order = 1  # after the panels of plug-ins

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        return (
            obj is not None
            and obj.type != "ARMATURE"
            and obj.haptics.enabled
            and obj.haptics.function == "physical"
        )

    def draw(self, context: Context) -> None:
        draw_held(settings_layout(self, is_animated=True), context.object.haptics, Physical)
