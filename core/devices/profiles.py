"""Device profiles: positions, capabilities and limits of a device's actuators, one JSON file per
device."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from ..formats.io.error import FormatError, errors_in
from ..formats.io.schema import validate
from ..formats.io.strict_json import parse_json, read_bytes
from ..perception import BEST_FREQUENCY, FullScale, threshold_level
from ..scene.body import BODY_PART
from ..scene.declaration import declared
from ..scene.references import Place, PlacedError, named
from ..scene.values import Listener
from .families.family import AnyFamily, RumbleFamily
from .families.registry import FAMILIES
from .report import Transport

Kind = Literal["VCM", "LRA", "ERM", "PCM"]

MAX_BYTES = 2**20
"""Largest file of a profile."""
BUILT_IN = Path(__file__).parent / "profiles"
EARLIEST = -0.050
"""Least delay in seconds, limited by the duration of a frame's block."""


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
class DriveChannel:
    """One value that the device is commanded by. takes: its range of the signal's frequencies
    [Hz]."""

    name: str
    takes: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Actuator:
    """

    body_parts: those at which it is felt. band: its range of frequencies [Hz]; resonances: its
    resonance frequencies, if known. full_scale, its unit and source: if known, as those of a
    listener. latency: seconds from command to touch. safe_maximum: amplitude in (0, 1] never
    exceeded. position: coordinates from the wearer's left and from the top, in any
    unit, among the actuators of its body part; None: it always plays at full amplitude.
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


@dataclass(frozen=True, slots=True)
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


def parse_profile(data: bytes, file: str | Path) -> Profile:
    """A profile from its JSON text, read from ``file``. Raises FormatError."""
    document = parse_json(data, file)
    validate(document, "device", file)
    with errors_in(file):
        return _profile(document)


def _profile(document: Mapping[str, Any]) -> Profile:
    family = FAMILIES.get(document["family"])
    if family is None:
        raise PlacedError(
            ("family",), f"{document['family']!r} is unknown: use one of {', '.join(FAMILIES)}"
        )
    interval = document.get("minimum_interval")
    if interval is not None and interval < min(family.minimum_interval.values()):
        fastest = min(family.minimum_interval.values())
        raise PlacedError(
            ("minimum_interval",), f"{interval} s is faster than the device allows ({fastest} s)"
        )
    actuators = tuple(
        _actuator(("actuators", i), data) for i, data in enumerate(document["actuators"])
    )
    _check_channels(family, actuators)
    return Profile(
        name=document["name"],
        title=document["title"],
        family=family,
        experimental=document.get("experimental", False),
        minimum_interval=interval,
        slew=float(document["slew"]),
        sustained_maximum=float(document["sustained"]["maximum"]),
        sustained_seconds=float(document["sustained"]["seconds"]),
        actuators=actuators,
    )


def _actuator(place: Place, data: Mapping[str, Any]) -> Actuator:
    for i, part in enumerate(data["body_parts"]):
        if part not in BODY_PART:
            raise PlacedError(
                (*place, "body_parts", i),
                f"body part {part!r} is unknown: use one of {', '.join(BODY_PART)}",
            )
    takes = [
        _band((*place, "channels", i, "takes"), channel["takes"])
        for i, channel in enumerate(data["channels"])
    ]
    channels = tuple(
        DriveChannel(channel["name"], band)
        for channel, band in zip(data["channels"], takes, strict=True)
    )
    calibration = Calibration(**data.get("calibration", {}))
    try:
        full_scale = declared(Listener)["full_scale"].checked(data.get("full_scale", ()))
    except ValueError as error:
        raise PlacedError((*place, "full_scale"), str(error)) from None
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in data.items()
    }
    return Actuator(
        **{
            **values,
            "band": _band((*place, "band"), data["band"]),
            "channels": channels,
            "calibration": calibration,
            "full_scale": full_scale,
        }
    )


def _band(place: Place, limits: list[float]) -> tuple[float, float]:
    low, high = map(float, limits)
    if not low < high:
        raise PlacedError(place, f"{low} Hz is not below {high} Hz")
    return low, high


def _check_channels(family: AnyFamily, actuators: tuple[Actuator, ...]) -> None:
    """Check that every channel exists and is used once, that names of actuators are unique, and
    that an actuator of a stream has one channel."""
    names: set[str] = set()
    used: set[str] = set()
    for i, actuator in enumerate(actuators):
        if actuator.name in names:
            raise PlacedError(("actuators", i, "name"), f"{actuator.name!r} is used twice")
        names.add(actuator.name)
        if not isinstance(family, RumbleFamily) and len(actuator.channels) > 1:
            raise PlacedError(
                ("actuators", i, "channels"),
                f"{family.name} takes samples, so an actuator has one channel",
            )
        for k, channel in enumerate(actuator.channels):
            place = ("actuators", i, "channels", k, "name")
            if channel.name not in family.channels:
                raise PlacedError(
                    place,
                    f"{family.name} has no channel {channel.name!r}: use one of "
                    f"{', '.join(family.channels)}",
                )
            if channel.name in used:
                raise PlacedError(place, f"channel {channel.name!r} is used twice")
            used.add(channel.name)


@lru_cache(maxsize=64)
def _parsed(data: bytes, file: Path) -> Profile:
    """`parse_profile`: files are read again at every search for devices, and seldom change."""
    return parse_profile(data, file)


def load_profiles(
    folders: Iterable[Path] = (BUILT_IN,),
) -> tuple[dict[str, Profile], tuple[str, ...]]:
    """Profiles by name from the ``*.json`` files of the folders, and one line for each invalid
    file.

    A later folder's profile replaces an earlier one of the same name, so a user's file can override
    a built-in one.
    """
    profiles: dict[str, Profile] = {}
    problems: list[str] = []
    for folder in folders:
        seen: set[str] = set()
        for file in sorted(folder.glob("*.json")):
            try:
                profile = _parsed(read_bytes(file, MAX_BYTES), file)
                if profile.name in seen:
                    raise FormatError(
                        file, "/name", f"{profile.name!r} is used by another file of this folder"
                    )
            except OSError as error:
                problems.append(f"{file}: {error.strerror}")
                continue
            except FormatError as error:
                problems.append(str(error))
                continue
            seen.add(profile.name)
            profiles[profile.name] = profile
    return profiles, tuple(problems)


def profile(name: str, folders: Iterable[Path] = (BUILT_IN,)) -> Profile:
    """The profile called ``name``. Raises ValueError that lists the known names."""
    return named(name, load_profiles(folders)[0], "device")
