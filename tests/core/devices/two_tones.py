"""A pad whose two actuators play two tones each, below and above 225 Hz."""

from haptic_tracing.core.devices.families.family import RumbleFamily
from haptic_tracing.core.devices.profiles import Actuator, Calibration, DriveChannel, Profile
from haptic_tracing.core.devices.report import Report, Tones

RESTING = (160.0, 320.0, 160.0, 320.0)


def _rumble(left, right):
    return Tones((left, left, right, right), RESTING)


def _actuator(side, part):
    low, high = (
        DriveChannel(f"{side}.low", (10.0, 225.0)),
        DriveChannel(f"{side}.high", (225.0, 1000.0)),
    )
    return Actuator(
        f"{side} grip", (part,), "LRA", (41.0, 1252.0), 0.015, 1.0, (low, high), Calibration()
    )


TWO_TONES = Profile(
    name="two-tones",
    title="Pad of two tones",
    family=RumbleFamily(
        name="two-tones",
        title="Pad of two tones",
        ids=frozenset(),
        channels=("left.low", "left.high", "right.low", "right.high"),
        minimum_interval={"usb": 0.030},
        encode=lambda drive, transport, sequence: Report(b""),
        rumble=_rumble,
        has_tones=True,
    ),
    experimental=False,
    minimum_interval=None,
    slew=50.0,
    sustained_maximum=0.7,
    sustained_seconds=10.0,
    actuators=(_actuator("left", "hand.L"), _actuator("right", "hand.R")),
)
