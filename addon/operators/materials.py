"""Operators of haptic materials."""

from __future__ import annotations

from typing import Any

from bpy.types import Context, Event

from ...core.scene.materials import MATERIALS
from ..authoring import materials as library
from ..blender.polling import (
    SOLID_TYPES,
    Edit,
    Need,
    OnActive,
    OnSelected,
    editable,
)
from ..blender.progress import progress
from ..blender.words import TranslatedError, show
from ..properties.kinds import choice, switch, text
from ..properties.materials import PRESET_ITEMS, TARGET_ITEMS, add_material, made_of, values_of
from ..scene_reader.instances import with_instanced

_MOST_ROWS = 30
"""Rows of the list of names."""

MODEL_ITEMS = (
    (
        "PHYSICAL",
        "Physical",
        "Measured spreading and damping, and the best path",
    ),
    (
        "PAPER",
        "As in the Paper",
        "The paper's function of κ and ρ, contacts that pass on everything, and all paths of "
        "persistent sources",
    ),
)
BODY_ITEMS = (
    (
        "MEASURED",
        "Measured",
        "Each part damps as measured above its resonance: a floor is felt at the feet",
    ),
    (
        "FELT_ALL_OVER",
        "Felt All Over",
        "A design choice, not measured: 5 dB less per metre, so that the whole body feels what "
        "it touches",
    ),
)


def _has_active(context: Context) -> bool:
    """Whether the library has an active material."""
    materials = context.scene.haptics.materials
    return 0 <= materials.active < len(materials.items)


class _OnMaterial(Edit):
    """Mixin: an operator on the active material of the library."""

    needs = (*Edit.needs, Need(_has_active, "Choose a material of the library first"))


class HAPTIC_OT_apply_material(OnSelected):
    """Assign a material to objects; they share it, so that editing it changes all of them"""

    bl_label = "Apply Material"

    preset: choice("Material", "What the objects are made of", PRESET_ITEMS, default="stone")
    name: text(
        "From Library",
        "A material of the scene's library instead of a preset",
        options={"SKIP_SAVE", "HIDDEN"},
    )
    target: choice("Apply To", "What the material is applied to", TARGET_ITEMS)

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        material = MATERIALS[properties.preset]
        if properties.name:
            return ""
        speed = f", {material.wave_speed:g} m/s" if material.wave_speed else ""
        return f"κ {material.kappa:g}, ρ {material.rho:g}, (1 - κ) ρ = {material.k:.2f}{speed}"

    def apply(self, context: Context) -> None:
        chosen = library.targets(context, self.target)
        objects = [obj for obj in editable(chosen) if obj.type in SOLID_TYPES]
        if not objects:
            raise TranslatedError(
                "No object with a surface among them; select meshes that are not linked from "
                "a library"
            )
        items = context.scene.haptics.materials.items
        if self.name and self.name not in items:
            raise TranslatedError("This material is not in the scene's library any more")
        item = (
            items[self.name]
            if self.name
            else library.preset_in(context.scene, MATERIALS[self.preset])
        )
        library.apply(objects, item)
        linked = len(chosen) - len(editable(chosen))
        if linked:
            self.warn("{} linked objects can't be changed; override them first", linked)


class HAPTIC_OT_guess_material(OnSelected):
    """Guess from names, shapes and masses what the selected objects are made of, or choose it for each of their Blender materials, once; Make Haptic and Guess Material then use it"""

    bl_label = "Guess Material"

    match: switch(
        "Match",
        "Choose the haptic material for each Blender material first",
        options={"SKIP_SAVE", "HIDDEN"},
    )

    def invoke(self, context: Context, event: Event) -> set[str]:
        if not self.match:
            return self.execute(context)
        library.list_names(context.scene, with_instanced(context.selected_objects))
        return context.window_manager.invoke_props_dialog(self, width=420)

    def draw(self, context: Context) -> None:
        if not self.match:
            return
        rows = context.scene.haptics.materials.names
        wanted = library.names_of_surfaces(with_instanced(context.selected_objects))
        column = self.layout.column(align=True)
        for name in wanted[:_MOST_ROWS]:
            if name in rows:
                split = column.split(factor=0.5)
                show(split, name)
                split.prop(rows[name], "preset", text="")

    def apply(self, context: Context) -> set[str]:
        chosen = with_instanced(context.selected_objects)
        objects = [obj for obj in editable(chosen) if obj.type in SOLID_TYPES]
        known = library.apply_guesses(context.scene, objects)
        self.tell(
            "{} of {} objects have a name, shape or mass that tells their material",
            known,
            len(objects),
        )
        return {"FINISHED"} if known or self.match else {"CANCELLED"}


class HAPTIC_OT_set_model(Edit):
    """Choose between measured materials and the paper's model for the whole scene: functions of all objects made of presets, and the strategy; objects made later follow"""

    bl_label = "Model"
    bl_property = "model"  # so that a button tells its item

    model: choice("Model", "What the scene is computed by", MODEL_ITEMS)
    in_a_building: switch(
        "In a Building", "Walls and floors in place, whose joints and edges take 2 dB per metre"
    )

    def apply(self, context: Context) -> None:
        scene = context.scene
        objects = [obj for obj in editable(with_instanced(scene.objects)) if obj.haptics.enabled]
        if self.model == "PAPER":
            scene.haptics.strategy = scene.haptics.impact_energy = "as_in_the_paper"
            known = library.use_paper(objects)
        else:
            scene.haptics.impact_energy = "effective"
            if scene.haptics.strategy == "as_in_the_paper":
                scene.haptics.strategy = "best_path"
            known = library.make_physical(objects, self.in_a_building)
        self.tell("{} of {} haptic objects are made of a preset", known, len(objects))


class HAPTIC_OT_set_bodies(Edit):
    """Choose how all objects of flesh damp vibration; other objects keep their functions"""

    bl_label = "Bodies"
    bl_property = "body"

    body: choice("Bodies", "How objects of flesh damp vibration", BODY_ITEMS)

    def apply(self, context: Context) -> None:
        shown = editable(with_instanced(context.scene.objects))
        if not library.set_bodies((obj for obj in shown if obj.haptics.enabled), self.body):
            raise TranslatedError(
                "No haptic object is made of flesh: select a body and press Add Body Listeners"
            )


class HAPTIC_OT_new_material(OnActive):
    """Add a material with the values of the active object to the library, and assign it to that object"""

    bl_label = "New Material"

    def apply(self, context: Context) -> None:
        obj = context.object
        item = add_material(
            context.scene, obj.haptics.material.name or obj.name, values_of(obj.haptics)
        )
        library.apply([obj], item)


class HAPTIC_OT_remove_material(_OnMaterial):
    """Remove the active material from the library; its objects keep their values"""

    bl_label = "Remove Material"

    def apply(self, context: Context) -> None:
        materials = context.scene.haptics.materials
        for obj in progress(list(made_of(context.scene, materials.items[materials.active].name))):
            obj.haptics.material.name = ""
        materials.items.remove(materials.active)
        materials.active = max(0, min(materials.active, len(materials.items) - 1))
