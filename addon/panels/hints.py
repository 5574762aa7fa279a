"""Hints: what a user should know, and the next step to a vibration that is felt."""

from __future__ import annotations

import math
from collections.abc import Callable

from bpy.types import Scene, UILayout

from ...core.frozen import frozen
from ..authoring import body_kit
from ..blender.units import metres_per_unit
from ..blender.words import ui_text
from ..scene_reader import roles, settings
from ..session import sessions

_SLOWEST_FALL, _FASTEST_FALL = 5.0, 15.0  # m/s²


@frozen
class Hint:
    """What to know, or to do next, in ``words``; ``draw``: draws the button or field for it;
    ``is_in_quick_start``: whether that says it, too."""

    words: str = ""
    icon: str = "INFO"
    draw: Callable[[UILayout], object] | None = None
    is_in_quick_start: bool = False


def button(operator: str, icon: str = "NONE", **values: str) -> Callable[[UILayout], object]:
    """A function that draws the button of an operator with these values."""

    def draw(layout: UILayout) -> None:
        properties = layout.operator(operator, icon=icon)
        for key, value in values.items():
            setattr(properties, key, value)

    return draw


def next_step(scene: Scene) -> Hint | None:
    """What to do next, until there is a listener, of which the summary says everything else; None
    then, or while the first frame is traced."""
    if not scene.haptics.tracing:
        words = ui_text("Tracing is switched off")
        return Hint(words, "ERROR", lambda row: row.prop(scene.haptics, "tracing"))
    traced = sessions.shown(scene)
    if traced is None and sessions.is_behind(scene):
        return None
    if traced is None or not traced.result.objects:
        if traced is None and roles.is_any_tagged(scene):
            return Hint(ui_text("Nothing traced yet"), draw=button("haptic.trace_frame"))
        words = ui_text("Select objects that touch, and press Make Haptic below")
    elif not _has_sources(scene, traced):
        words = ui_text("Select what vibrates, and press Add Source below")
    elif not traced.result.listeners:
        words = ui_text(
            "Select what feels, and press Add Listener, or Add Body Listeners for a body"
        )
    else:
        return None
    return Hint(words, is_in_quick_start=True)


def striking_nothing(scene: Scene) -> tuple[str, str] | None:
    """The first animated armature that strikes nothing, and why; None if there is none."""
    for obj in scene.objects:
        if obj.type != "ARMATURE" or obj.animation_data is None:
            continue
        own = {*body_kit.skins(obj), *obj.children_recursive}
        if not any(part.haptics.enabled for part in own):
            return obj.name, ui_text("Nothing strikes: no object of '{}' is haptic", obj.name)
        if all(part in own or not part.haptics.enabled for part in scene.objects):
            words = ui_text("'{}' strikes nothing: what it walks on is not haptic", obj.name)
            return obj.name, words
    return None


def of_units(scene: Scene) -> Hint | None:
    """What the user should decide about gravity at the unit scale; None if it is about that of
    Earth."""
    if (
        not roles.is_any_tagged(scene)
        or not scene.haptics.impacts
        or scene.rigidbody_world is None
        or metres_per_unit(scene) == 1.0
    ):
        return None
    fall = math.hypot(*settings.gravity_of(scene))
    if _SLOWEST_FALL <= fall <= _FASTEST_FALL:
        return None
    field = "gravity" if scene.use_gravity else "use_gravity"
    words = ui_text("Gravity: {:.3g} m/s² (on Earth 9.81)", fall)
    return Hint(words, draw=lambda row: row.column(align=True).prop(scene, field))


def _has_sources(scene: Scene, traced: sessions.Traced) -> bool:
    """True if there is a source, or if bodies with a mass, or skins, may move, whose impacts,
    sliding or rolling are sources."""
    if traced.result.sources or traced.reading is None or traced.reading.sources:
        return True
    excites = scene.haptics.impacts or len(scene.haptics.textures.items) > 0
    return excites and any(
        (body.mass or body.limbs) and body.motion != "static" for body in traced.reading.bodies
    )
