"""Panel "Devices": devices and their state, the actuators of listeners, and losses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.types import AddonPreferences, Context, Scene, UILayout

from ...core.devices import connection, mapping
from ...core.render import limiter
from ..blender.time import frame_seconds
from ..blender.words import show, show_pair, ui_text
from ..live_output import handlers, outputs, player
from ..properties.preferences import preferences
from ..session import sessions
from ..translations.sentences import sentence
from .drawing import ScenePanel, draw_each
from .texts import draw_sentence

if TYPE_CHECKING:
    from ...core.devices.status import Status

EARLIEST = -0.015
"""Seconds by which touch may lead the picture unnoticed (Di Luca and Mahnan, 2019)."""
_BLOCKED = 0.25


class HAPTIC_PT_live_output(ScenePanel):
    bl_label = "Devices"

    def draw(self, context: Context) -> None:
        layout = self.layout
        draw_search(layout)
        column = layout.column(align=True)
        column.prop(context.scene.haptics.live_output, "sound_cards")
        if isinstance(preferences(), AddonPreferences):
            column.prop(preferences(), "haptic_players")
        _draw_devices(layout, context.scene)
        _draw_actuators(layout, context.scene)


def draw_search(layout: UILayout) -> None:
    """Draw the buttons that find devices, and that stop all output."""
    row = layout.row(align=True)
    words = "Looking..." if outputs.is_finding() else "Find Devices"
    row.operator("haptic.find_devices", text=words, icon="VIEWZOOM")
    if outputs.running():
        row.operator("haptic.panic", text="", icon="CANCEL")


def _draw_actuators(layout: UILayout, scene: Scene) -> None:
    """Draw the actuators of each listener, and what it loses."""
    traced = sessions.shown(scene)
    if traced is None or not traced.result.listeners:
        layout.label(text="No listener was traced yet", icon="INFO")
        return
    choices = handlers.choices(traced.result)
    mapped = player.mapping_of(traced.result, choices)
    layout.label(text="Actuators")
    for row_number, listener in enumerate(traced.result.listeners):
        column = layout.column(align=True)
        row = column.split(factor=0.45)
        show(row, listener.name)
        text = ", ".join(_actuators_of(mapped, row_number)) or ui_text("none")
        text = text if listener.name in choices else ui_text("Auto: {}", text)
        row.operator_menu_enum(
            "haptic.choose_actuator", "place", text=text, translate=False
        ).listener = listener.name
        for loss in mapped.losses:
            if loss.listener == listener.name and outputs.running():
                draw_sentence(column, sentence(loss.message))


def _actuators_of(mapped: mapping.ListenerMapping, row: int) -> list[str]:
    """The actuators of a listener, with their device if there are several."""
    running = outputs.running()
    return [
        f"{running[key].profile.title}: {actuator.name}" if len(running) > 1 else actuator.name
        for key, weights in mapped.weights.items()
        for actuator, weight in zip(running[key].profile.actuators, weights[:, row], strict=True)
        if weight
    ]


def _draw_devices(layout: UILayout, scene: Scene) -> None:
    inventory = outputs.inventory()
    for key, output in outputs.running().items():
        found = outputs.found(key)
        box = _draw_title(layout, output.profile.title, found.kind if found else "")
        box.operator("haptic.connect_device", text="Disconnect", icon="UNLINKED").device = key
        _draw_status(box, output.status, frame_seconds(scene), limiter_seconds(scene))
        settings = scene.haptics.live_output.devices.get(key)
        if settings is not None:
            column = box.column(align=True)
            column.use_property_split = True
            column.use_property_decorate = False
            draw_each(column, settings, "gain", "floor", "curve", "ceiling", "offset")
    if inventory is None:
        return
    for found in inventory.devices:
        if found.key in outputs.running():
            continue
        box = _draw_title(layout, found.title, found.kind)
        if found.rule:
            draw_sentence(box, ui_text("You may not use it yet. Copy the rule into"), "ERROR")
            box.label(text=connection.UDEV_FILE)
            draw_sentence(box, ui_text("and plug the device in again"))
            box.operator("haptic.copy_udev_rule", icon="COPYDOWN").device = found.key
        elif found.permission:
            draw_sentence(box, found.permission, "ERROR")
        box.operator("haptic.connect_device", icon="LINKED").device = found.key
    for name in inventory.strangers:
        layout.label(text=f"{name} is not supported", icon="QUESTION")
    for problem in inventory.problems:
        draw_sentence(layout, problem, "ERROR")
    if not inventory.devices and not inventory.strangers:
        layout.label(text="No haptic device is connected", icon="INFO")


def _draw_title(layout: UILayout, title: str, kind: str) -> UILayout:
    box = layout.box()
    box.label(text=f"{title} ({kind})" if kind else title, icon="MOUSE_MOVE")
    return box


def _draw_status(
    layout: UILayout, status: Status, frame_seconds: float, rendering_seconds: float = 0.0
) -> None:
    column = layout.column(align=True)
    state = {
        "searching": "Looking for it",
        "open": "Connected",
        "stopped": "Stopped",
        "failed": "Failed",
    }[status.state]
    column.label(text=state, icon="CHECKMARK" if status.state == "open" else "ERROR")
    if status.message:
        draw_sentence(column, status.message)
    if status.state == "failed":
        draw_sentence(column, ui_text("Disconnect it and connect it again"))
    if status.writing_for > _BLOCKED:
        draw_sentence(column, ui_text("A write has been blocked for {:.1f} s", status.writing_for))
    show_pair(column, ui_text("Reports written"), f"{status.written}")
    show_pair(column, ui_text("Failed, lost"), f"{status.failed_writes}, {status.losses}")
    lag = lag_of_picture(status, frame_seconds, rendering_seconds)
    if lag is not None:
        late = lag > mapping.LATEST or lag < EARLIEST
        show_pair(
            column,
            ui_text("Touch follows by"),
            f"{1000 * lag:.0f} ms" + (" (noticed)" if late else ""),
        )
        column.label(text="-15 to 50 ms go unnoticed", icon="ERROR" if late else "BLANK1")


def lag_of_picture(
    status: Status, frame_seconds: float, rendering_seconds: float = 0.0
) -> float | None:
    """Seconds by which touch follows the picture. A picture is shown for a whole frame, of which
    the middle counts: samples of the frame before it are felt while it is shown, half a frame late
    on average. ``rendering_seconds``: by which samples lag the frame."""
    return None if status.lag is None else status.lag + frame_seconds / 2 + rendering_seconds


def limiter_seconds(scene: Scene) -> float:
    """Delay of all listeners by a limiter [s]; 0 if none has one."""
    traced = sessions.shown(scene)
    return (
        limiter.LOOK_AHEAD
        if traced is not None and any(listener.limiter for listener in traced.result.listeners)
        else 0.0
    )
