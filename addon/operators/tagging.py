"""Operators that assign and remove the haptic roles of objects, and that select an object."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Object, Scene

from ...core.scene.materials import is_wide_and_flat
from ..authoring import body_kit, materials
from ..authoring.signals import signal_for
from ..blender.polling import (
    SOLID_TYPES,
    UNDO,
    Edit,
    OnActive,
    OnSelected,
    Refused,
    editable,
    linked_message,
)
from ..blender.progress import progress
from ..blender.units import metres_per_unit
from ..blender.words import TranslatedError, report_text
from ..changes.events import made_haptic
from ..changes.suspension import suspended
from ..properties.kinds import choice, switch, text
from ..properties.signal_kinds import PLAIN
from ..scene_reader.instances import with_instanced
from ..scene_reader.roles import haptic_carrier
from ..session import session, worker

_FEW = 4
"""Number of objects up to which nothing is asked about their materials."""


def make_haptic(scene: Scene, objects: list[Object], guess: bool = True) -> int:
    """Make objects haptic, with guessed materials where they were not haptic before. Returns how
    many materials were guessed."""
    new = [obj for obj in objects if not obj.haptics.enabled]
    unknown = [obj for obj in new if guess and not obj.haptics.material.name]
    guesses = materials.guesses(unknown)
    materials.make_haptic(scene, {obj: guesses.get(obj) for obj in new})
    return sum(material is not None for material in guesses.values())


made_haptic.subscribe(lambda obj: materials.become_haptic(obj))


class HAPTIC_OT_make_objects(OnSelected):
    """Let vibration pass through the selected objects; what they are made of is guessed from their names, shapes and masses"""

    bl_label = "Make Haptic"
    bl_options = {*UNDO, "PRESET"}

    guess: switch(
        "Guess Materials", "Choose materials by the names, shapes and masses of the objects", True
    )
    physics: switch(
        "Add Physics",
        "Make the objects rigid bodies: wide and flat ones are passive, all others fall",
    )

    def apply(self, context: Context) -> None:
        chosen = context.selected_objects
        moved = [skin for obj in chosen if obj.type == "ARMATURE" for skin in body_kit.skins(obj)]
        chosen = list(dict.fromkeys([*chosen, *moved]))
        solid = [obj for obj in editable(with_instanced(chosen)) if obj.type in SOLID_TYPES]
        if not solid:
            instancer = next((obj for obj in editable(chosen) if obj.instance_collection), None)
            if instancer is not None:
                raise TranslatedError(
                    "'{}' shows a collection that is linked from a library or has no surface: "
                    "use Object > Apply > Make Instances Real, then make the objects haptic",
                    instancer.name,
                )
            message = (
                "None of the selected objects has a surface that can touch others; select "
                "meshes that are not linked from a library"
            )
            raise ValueError(linked_message(chosen) or message)
        new = [obj for obj in solid if not (obj.haptics.enabled or obj.haptics.material.name)]
        known = make_haptic(context.scene, solid, self.guess)
        if self.options.is_invoke and self.guess and len(new) > max(_FEW, 2 * known):
            bpy.ops.haptic.guess_material("INVOKE_DEFAULT", match=True)
        if self.physics:
            add_physics(context, solid)
        if len(new) > known:
            words = "Made haptic: {}. Taken for plastic: {}; choose the material in Selected Object"
            self.tell(words, len(solid), len(new) - known)
        else:
            words = "Objects made haptic: {}, with a guessed material: {}"
            self.tell(words, len(solid), known)


def add_physics(context: Context, objects: list[Object]) -> None:
    """Add rigid bodies of 1 kg to meshes without one: wide and flat ones are passive."""
    new = [obj for obj in objects if obj.rigid_body is None and obj.type == "MESH"]
    if not new:
        return
    session.make_way(worker.MOMENT)
    with (
        suspended(),
        context.temp_override(object=new[0], active_object=new[0], selected_objects=new[:1]),
    ):
        bpy.ops.rigidbody.object_add()  # and the scene's Rigid Body World if it is missing
    world = context.scene.rigidbody_world
    assert world is not None
    metres = metres_per_unit(context.scene)
    for obj in progress(new):
        if obj.rigid_body is None:
            world.collection.objects.link(obj)
        body: Any = obj.rigid_body
        is_floor = is_wide_and_flat(tuple(obj.dimensions * metres))
        body.type = "PASSIVE" if is_floor else "ACTIVE"
        body.mass = metres**-3


class HAPTIC_OT_add_source(OnActive):
    """Make the active object a haptic source: it emits a signal into the objects that it touches"""

    bl_label = "Add Source"
    bl_options = {*UNDO, "PRESET"}

    signal: choice(
        "Signal",
        "What the source emits",
        (
            (
                "AUTO",
                "By Name",
                "Guess the signal from the name: a jackhammer blows, an engine hums; a sine for "
                "other names",
            ),
            *((kind, plain.label, plain.about) for kind, plain in PLAIN.items()),
        ),
        default="AUTO",
    )

    def apply(self, context: Context) -> None:
        let_shake(context.scene, context.object)
        make_source(context.object, self.signal)


def let_shake(scene: Scene, obj: Object) -> None:
    """Make an object haptic unless it is on one that is. Raises ValueError if it cannot be."""
    if haptic_carrier(obj) is None:
        if obj.type not in SOLID_TYPES:
            raise ValueError(
                linked_message([obj])
                or report_text(
                    "'{}' has no surface: parent it to a haptic object first, so that it has "
                    "something to shake",
                    obj.name,
                )
            )
        make_haptic(scene, [obj])


def make_source(obj: Object, signal: str) -> None:
    """Make an object a source of a signal; AUTO: the signal that its name suggests."""
    source = obj.haptics.source
    source.enabled = True
    if signal == "AUTO":
        told = signal_for(obj.name)
        source.signal = told.signal
        source.frequency = told.frequency
        source.amplitude = told.amplitude
    else:
        source.signal = signal


class HAPTIC_OT_add_listener(OnSelected):
    """Make the selected objects haptic listeners: what arrives at their origins is felt"""

    bl_label = "Add Listener"

    def apply(self, context: Context) -> None:
        chosen = context.selected_objects
        own = editable(chosen)
        nowhere = [
            obj for obj in own if haptic_carrier(obj) is None and obj.type not in SOLID_TYPES
        ]
        for obj in progress([obj for obj in own if obj not in set(nowhere)]):
            if haptic_carrier(obj) is None:
                make_haptic(context.scene, [obj])
            obj.haptics.listener.enabled = True
        if nowhere:
            raise ValueError(
                linked_message(nowhere)
                or report_text(
                    "Parent these to haptic objects first, so that they touch something: {}",
                    ", ".join(obj.name for obj in nowhere[:5]),
                )
            )
        if not own:
            raise ValueError(linked_message(chosen))


class HAPTIC_OT_clear(OnSelected):
    """Remove all haptic roles from the selected objects; their settings are kept"""

    bl_label = "Clear Haptics"

    def apply(self, context: Context) -> None:
        own = editable(context.selected_objects)
        for obj in progress(own):
            obj.haptics.enabled = obj.haptics.source.enabled = obj.haptics.listener.enabled = False
        if not own:
            raise ValueError(linked_message(context.selected_objects))


class HAPTIC_OT_select_object(Edit):
    """Select the object and make it active"""

    bl_label = "Select Object"
    bl_options = {*UNDO, "INTERNAL"}

    name: text("Object", "Name of the object", options={"SKIP_SAVE"})
    extend: switch("Extend", "Keep what is selected", options={"SKIP_SAVE"})

    def apply(self, context: Context) -> None:
        found: Any = next(
            (obj for obj in context.view_layer.objects if obj.name_full == self.name), None
        )
        if found is None:
            raise Refused("There is no object '{}' in this view layer any more", self.name)
        if not self.extend:
            for obj in context.selected_objects:
                obj.select_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
