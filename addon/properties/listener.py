"""Properties of haptic listeners."""

from __future__ import annotations

from bpy.types import Context, PropertyGroup

from ...core.scene.values import Listener
from ..blender.units import metres_per_unit
from .callbacks import changed, object_changed, updating
from .declared import holding
from .kinds import switch


def _enabled_edited(self: HapticListenerProperties, context: Context) -> None:
    """Give a new listener a limiter, except in a scene as in the paper."""
    if (
        self.enabled
        and (context.scene is None or context.scene.haptics.strategy != "as_in_the_paper")
        and not self.is_property_set("limiter")
    ):
        self.limiter = True
    changed(self, context)


def _radius_edited(self: HapticListenerProperties, context: Context) -> None:
    """Set the size of an empty that is displayed as a sphere to the listener's radius."""
    empty = self.id_data
    if self.radius > 0 and empty.type == "EMPTY" and empty.empty_display_type == "SPHERE":
        empty.empty_display_size = self.radius / metres_per_unit(context.scene)
    object_changed(self, context)


@updating(object_changed)
@holding(Listener, more={"radius": {"update": _radius_edited}})
class HapticListenerProperties(PropertyGroup):
    """A haptic listener, which receives signals at a point of the body."""

    reasons = {
        "muted": "mute",
        "solo": "mute",
        "s_max": "safety",
        "limiter": "safety",
        "full_scale*": "calibration",
        "mixing*": "how a device with few actuators adds up sources",
    }

    enabled: switch(
        "Haptic Listener", "Signals are received at this object's origin", update=_enabled_edited
    )
    muted: switch("Mute", "Keep the listener but let it feel nothing", options=set())
    solo: switch(
        "Solo", "Let only listeners that are solo feel something", options=set(), update=changed
    )

    @property
    def part(self) -> str:
        """The body part that it stands for, "" for none."""
        return "" if self.body_part == "NONE" else self.body_part
