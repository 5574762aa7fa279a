"""Properties of haptic objects, and the property groups of all roles of an object."""

from __future__ import annotations

from bpy.props import PointerProperty
from bpy.types import Object, PropertyGroup

from . import bake, live_output, materials, modalities
from .callbacks import Imported, changed, drop, updating
from .function import PARAMETERS, VIBRATION_FUNCTIONS, FunctionParameters, PhysicalParameters, function_property
from .kinds import switch
from .listener import HapticListenerProperties
from .source import HapticSourceProperties

_OF_THE_FUNCTION = {
    "function",
    "wave_speed",
    "use_bands",
    "band_decays",
    *(own for parameters in PARAMETERS.values() for own in parameters.values()),
}
"""Properties that define an object's modulation function."""


@updating()
class HapticObjectProperties(Imported, materials.Coefficients, FunctionParameters, PhysicalParameters, PropertyGroup):
    """A haptic object, which transmits signals."""

    enabled: switch("Haptic Object", "Vibration passes through this object")
    function: function_property(VIBRATION_FUNCTIONS, "haptic_tracing")
    medium: switch("Medium", "A volume such as air or water: it touches everything that it overlaps", translation_context="Haptics")
    source: PointerProperty(type=HapticSourceProperties)
    listener: PointerProperty(type=HapticListenerProperties)
    material: PointerProperty(type=materials.HapticObjectMaterial)
    modalities: PointerProperty(type=modalities.HapticObjectModalities)
    body: PointerProperty(
        type=Object, name="Body", description="The haptic object through which the listeners on this armature feel", update=changed
    )
    felt: PointerProperty(type=bake.HapticFeltProperties)
    live_output: PointerProperty(type=live_output.HapticActuatorProperties)

    def drop_imported(self, name: str) -> None:
        """Drop what was imported for the property ``name``: the function if the property belongs to it, otherwise its number."""
        if name in _OF_THE_FUNCTION:
            drop(self, "function")
        else:
            drop(self, "numbers", name)
