"""The hint for the next step from an empty scene to a vibration that is felt, with its button."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Scene, UILayout

from ..scene_reader import roles
from ..session import sessions
from ..view import air_contacts
from .texts import draw_sentence, source_title

if TYPE_CHECKING:
    from ...core.scene.values import Source


@dataclass(frozen=True, slots=True)
class Hint:
    """The next step in ``words``, and its operators with their icons."""

    words: str
    operators: tuple[tuple[str, str], ...] = ()


def draw_hint(layout: UILayout, context: Context) -> None:
    """Draw the next step with large buttons."""
    _draw_air(layout, context.scene)
    hint = next_step(
        context.scene, context.screen is not None and context.screen.is_animation_playing
    )
    if hint is None:
        return
    box = layout.box()
    draw_sentence(box, hint.words, "INFO")
    column = box.column(align=True)
    column.scale_y = 1.3
    for operator, icon in hint.operators:
        column.operator(operator, icon=icon)


def _draw_air(layout: UILayout, scene: Scene) -> None:
    """Offer the surfaces of objects whose convex hulls touch others through air."""
    if sessions.shown(scene) is None:
        return
    count = air_contacts.contacts_in_air(scene)
    if count > 0:
        box = layout.box()
        draw_sentence(
            box,
            iface_("Contacts through air: {}. Convex hulls touch where surfaces are apart").format(
                count
            ),
            "INFO",
        )
        box.operator(
            "haptic.use_real_surface", text="Use Real Surface of All", icon="MESH_DATA"
        ).all = True


def next_step(scene: Scene, is_playing: bool) -> Hint | None:
    """The next step towards a vibration that is felt, or the active sources while the timeline
    plays; None if the summary says it."""
    if not scene.haptics.tracing:
        return Hint(iface_("Tracing is switched off"), (("haptic.toggle_tracing", "HIDE_OFF"),))
    traced = sessions.shown(scene)
    if traced is None and sessions.is_behind(scene):
        return None
    if traced is None or not traced.result.objects:
        if sessions.shown_problems(scene):
            return Hint(iface_("Mend the problem below"))
        if traced is None and roles.is_any_tagged(scene):
            return Hint(iface_("Nothing traced yet"), (("haptic.trace_frame", "FILE_REFRESH"),))
        return Hint(
            iface_("Select objects that touch"), (("haptic.make_objects", "OUTLINER_OB_META"),)
        )
    if not _has_sources(scene, traced):
        return Hint(
            iface_("Select what vibrates"), (("haptic.add_source", "OUTLINER_OB_FORCE_FIELD"),)
        )
    if not traced.result.listeners:
        listeners = (
            ("haptic.add_listener", "OUTLINER_OB_LIGHTPROBE"),
            ("haptic.add_default_listeners", "OUTLINER_OB_ARMATURE"),
        )
        return Hint(iface_("Select what feels: an object, or a body"), listeners)
    if is_playing:
        return Hint(_playing(traced.result.sources))
    if traced.result.sources and not traced.result.amplitudes.any():
        return None  # the summary shows the reason and the remedy
    return Hint(iface_("Press play"), (("screen.animation_play", "PLAY"),))


def _has_sources(scene: Scene, traced: sessions.Traced) -> bool:
    """True if there is a source, or if bodies with a mass move, whose impacts, sliding or rolling
    are sources."""
    if traced.result.sources or traced.reading is None or traced.reading.sources:
        return True
    excites = scene.haptics.impacts or len(scene.haptics.textures.items) > 0
    return excites and any(body.mass and body.motion != "static" for body in traced.reading.bodies)


def _playing(sources: Sequence[Source]) -> str:
    """The names of the active sources."""
    sounding = [source_title(source, 0.5) for source in sources if source.amplitude > 0]
    if not sounding:
        return iface_("Playing: nothing sounds at this moment")
    more = iface_("and {} more").format(len(sounding) - 1) if len(sounding) > 1 else ""
    return iface_("Playing: {}").format(" ".join((sounding[0], more)).strip())
