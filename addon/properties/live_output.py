"""What a designer sets for live output: per device, per listener, and for the preview. Nothing of it switches a device on."""

from __future__ import annotations

from bpy.props import BoolProperty, CollectionProperty, FloatProperty, StringProperty
from bpy.types import Context, PropertyGroup

from ..changes.events import device_adjusted, preview_volume_changed
from ..changes.revisions import mark_actuators


def _device_changed(self: PropertyGroup, context: Context) -> None:
    device_adjusted(self)


def _actuators_chosen(self: PropertyGroup, context: Context) -> None:
    mark_actuators()


def _volume_changed(self: HapticLiveOutputProperties, context: Context) -> None:
    preview_volume_changed(self.preview_volume)


class HapticDeviceProperties(PropertyGroup):
    """How one device feels; its name is the device's key."""

    gain: FloatProperty(
        name="Gain",
        description="Makes everything on this device stronger or weaker",
        default=1.0,
        min=0.0,
        max=4.0,
        soft_max=2.0,
        update=_device_changed,
    )
    floor: FloatProperty(
        name="Floor",
        description="Least strength at which the actuator moves: the weakest signal starts there",
        default=0.0,
        min=0.0,
        max=0.9,
        subtype="FACTOR",
        update=_device_changed,
    )
    curve: FloatProperty(
        name="Curve",
        description="Exponent of strength; below 1 lifts weak signals",
        default=1.0,
        min=0.1,
        max=4.0,
        soft_min=0.3,
        soft_max=2.0,
        update=_device_changed,
    )
    ceiling: FloatProperty(
        name="Ceiling",
        description="The device is never driven harder than this part of what is safe for it",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_device_changed,
    )
    offset: FloatProperty(
        name="Latency Offset (ms)",
        description="Holds touch back, in milliseconds, where the picture is slow; below 0 brings it forward",
        default=0.0,
        min=-50.0,
        max=1000.0,
        soft_max=200.0,
        precision=0,
        update=_device_changed,
    )
    imported: StringProperty(name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"})


class HapticLiveOutputProperties(PropertyGroup):
    """The live output of a scene."""

    devices: CollectionProperty(type=HapticDeviceProperties)
    sound_cards: BoolProperty(
        name="Sound Cards Too",
        description="Look for sound cards as well: shakers, cushions and headsets that are felt, and a DualSense's actuators over USB",
        default=False,
    )
    preview_volume: FloatProperty(
        name="Volume", description="How loud listeners are heard", default=0.5, min=0.0, max=1.0, subtype="FACTOR", update=_volume_changed
    )


class HapticActuatorProperties(PropertyGroup):
    """What a listener is felt through."""

    actuators: StringProperty(
        name="Actuators",
        description="Empty for those at its body part, - for none, else device/actuator or device/actuator*gain, separated by semicolons",
        update=_actuators_chosen,
    )
