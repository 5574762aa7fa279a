"""Operators: find, connect and disconnect devices, choose actuators, preview, panic."""

from __future__ import annotations

from typing import Any

from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Event, Operator

from ...core.declaration import Curve
from ...core.devices import full_scale
from ..blender.extension import profile_folders
from ..blender.polling import UNDO, Action, OnActive, Refused, is_editable
from ..blender.words import report_text
from ..live_output import handlers, outputs, player, preview, refresh
from ..properties import actuators
from ..properties.kinds import text
from ..properties.preferences import preferences
from ..properties.sound import device_profiles

# A guard that does not answer is replaced within half a second, and the new one has silenced the
# devices after another second.
_PANIC_SECONDS = 2.0
_AUTOMATIC, _NONE = "AUTOMATIC", "NONE"
_items: list[tuple[str, str, str, str, int]] = []  # Blender keeps no copy of dynamic items


class HAPTIC_OT_find_devices(Action):
    """Look for haptic devices that are connected to this computer"""

    bl_label = "Find Devices"

    def apply(self, context: Context) -> None:
        settings = context.scene.haptics.live_output
        outputs.find(profile_folders(), settings.sound_cards, preferences().haptic_players)
        refresh.start()


class HAPTIC_OT_connect_device(Action):
    """Let listeners be felt through this device while the timeline plays; or silence and disconnect it if it is connected"""

    bl_label = "Connect"
    bl_options = {"INTERNAL"}

    device: text("Device", "Which one; empty for the default device of the preferences")

    def apply(self, context: Context) -> None:
        key = self.device or outputs.preferred(preferences().default_device)
        if key in outputs.running():
            outputs.disconnect(key)
            return
        found = outputs.found(key)
        if found is None:
            raise Refused("{} is not connected: press Find Devices", key or report_text("A device"))
        devices = context.scene.haptics.live_output.devices
        settings = devices.get(key)
        if settings is None:
            settings = devices.add()
            settings.name = key
        outputs.connect(key, outputs.adjustment_of(settings, found.device))
        refresh.start()


class HAPTIC_OT_copy_udev_rule(Action):
    """Copy the udev rule that permits the use of this device; the panel says where to put it"""

    bl_label = "Copy udev Rule"
    bl_options = {"INTERNAL"}

    device: StringProperty()

    def apply(self, context: Context) -> None:
        found = outputs.found(self.device)
        if found is None or not found.rule:
            raise Refused("This device needs no rule")
        context.window_manager.clipboard = found.rule
        self.tell("Copied")


def _choices(self: Operator, context: Context | None) -> list[tuple[str, str, str, str, int]]:
    _items[:] = [
        (_AUTOMATIC, "Automatic", "The actuators at its body part", "AUTO", 0),
        (_NONE, "None", "It is not felt", "CANCEL", 1),
    ]
    for key, output in outputs.running().items():
        for actuator in output.profile.actuators:
            parts = ", ".join(actuator.body_parts) or "anywhere"
            identifier = f"{key}/{actuator.name}"
            _items.append(
                (
                    identifier,
                    f"{output.profile.title}: {actuator.name}",
                    f"Felt at {parts}",
                    "NONE",
                    len(_items),
                )
            )
    return _items


class HAPTIC_OT_choose_actuator(Action):
    """Actuator of this listener; choose several one after the other"""

    bl_label = "Actuator"
    bl_options = {*UNDO, "INTERNAL"}

    listener: StringProperty()
    place: EnumProperty(items=_choices)

    def apply(self, context: Context) -> None:
        obj = context.scene.objects.get(self.listener)
        if obj is None or not is_editable(obj):
            raise Refused(
                "'{}' can't be changed: it is linked from a library, or no listener any more",
                self.listener,
            )
        settings = obj.haptics.live_output
        if self.place in (_AUTOMATIC, _NONE):
            settings.actuators = (
                actuators.AUTOMATIC if self.place == _AUTOMATIC else actuators.MUTED
            )
        else:
            settings.actuators = actuators.toggled(settings.actuators, self.place)
            key, _, name = self.place.rpartition("/")
            output = outputs.running().get(key)
            title = "" if output is None else f"{output.profile.title}: {name}"
            if title in _calibrations() and not obj.haptics.listener.full_scale:
                _calibrate(obj.haptics.listener, title)


_OF_SOUND_CARDS = ("shaker", "vest")


def _calibrations() -> dict[str, tuple[Any, str, str]]:
    """What devices do at full scale, by device and actuator: points, unit and source."""
    typical = [full_scale.TYPICAL[kind] for kind in _OF_SOUND_CARDS]
    return {row.title: (row.points, "m/s^2", row.source) for row in typical} | {
        f"{profile.title}: {actuator.name}": full_scale.full_scale_of(actuator)
        for profile in device_profiles().values()
        for actuator in profile.actuators
    }


def _calibrate(listener: Any, name: str) -> None:
    """Give a listener what the device and actuator ``name`` do at full scale."""
    points, unit, source = _calibrations()[name]
    listener.full_scale = Curve.text(points)
    listener.full_scale_unit = unit
    listener.full_scale_source = f"{name.partition(':')[0]}: {source}"


def _calibrated_actuators(self: Operator, context: Context, typed: str) -> list[str]:
    return sorted(_calibrations())


class HAPTIC_OT_calibrate_listener(OnActive):
    """Copy what this listener's device does at full scale from the device's profile"""

    bl_label = "Calibrate by Profile"
    bl_options = UNDO
    bl_property = "actuator"

    actuator: text(
        "Actuator",
        "Device and actuator; what their profiles don't tell is typical of their kind",
        search=_calibrated_actuators,
    )

    def invoke(self, context: Context, event: Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def apply(self, context: Context) -> None:
        if self.actuator not in _calibrations():
            raise Refused(
                "No profile says what '{}' does at full scale: enter it, or measure it by "
                "'haptic-tracing devices calibrate'",
                self.actuator,
            )
        _calibrate(context.object.haptics.listener, self.actuator)


class HAPTIC_OT_toggle_preview(Action):
    """Play what the listeners feel as sound while the timeline plays, which Blender does by itself if no device is connected; or stay silent"""

    bl_label = "Hear It"

    def apply(self, context: Context) -> None:
        is_heard = preview.is_on() or handlers.may_hear()
        preferences().hear = not is_heard
        if is_heard:
            preview.switch_off()
            return
        try:
            preview.switch_on()
        except preview.AudioUnavailable as error:
            raise Refused("No preview: {}", error) from None
        preview.adjust(context.scene.haptics.live_output)


class HAPTIC_OT_panic(Action):
    """Silence and disconnect all devices at once, and switch the preview off"""

    bl_label = "Stop All Output"

    def apply(self, context: Context) -> None:
        player.rest()
        preview.switch_off()
        devices = outputs.stop_and_tell(_PANIC_SECONDS)
        silent = ", ".join(title for title, fault in devices if not fault)
        faults = "; ".join(f"{title} ({fault})" for title, fault in devices if fault)
        if faults:
            self.warn(
                "Unplug or switch off what still vibrates: {}. Off: {}", faults, silent or "-"
            )
        else:
            self.tell(
                " ".join(
                    filter(
                        None,
                        [report_text("All haptic output is off"), f"({silent})" if silent else ""],
                    )
                )
            )
