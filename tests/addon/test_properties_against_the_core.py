"""What properties repeat of the core, so that registering them does not load it, is what the core
has."""

from haptic_tracing.addon.properties.live_output import HapticDeviceProperties
from haptic_tracing.addon.properties.object import HapticObjectProperties
from haptic_tracing.core.declaration import declared
from haptic_tracing.core.devices.profiles import EARLIEST
from haptic_tracing.core.scene.functions import FUNCTIONS, TRANSMISSIONS


def test_objects_offer_the_functions_of_vibration_in_the_cores_order():
    offered = [
        item.identifier for item in HapticObjectProperties.bl_rna.properties["function"].enum_items
    ]
    assert offered == list(FUNCTIONS)


def test_every_function_has_a_title_and_its_parameters_are_properties():
    for function in TRANSMISSIONS.values():
        assert function.label and function.about
    for function in FUNCTIONS.values():
        held = HapticObjectProperties.held.get(function, {})
        assert held.keys() == declared(function).keys()
        assert all(name in HapticObjectProperties.bl_rna.properties for name in held.values())


def test_a_device_is_brought_forward_by_what_the_core_allows():
    offset = HapticDeviceProperties.bl_rna.properties["offset"]
    assert offset.hard_min == 1000 * EARLIEST
