"""What properties repeat of the core, so that registering them does not load it, is what the core has."""

import bpy
from haptic_tracing.addon.properties import function
from haptic_tracing.core.devices.profiles import EARLIEST
from haptic_tracing.core.modalities import MODALITIES
from haptic_tracing.core.scene.functions import FUNCTIONS


def test_objects_offer_the_functions_of_vibration_in_the_cores_order():
    offered = [item.identifier for item in _haptics().properties["function"].enum_items]
    assert offered == list(FUNCTIONS)


def test_every_function_of_a_modality_has_a_title_and_its_parameters_are_properties():
    for modality in MODALITIES.values():
        for name in modality.functions:
            assert function.FUNCTIONS[name]
    for name, parameters in function.PARAMETERS.items():
        assert set(parameters) <= set(FUNCTIONS[name].__dataclass_fields__)
        assert all(own in _haptics().properties for own in parameters.values())


def test_a_device_is_brought_forward_by_what_the_core_allows():
    offset = bpy.types.HapticDeviceProperties.bl_rna.properties["offset"]
    assert offset.hard_min == 1000 * EARLIEST


def _haptics():
    return bpy.types.HapticObjectProperties.bl_rna
