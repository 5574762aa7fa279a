"""Properties of haptic objects, and the property groups of all roles of an object."""

from __future__ import annotations

from bpy.props import PointerProperty
from bpy.types import Context, Object, PropertyGroup

from ...core.scene.functions import Physical, Spectrum
from ...core.scene.values import HapticObject
from ..changes.events import made_haptic
from . import live_output, materials
from .callbacks import changed, object_changed, updating
from .declared import holding
from .function import VIBRATION_FUNCTIONS, FunctionParameters, function_property
from .kinds import choice, reference, switch
from .listener import HapticListenerProperties
from .source import HapticSourceProperties


def _enabled_edited(self: HapticObjectProperties, context: Context) -> None:
    """Give an object that is haptic for the first time what *Make Haptic* gives."""
    if self.enabled and not self.is_property_set("function"):
        made_haptic(self.id_data)
    changed(self, context)


@updating(object_changed)
@holding(Physical, more={"length": {"options": {"HIDDEN"}}}, thickness="plate_thickness")
@holding(Spectrum, "wave_speed")
@holding(HapticObject)
class HapticObjectProperties(FunctionParameters, PropertyGroup):
    """A haptic object, which transmits signals."""

    reasons = {"surface": "rooms that are shells, and rubble that is hulls"}

    enabled: switch("Haptic Object", "Vibration passes through this object", update=_enabled_edited)
    function: function_property(VIBRATION_FUNCTIONS, "physical")
    surface: choice(
        "Surface",
        "Which surface of the object touches others; a rigid body touches by its own collision "
        "shape",
        (
            (
                "SEEN",
                "As Seen",
                "The surface: a solid if it is closed, otherwise a shell; where an armature moves "
                "it, a convex part for each bone",
            ),
            (
                "SOLID",
                "Solid",
                "A closed surface: what crosses it touches, and what is inside down to 5 cm, a "
                "fingertip in a sofa",
            ),
            (
                "SHELL",
                "Shell",
                "A thin skin: what is inside, such as a lamp in a room, touches only where it is "
                "close to it",
            ),
            (
                "CONVEX_HULL",
                "Convex Hull",
                "A skin around all vertices, which closes holes and hollows",
            ),
        ),
    )
    source: PointerProperty(type=HapticSourceProperties)
    listener: PointerProperty(type=HapticListenerProperties)
    material: PointerProperty(type=materials.HapticObjectMaterial)
    body: reference(
        Object,
        "Body",
        "The haptic object through which the listeners on this armature feel",
        update=changed,
    )
    live_output: PointerProperty(type=live_output.HapticActuatorProperties)
