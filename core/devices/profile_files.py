"""Device profiles as JSON files, one per device: those that are built in and the user's own."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from .. import plugins
from ..declaration import declared
from ..formats.io.error import FormatError, errors_in
from ..formats.io.schema import validate
from ..formats.io.strict_json import parse_json, read_bytes
from ..forms import Form, JsonObject
from ..scene.body import BODY_PART
from ..scene.references import Place, PlacedError, named
from ..scene.values import Listener
from .families.family import AnyFamily, RumbleFamily
from .families.registry import families
from .profiles import Actuator, Calibration, DriveChannel, Profile

MAX_BYTES = 2**20
"""Largest file of a profile."""
BUILT_IN = Path(__file__).parent / "profiles"


def parse_profile(data: bytes, file: str | Path) -> Profile:
    """A profile from its JSON text, read from ``file``. Raises FormatError."""
    document = parse_json(data, file)
    validate(document, "device", file)
    with errors_in(file):
        return _profile(document)


def _profile(document: Form) -> Profile:
    known = families()
    family = known.get(document["family"])
    if family is None:
        raise PlacedError(
            ("family",), f"{document['family']!r} is unknown: use one of {', '.join(known)}"
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


def _actuator(place: Place, data: Form) -> Actuator:
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
    values: JsonObject = {
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
            place = "actuators", i, "channels", k, "name"
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


def load_profiles(folders: Iterable[Path] = ()) -> tuple[dict[str, Profile], tuple[str, ...]]:
    """Profiles by name from ``*.json`` files: those that are built in, those in the folder
    `profiles` of each plug-in, and those in the folders of the user; and one line for each invalid
    file.

    A later folder's profile replaces an earlier one of the same name, so a user's file can override
    a built-in one.
    """
    profiles: dict[str, Profile] = {}
    problems: list[str] = []
    offered = (Path(item.__file__ or "").parent for item in plugins.plugins().values())
    for folder in (BUILT_IN, *(folder / "profiles" for folder in offered), *folders):
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


def profile(name: str, folders: Iterable[Path] = ()) -> Profile:
    """The profile called ``name``. Raises ValueError that lists the known names."""
    return named(name, load_profiles(folders)[0], "device")
