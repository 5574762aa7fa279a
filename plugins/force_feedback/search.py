"""Search for gamepads that the kernel drives. The guard process does not load this."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from ...core.devices.connection import Connected, missing_permission
from ...core.devices.families.family import Interface
from ...core.devices.guard import DeviceOutput
from ...core.devices.inventory import BUS, Found
from ...core.devices.profiles import Actuator, Calibration, DriveChannel, Profile
from .kernel import FORCE_FEEDBACK, ForceFeedbackModule, event_nodes


def _profile(node: Interface) -> Profile:
    """The profile of such a gamepad: a strong, slow motor and a weak, fast one, which shake the
    whole pad."""
    channels = DriveChannel("left", (10.0, 100.0)), DriveChannel("right", (100.0, 1000.0))
    actuator = Actuator(
        "both motors",
        ("hand.L", "hand.R"),
        "ERM",
        (30.0, 250.0),
        0.06,
        1.0,
        channels,
        Calibration(),
    )
    return Profile(
        "force-feedback",
        node.title or FORCE_FEEDBACK.title,
        FORCE_FEEDBACK,
        False,
        None,
        50.0,
        0.7,
        10.0,
        (actuator,),
    )


def devices(gamepads: Sequence[Connected]) -> list[Found]:
    """The event devices without those of ``gamepads``, which are driven as HID devices."""
    return [
        _found(node)
        for node in event_nodes()
        if missing_permission(node) is None
        and not any(_is_same(node, device.first) for device in gamepads)
    ]


def _is_same(node: Interface, pad: Interface) -> bool:
    """Whether an event device and a HID interface belong to the same pad by their serial
    numbers."""
    alike = (node.vendor, node.product) == (pad.vendor, pad.product)
    return alike and (
        not node.serial or not pad.serial or node.serial.lower() == pad.serial.lower()
    )


def _found(node: Interface) -> Found:
    profile = _profile(node)
    module = ForceFeedbackModule(node)
    key = " ".join(filter(None, ("force-feedback", node.title, node.serial)))
    return Found(
        key,
        profile.title,
        f"{BUS[node.transport]}, kernel",
        profile,
        partial(DeviceOutput, profile, hid=module),
    )
