"""Properties of haptic objects, and the property groups of all roles of an object."""

from __future__ import annotations

from bpy.props import PointerProperty
from bpy.types import Object, PropertyGroup

from ...core.scene.functions import Physical, Spectrum
from ...core.scene.values import HapticObject
from . import bake, live_output, materials, modalities
from .callbacks import Stored, changed, updating
from .declared import holding
from .function import VIBRATION_FUNCTIONS, FunctionParameters, function_property
from .kinds import switch
from .listener import HapticListenerProperties
from .source import HapticSourceProperties


@updating()
@holding(Physical, thickness="plate_thickness")
@holding(Spectrum, "wave_speed")
@holding(HapticObject)
class HapticObjectProperties(Stored, FunctionParameters, PropertyGroup):
    """A haptic object, which transmits signals."""

    enabled: switch("Haptic Object", "Vibration passes through this object")
    function: function_property(VIBRATION_FUNCTIONS, "haptic_tracing")
    source: PointerProperty(type=HapticSourceProperties)
    listener: PointerProperty(type=HapticListenerProperties)
    material: PointerProperty(type=materials.HapticObjectMaterial)
    modalities: PointerProperty(type=modalities.HapticObjectModalities)
    body: PointerProperty(
        type=Object, name="Body", description="The haptic object through which the listeners on this armature feel", update=changed
    )
    felt: PointerProperty(type=bake.HapticFeltProperties)
    live_output: PointerProperty(type=live_output.HapticActuatorProperties)
