"""Settings of live output: per device, per listener, and for the preview. None of them activates a
device."""

from __future__ import annotations

from bpy.props import CollectionProperty
from bpy.types import Context, PropertyGroup

from ..changes.events import device_adjusted, preview_adjusted
from ..changes.revisions import mark_actuators
from .callbacks import updating
from .kinds import limited, share, switch, text


def _preview_changed(self: HapticLiveOutputProperties, context: Context) -> None:
    preview_adjusted(self)


def _actuators_chosen(self: PropertyGroup, context: Context) -> None:
    mark_actuators()


@updating(lambda device, context: device_adjusted(device))
class HapticDeviceProperties(PropertyGroup):
    """The adjustment of one device; its name is the device's key."""

    reasons = {
        "*": "calibration",
    }

    gain: limited(
        "Gain", "Makes everything on this device stronger or weaker", 1.0, (0.0, 4.0), soft_max=2.0
    )
    floor: limited(
        "Floor",
        "Least strength at which the actuator moves: the weakest signal starts there",
        0.0,
        (0.0, 0.9),
        subtype="FACTOR",
        translation_context="Haptics",
    )
    curve: limited(
        "Curve",
        "Exponent of the strength that the device plays; values below 1 raise weak signals",
        1.0,
        (0.1, 4.0),
        soft_min=0.3,
        soft_max=2.0,
    )
    ceiling: share(
        "Ceiling", "The device is never driven above this fraction of its safe maximum", 1.0
    )
    offset: limited(
        "Latency Offset (ms)",
        "Delays touch, in milliseconds, if the display is slow; negative values advance it",
        0.0,
        (-50.0, 1000.0),
        soft_max=200.0,
        precision=0,
    )


class HapticLiveOutputProperties(PropertyGroup):
    """The live output of a scene."""

    reasons = {
        "*": "device",
    }

    devices: CollectionProperty(type=HapticDeviceProperties)
    sound_cards: switch(
        "Sound Cards Too",
        "Look for sound cards as well: shakers, cushions and headsets that are felt, and a "
        "DualSense's actuators over USB",
    )
    preview_volume: share(
        "Volume",
        "How loud listeners are heard",
        0.5,
        update=_preview_changed,
        translation_context="Haptics",
    )


class HapticActuatorProperties(PropertyGroup):
    """The choice of actuators of a listener."""

    reasons = {
        "*": "device",
    }

    actuators: text(
        "Actuators",
        "Empty: those at its body part; -: none; otherwise device/actuator or "
        "device/actuator*gain, separated by semicolons",
        update=_actuators_chosen,
    )
