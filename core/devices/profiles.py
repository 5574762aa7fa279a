"""Device profiles: positions, capabilities and limits of a device's actuators.

The guard process loads this and not the reader of `profile_files`: it has to be there soon.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import Literal

from ..frozen import frozen
from ..perception import BEST_FREQUENCY, FullScale, threshold_level
from .families.family import AnyFamily, RumbleFamily
from .report import Transport

Kind = Literal["VCM", "LRA", "ERM", "PCM"]

EARLIEST = -0.050
"""Least delay in seconds, limited by the duration of a frame's block."""


@frozen
class Calibration:
    """Mapping from the signal's amplitude to the device's: ``floor + (1 - floor) (gain
    a)^exponent``, 0 staying 0.

    gain: 0 or more. floor: least amplitude at which the actuator moves, in [0, 1). exponent: above
    0; below 1 lifts weak signals.
    """

    gain: float = 1.0
    floor: float = 0.0
    exponent: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.gain <= 10.0:
            raise ValueError(f"gain {self.gain} is not in [0, 10]")
        if not 0.0 <= self.floor < 1.0:
            raise ValueError(f"floor {self.floor} is not in [0, 1)")
        if not 0.1 <= self.exponent <= 10.0:
            raise ValueError(f"exponent {self.exponent} is not in [0.1, 10]")


@frozen
class Adjustment:
    """The user's adjustment of one device, in addition to its profile.

    calibrations: by actuator, in place of the profile's. ceiling: factor in [0, 1] on every safe
    maximum. delay: seconds from -0.05 to 1 by which touch is delayed; below 0 it is advanced, as
    far as its samples are not yet due.
    """

    calibrations: Mapping[str, Calibration] = field(default_factory=dict)
    ceiling: float = 1.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.ceiling <= 1.0:
            raise ValueError(f"ceiling {self.ceiling} is not in [0, 1]")
        if not EARLIEST <= self.delay <= 1.0:
            raise ValueError(f"delay {self.delay} s is not in [{EARLIEST}, 1]")


def check_adjustment(adjustment: Adjustment, actuators: Iterable[Actuator]) -> None:
    """Raise ValueError for a calibration of an actuator that is not one of these."""
    unknown = set(adjustment.calibrations) - {actuator.name for actuator in actuators}
    if unknown:
        raise ValueError(f"calibrations names an unknown actuator: {sorted(unknown)[0]!r}")


@frozen
class DriveChannel:
    """One value that the device is commanded by. takes: its range of the signal's frequencies
    [Hz]."""

    name: str
    takes: tuple[float, float]


@frozen
class Actuator:
    """

    body_parts: those at which it is felt. band: its range of frequencies [Hz]; resonances: its
    resonance frequencies, if known. full_scale, its unit and source: as those of a
    listener, if known. latency: seconds from command to touch.
    safe_maximum: amplitude in (0, 1] never exceeded. position: coordinates from the wearer's left
    and from the top, in any unit, among the actuators of its body part; None: it always plays at
    full amplitude.
    """

    name: str
    body_parts: tuple[str, ...]
    kind: Kind
    band: tuple[float, float]
    latency: float
    safe_maximum: float
    channels: tuple[DriveChannel, ...]
    calibration: Calibration
    resonances: tuple[float, ...] = ()
    full_scale: tuple[tuple[float, float], ...] = ()
    full_scale_unit: str = "m/s^2"
    full_scale_source: str = ""
    position: tuple[float, float] | None = None

    @property
    def device(self) -> FullScale | None:
        """The calibration; None if it is not known."""
        is_force = self.full_scale_unit == "N"
        return FullScale(self.full_scale, is_force) if self.full_scale else None


@frozen
class Profile:
    """A device as the user sees it.

    minimum_interval: seconds between commands if longer than the family's, else None. slew: largest
    rise of amplitude per second. sustained_maximum, sustained_seconds: the running mean square of
    the drive over that time stays below the maximum's square.
    """

    name: str
    title: str
    family: AnyFamily
    experimental: bool
    minimum_interval: float | None
    slew: float
    sustained_maximum: float
    sustained_seconds: float
    actuators: tuple[Actuator, ...]

    def interval(self, transport: Transport) -> float:
        """Seconds between two commands on this transport."""
        return max(self.minimum_interval or 0.0, self.family.minimum_interval[transport])

    @property
    def latency(self) -> float:
        """Seconds from command to touch of the slowest actuator."""
        return max(actuator.latency for actuator in self.actuators)

    @property
    def best_frequency(self) -> float:
        """The frequency in Hz at which it is felt most: of its actuators' resonances, or of their
        bands without known resonances, the one with the lowest threshold of feeling."""
        known = [hertz for actuator in self.actuators for hertz in actuator.resonances]
        inside = [
            min(max(BEST_FREQUENCY, actuator.band[0]), actuator.band[1])
            for actuator in self.actuators
        ]
        return min(known or inside, key=lambda hertz: float(threshold_level(hertz)))

    @property
    def plays_frequency(self) -> bool:
        """Whether the device reproduces frequencies, not only amplitudes."""
        return not isinstance(self.family, RumbleFamily) or self.family.has_tones
