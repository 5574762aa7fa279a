"""Operators that put listeners on a body."""

from __future__ import annotations

import bpy
from bpy.types import Context, Object

from ...core.scene.body import BODY_PART, DEFAULT_LISTENERS, PAPER_LISTENERS, BodyPart
from ...core.scene.materials import MATERIALS
from ..authoring import body_kit, footsteps, materials
from ..blender.polling import LINKED, SOLID_TYPES, UNDO, Edit, OnActive, editable, is_editable
from ..blender.words import TranslatedError
from ..properties.kinds import choice, text
from ..scene_reader import bone_parts
from ..scene_reader.roles import haptic_carrier
from .materials import BODY_ITEMS
from .tagging import make_haptic

_PARTS = {"DEFAULT": DEFAULT_LISTENERS, "PAPER": PAPER_LISTENERS, "ALL": tuple(BODY_PART)}


class HAPTIC_OT_add_default_listeners(OnActive):
    """Put listeners on the active object: on the bones of an armature, or where a standing body that fills the object has its parts"""

    bl_label = "Add Body Listeners"
    bl_options = {*UNDO, "PRESET"}

    parts: choice(
        "Parts",
        "Which parts of the body get a listener",
        (
            (
                "DEFAULT",
                "Twelve",
                "Ears, hands, upper back, middle back, upper legs and feet: the default set-up",
            ),
            (
                "PAPER",
                "Ten",
                "Ears, hands, upper back, middle back and upper legs, as in the paper",
            ),
            ("ALL", "All 25", "Every part of the body that a device may have an actuator for"),
        ),
    )

    body: choice("Body", "How a new body damps vibration", BODY_ITEMS)

    def apply(self, context: Context) -> None:
        active = context.object
        armature = body_kit.armature_of(active)
        wanted = tuple(BODY_PART[name] for name in _PARTS[self.parts])
        if armature is not None:
            self._on_armature(context, armature, active, wanted)
            return
        if active.type not in SOLID_TYPES:
            raise TranslatedError(
                "'{}' has no surface: select the mesh or the armature of the body", active.name
            )
        is_new = not body_kit.listeners_on(active)
        try:
            body_kit.place_on_mesh(active, _new(active, wanted), context.collection)
        except ValueError as error:
            raise ValueError(f"{active.name}: {error}") from None
        if haptic_carrier(active) in (None, active):
            self._make_body(context, active, is_new)

    def _on_armature(
        self, context: Context, armature: Object, active: Object, wanted: tuple[BodyPart, ...]
    ) -> None:
        if not is_editable(armature):
            raise TranslatedError(LINKED)
        is_new = not body_kit.listeners_on(armature)
        try:
            missing = body_kit.place_on_bones(armature, _new(armature, wanted), context.collection)
        except ValueError as error:
            raise ValueError(f"{armature.name}: {error}") from None
        body = armature.haptics.body or (
            active
            if active.type == "MESH"
            else next(iter(editable(body_kit.skins(armature))), None)
        )
        if body is None:
            self.warn(
                "This armature moves no mesh: choose its body in the panel Selected Object, else "
                "nothing is felt"
            )
        else:
            self._make_body(context, body, is_new)
            armature.haptics.body = body
        if missing:
            names = ", ".join(part.name.replace("_", " ") for part in missing)
            self.warn("The armature has no bones for these parts, which got no listener: {}", names)

    def _make_body(self, context: Context, body: Object, is_new: bool) -> None:
        """Make a mesh haptic, of flesh unless its name tells another material. The flesh of a body
        that ``is_new``, which had no listeners yet, damps as chosen, except in a scene as in the
        paper."""
        if not body.haptics.enabled:
            guess = materials.guesses([body])[body]
            materials.make_haptic(context.scene, {body: guess or MATERIALS["flesh"]})
        is_chosen = self.body != "MEASURED" or body.haptics.function == "haptic_tracing"
        if (
            is_new
            and is_chosen
            and is_editable(body)
            and context.scene.haptics.strategy != "as_in_the_paper"
        ):
            materials.set_bodies([body], self.body)


class HAPTIC_OT_add_footsteps(Edit):
    """Let the steps of the character be felt: its body, and what its feet come to in the frames of the scene, become haptic, and its body gets listeners"""

    bl_label = "Footsteps"

    armature: text("Armature", "The character; that of the active object where empty")

    def apply(self, context: Context) -> None:
        scene = context.scene
        active = context.object
        armature = scene.objects.get(self.armature) or (active and body_kit.armature_of(active))
        if armature is None:
            raise TranslatedError("Select the armature or the mesh of a character")
        body = next(iter(editable(body_kit.skins(armature))), armature)
        with context.temp_override(object=body, active_object=body):
            bpy.ops.haptic.add_default_listeners()
        known = body_kit.listeners_on(armature)
        feet = [known[name] for name in ("foot.L", "foot.R") if name in known]
        if not feet:
            raise TranslatedError("'{}' has no bones of feet", armature.name)
        skins = footsteps.with_feet(editable(body_kit.skins(armature)), feet)
        if not skins:
            raise TranslatedError("'{}' moves no mesh with its feet", armature.name)
        for skin in skins:
            footsteps.add_rule(scene, skin)
            if bone_parts.armature_of(skin) is None:
                self.warn("'{}' has modifiers beside its armature: apply them first", skin.name)
        make_haptic(scene, skins)
        scene.haptics.impacts = True
        ground = footsteps.ground_of(scene, armature, feet)
        make_haptic(scene, editable(ground))
        if ground:
            names = ", ".join(obj.name for obj in ground[:5])
            self.tell("Steps of '{}' on {}: press play", armature.name, names)
        else:
            self.warn("'{}' walks on nothing: no mesh is under its feet", armature.name)


def _new(body: Object, wanted: tuple[BodyPart, ...]) -> list[BodyPart]:
    """The wanted parts that have no listener yet."""
    known = body_kit.listeners_on(body)
    return [part for part in wanted if part.name not in known]
