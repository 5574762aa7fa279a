"""A designer's settings of a device as the core applies them."""

from __future__ import annotations

from ...core.devices.mapping import ActuatedDevice
from ...core.devices.profiles import Adjustment, Calibration
from ..properties.live_output import HapticDeviceProperties


def adjustment_of(settings: HapticDeviceProperties, device: ActuatedDevice) -> Adjustment:
    """The user's settings of a device, on top of its profile."""
    return Adjustment(
        calibrations={
            actuator.name: Calibration(
                gain=min(actuator.calibration.gain * settings.gain, 10.0),
                floor=max(actuator.calibration.floor, settings.floor),
                exponent=min(max(actuator.calibration.exponent * settings.curve, 0.1), 10.0),
            )
            for actuator in device.actuators
        },
        ceiling=settings.ceiling,
        delay=settings.offset / 1000,
    )
