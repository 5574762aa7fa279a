"""``haptic-tracing devices``: lists connected devices, plays a test sweep, calibrates listeners,
and prints encoded reports."""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

from ..core.declaration import Curve
from ..core.devices.connection import connected, hid_module, missing_permission
from ..core.devices.families.family import RumbleFamily
from ..core.devices.families.registry import family
from ..core.devices.full_scale import full_scale_of
from ..core.devices.guard import DeviceOutput
from ..core.devices.profile_files import load_profiles
from ..core.devices.profiles import Actuator, Profile
from ..core.devices.report import Report, Transport
from ..core.formats.io.strict_json import read_json
from ..core.formats.scene.scene_json import scene_of, valid_document, write_document
from ..core.forms import JsonObject
from ..core.scene.references import named
from ..core.signals.wav import read_wav
from . import answer
from .calibrating import measured_full_scale, sweep

_RATE = 8000
_FRAME = 0.02
_LOOK_FOR = 3.0


def run(args: argparse.Namespace) -> int:
    """List the devices, or run the requested action."""
    if args.action == "test":
        return run_test(args)
    if args.action == "calibrate":
        return run_calibrate(args)
    return run_encode(args) if args.action == "encode" else run_list(args)


def run_encode(args: argparse.Namespace) -> int:
    """Print one report as lower-case hexadecimal."""
    report = rumble_report(args.device, args.left, args.right, args.transport, args.sequence)
    print(report.data.hex())
    answer(args, {"report": report.data.hex()})
    return 0


def rumble_report(
    name: str, left: float, right: float, transport: Transport | None = None, sequence: int = 0
) -> Report:
    """The report that drives a device's classic pair of motors.

    left, right: amplitudes in [0, 1]; left is the low-frequency motor if the two differ.
    transport: None is the device's default. sequence: 0..15, for numbered reports.
    Raises ValueError with the reason.
    """
    chosen = family(name)
    if not isinstance(chosen, RumbleFamily):
        raise ValueError(f"device {name!r} takes samples, not levels")
    if transport is not None and transport not in chosen.transports:
        raise ValueError(
            f"transport {transport!r} does not exist for {name}: use "
            f"{' or '.join(chosen.transports)}"
        )
    if not 0 <= sequence <= 15:
        raise ValueError(f"sequence {sequence} is not in 0..15")
    return chosen.encode(chosen.rumble(left, right), transport or chosen.transports[0], sequence)


def run_list(args: argparse.Namespace) -> int:
    """Print a line for each connected device, then why any cannot be used."""
    profiles = _profiles(args)
    devices = connected(hid_module())
    if not devices:
        print("no haptic device is connected")
    problems: list[str] = []
    rows = []
    for device in devices:
        families = [family.name for family in device.families]
        names = [
            profile.name
            for family in families
            for profile in profiles.values()
            if profile.family.name == family
        ]
        first = device.first
        row = {
            "names": ", ".join(names) or "not supported",
            "title": first.title or "unnamed",
            "transport": first.transport,
            "ids": f"{first.vendor:04x}:{first.product:04x}",
            "serial": first.serial,
        }
        print("\t".join(row.values()).rstrip())
        rows.append({**row, "names": names})
        if families:
            problems += filter(None, map(missing_permission, device.interfaces))
    for problem in problems:
        print(problem)
    answer(args, {"devices": rows, "problems": problems})
    return 0


def run_test(args: argparse.Namespace) -> int:
    """Play a sweep and print the reports written."""
    profiles = _profiles(args)
    if args.name not in profiles:
        raise ValueError(f"device {args.name!r} is unknown: use one of {', '.join(profiles)}")
    if not 0.1 <= args.seconds <= 60.0:
        raise ValueError(f"seconds {args.seconds} is not in [0.1, 60]")
    if args.actuator is not None:
        _actuator(profiles[args.name], args.actuator)
    output = DeviceOutput(profiles[args.name], rate=_RATE, serial=args.serial)
    output.start()
    try:
        output.wait_until_open(_LOOK_FOR)
        _play_sweep(output, args.seconds, args.actuator)
    finally:
        output.stop()
    status = output.status
    if status.failed_writes or status.state == "failed":
        raise OSError(status.message)
    print(
        f"{args.name}: {status.written} reports written, the last is release; "
        f"{1000 * (status.delay or 0.0):.1f} ms from block to report"
    )
    answer(args, {"device": args.name, "reports": status.written, "delay": status.delay})
    return 0


def run_calibrate(args: argparse.Namespace) -> int:
    """Find what a device does at full scale, from a recording or its profile; print it and write it
    to a listener of a scene."""
    if (args.recording is None) == (args.device is None):
        raise ValueError("name either a recording or, with --device, a device's profile")
    known = _of_profile(args) if args.recording is None else _of_recording(args)
    print(f"Full Scale: {Curve.text(known['full_scale'])}")
    print(f"Unit: {known['full_scale_unit']}\nCalibrated By: {known['full_scale_source']}")
    if args.scene is not None:
        document = valid_document(read_json(args.scene), args.scene)
        named(
            args.listener, {form["name"]: form for form in document["listeners"]}, "listener"
        ).update(known)
        scene_of(document, args.scene)
        write_document(document, args.scene)
        print(f"wrote {args.scene}")
    answer(args, known)
    return 0


def _of_recording(args: argparse.Namespace) -> JsonObject:
    if not args.unit > 0:
        raise ValueError(f"--unit {args.unit}: must be above 0")
    played = sweep(args.seconds, _RATE) if args.played is None else read_wav(args.played).samples
    points = measured_full_scale(played, args.unit * read_wav(args.recording).samples, _RATE)
    return {
        "full_scale": [[float(f"{number:.4g}") for number in point] for point in points],
        "full_scale_unit": "m/s^2",
        "full_scale_source": f"measured, {args.recording.name}",
    }


def _of_profile(args: argparse.Namespace) -> JsonObject:
    profile = named(args.device, _profiles(args), "device")
    actuator = _actuator(profile, args.actuator or profile.actuators[0].name)
    points, unit, source = full_scale_of(actuator)
    return {
        "full_scale": [list(point) for point in points],
        "full_scale_unit": unit,
        "full_scale_source": f"{profile.title}: {source}",
    }


def _actuator(profile: Profile, name: str) -> Actuator:
    return named(name, {item.name: item for item in profile.actuators}, "actuator")


def _profiles(args: argparse.Namespace) -> dict[str, Profile]:
    """The built-in profiles and the user's; an invalid file is named on stderr and skipped."""
    if args.profiles is not None and not args.profiles.is_dir():
        raise ValueError(f"{args.profiles}: is not a folder")
    profiles, problems = load_profiles(() if args.profiles is None else (args.profiles,))
    for problem in problems:
        print(problem, file=sys.stderr)
    return profiles


def _play_sweep(output: DeviceOutput, seconds: float, only: str | None) -> None:
    """The test sweep on one actuator after the other, or on one, in blocks in real time."""
    names = [item.name for item in output.profile.actuators]
    rows = [k for k, name in enumerate(names) if only in (None, name)]
    one = sweep(seconds / len(rows), _RATE)
    samples = np.zeros((len(names), len(rows) * len(one)))
    for place, row in enumerate(rows):
        samples[row, place * len(one) : (place + 1) * len(one)] = one
    step = round(_FRAME * _RATE)
    start = time.perf_counter()
    for begin in range(0, samples.shape[1], step):
        output.send(samples[:, begin : begin + step])
        time.sleep(max(start + (begin + step) / _RATE - time.perf_counter(), 0.0))
