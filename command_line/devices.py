"""``haptic-tracing devices``: lists connected devices, plays a test sweep, and prints encoded
reports."""

from __future__ import annotations

import argparse
import math
import sys
import time

import numpy as np

from ..core.devices.connection import connected, hid_module, missing_permission
from ..core.devices.families.family import RumbleFamily
from ..core.devices.families.registry import family
from ..core.devices.guard import DeviceOutput
from ..core.devices.profiles import BUILT_IN, Profile, load_profiles
from ..core.devices.report import Report, Transport

_RATE = 8000
_FRAME = 0.02
# From the lowest frequency that a hand feels as vibration to the upper limit of most actuators, at
# a moderate amplitude.
_LOWEST_HZ, _HIGHEST_HZ, _AMPLITUDE = 30.0, 400.0, 0.6
_LOOK_FOR = 3.0


def run(args: argparse.Namespace) -> int:
    """List the devices, or run the requested action."""
    if args.action == "test":
        return run_test(args)
    return run_encode(args) if args.action == "encode" else run_list(args)


def run_encode(args: argparse.Namespace) -> int:
    """Print one report as lower-case hexadecimal."""
    print(
        rumble_report(args.device, args.left, args.right, args.transport, args.sequence).data.hex()
    )
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
    for device in devices:
        families = [family.name for family in device.families]
        names = [
            profile.name
            for family in families
            for profile in profiles.values()
            if profile.family.name == family
        ]
        first = device.first
        ids = f"{first.vendor:04x}:{first.product:04x}"
        print(
            "\t".join(
                [
                    ", ".join(names) or "not supported",
                    first.title or "unnamed",
                    first.transport,
                    ids,
                    first.serial,
                ]
            ).rstrip()
        )
        if families:
            problems += filter(None, map(missing_permission, device.interfaces))
    for problem in problems:
        print(problem)
    return 0


def run_test(args: argparse.Namespace) -> int:
    """Play a sweep and print the reports written."""
    profiles = _profiles(args)
    if args.name not in profiles:
        raise ValueError(f"device {args.name!r} is unknown: use one of {', '.join(profiles)}")
    if not 0.1 <= args.seconds <= 60.0:
        raise ValueError(f"seconds {args.seconds} is not in [0.1, 60]")
    output = DeviceOutput(profiles[args.name], rate=_RATE, serial=args.serial)
    output.start()
    try:
        _wait_until_open(output)
        _play_sweep(output, args.seconds)
    finally:
        output.stop()
    status = output.status
    if status.failed_writes:
        raise OSError(status.message)
    print(
        f"{args.name}: {status.written} reports written, the last is release; "
        f"{1000 * (status.delay or 0.0):.1f} ms from block to report"
    )
    return 0


def _profiles(args: argparse.Namespace) -> dict[str, Profile]:
    """The built-in profiles and the user's; an invalid file is named on stderr and skipped."""
    if args.profiles is not None and not args.profiles.is_dir():
        raise ValueError(f"{args.profiles}: is not a folder")
    profiles, problems = load_profiles(
        [BUILT_IN] if args.profiles is None else [BUILT_IN, args.profiles]
    )
    for problem in problems:
        print(problem, file=sys.stderr)
    return profiles


def _wait_until_open(output: DeviceOutput) -> None:
    end = time.perf_counter() + _LOOK_FOR
    while (
        output.status.state == "searching"
        and time.perf_counter() < end
        and not output.status.message
    ):
        time.sleep(0.01)
    status = output.status
    if status.state != "open":
        raise OSError(status.message or f"{output.profile.title} can't be opened")


def _play_sweep(output: DeviceOutput, seconds: float) -> None:
    """A logarithmic sweep on one actuator after the other, in blocks in real time."""
    actuators = len(output.profile.actuators)
    frames = round(seconds / _FRAME)
    growth = math.log(_HIGHEST_HZ / _LOWEST_HZ)
    start = time.perf_counter()
    for frame in range(frames):
        # Each actuator plays the whole sweep in its share of the time.
        share = frame * actuators / frames
        times = frame * _FRAME + np.arange(round(_FRAME * _RATE)) / _RATE
        part = np.clip(times * actuators / seconds - int(share), 0.0, 1.0)
        phase = 2 * math.pi * _LOWEST_HZ * (seconds / actuators) / growth * np.expm1(growth * part)
        block = np.zeros((actuators, len(times)))
        block[int(share)] = _AMPLITUDE * np.sin(phase)
        output.send(block)
        time.sleep(max(start + (frame + 1) * _FRAME - time.perf_counter(), 0.0))
