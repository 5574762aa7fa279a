"""``haptic-tracing devices``: what is connected, a test sweep, and reports as bytes."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import _SubParsersAction

    from ..core.devices.output import DeviceOutput
    from ..core.devices.profiles import Profile

_RATE = 8000
_FRAME = 0.02
# From the lowest that a hand feels as vibration to the end of what most actuators play, at an amplitude that disturbs nobody.
_LOWEST_HZ, _HIGHEST_HZ, _AMPLITUDE = 30.0, 400.0, 0.6
_LOOK_FOR = 3.0


def add_parser(subparsers: _SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register ``devices`` with its actions."""
    parser = subparsers.add_parser("devices", help="haptic devices: list, test, encode", description="List the connected haptic devices.")
    parser.set_defaults(run=run_list)
    parser.add_argument("--profiles", metavar="FOLDER", type=Path, help="folder with device profiles of your own (*.json)")
    actions = parser.add_subparsers(dest="action", metavar="ACTION")

    test = actions.add_parser("test", help="play a sweep on each actuator of a device in turn, then silence and release it")
    test.add_argument("name", metavar="NAME", help="a device's name as listed, such as dualsense")
    test.add_argument("--serial", default="", help="of one device among several alike")
    test.add_argument("--seconds", type=float, default=3.0, help="length of the sweep, 0.1 to 60 (default 3)")
    test.set_defaults(run=run_test)

    encode = actions.add_parser("encode", help="print the report that drives a device, as hexadecimal")
    encode.add_argument("device", metavar="DEVICE", help="dualsense, switch-pro, xbox, ...")
    encode.add_argument("--transport", choices=("usb", "bt"), help="default: the device's first")
    encode.add_argument("--left", type=float, default=0.0, help="amplitude in [0, 1] of the left or low-frequency motor (default 0)")
    encode.add_argument("--right", type=float, default=0.0, help="amplitude in [0, 1] of the right or high-frequency motor (default 0)")
    encode.add_argument("--sequence", type=int, default=0, help="number of the report, 0 to 15 (default 0)")
    encode.set_defaults(run=run_encode)


def run_encode(args: argparse.Namespace) -> int:
    """Print one report as lower-case hexadecimal."""
    from ..core.devices.families.registry import rumble_report

    print(rumble_report(args.device, args.left, args.right, args.transport, args.sequence).data.hex())
    return 0


def run_list(args: argparse.Namespace) -> int:
    """Print a line for each connected device, then what keeps some of them from being used."""
    from ..core.devices.connection import connected, hid_module, missing_permission

    profiles = _profiles(args)
    devices = connected(hid_module())
    if not devices:
        print("no haptic device is connected")
    problems: list[str] = []
    for device in devices:
        families = [family.name for family in device.families]
        names = [profile.name for family in families for profile in profiles.values() if profile.family.name == family]
        ids = f"{device.vendor:04x}:{device.product:04x}"
        print("\t".join([", ".join(names) or "not supported", device.title or "unnamed", device.transport, ids, device.serial]).rstrip())
        if families:
            problems += filter(None, map(missing_permission, device.interfaces))
    for problem in problems:
        print(problem)
    return 0


def run_test(args: argparse.Namespace) -> int:
    """Play a sweep and say what was written."""
    from ..core.devices.output import DeviceOutput

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
    print(f"{args.name}: {status.written} reports written, the last is release; {1000 * (status.delay or 0.0):.1f} ms from block to report")
    return 0


def _profiles(args: argparse.Namespace) -> dict[str, Profile]:
    """The built-in profiles and the user's; a broken file is named on stderr and does not keep the others from being used."""
    import sys

    from ..core.devices.profiles import BUILT_IN, load_profiles

    if args.profiles is not None and not args.profiles.is_dir():
        raise ValueError(f"{args.profiles}: is not a folder")
    profiles, problems = load_profiles([BUILT_IN] if args.profiles is None else [BUILT_IN, args.profiles])
    for problem in problems:
        print(problem, file=sys.stderr)
    return profiles


def _wait_until_open(output: DeviceOutput) -> None:
    import time

    end = time.perf_counter() + _LOOK_FOR
    while output.status.state == "searching" and time.perf_counter() < end and not output.status.message:
        time.sleep(0.01)
    status = output.status
    if status.state != "open":
        raise OSError(status.message or f"{output.profile.title} can't be opened")


def _play_sweep(output: DeviceOutput, seconds: float) -> None:
    """A logarithmic sweep on one actuator after the other, in blocks at the pace of time."""
    import time

    import numpy as np

    actuators = len(output.profile.actuators)
    frames = round(seconds / _FRAME)
    growth = math.log(_HIGHEST_HZ / _LOWEST_HZ)
    start = time.perf_counter()
    for frame in range(frames):
        # Each actuator has its share of the time, and hears the whole sweep in it.
        share = frame * actuators / frames
        times = frame * _FRAME + np.arange(round(_FRAME * _RATE)) / _RATE
        part = np.clip(times * actuators / seconds - int(share), 0.0, 1.0)
        phase = 2 * math.pi * _LOWEST_HZ * (seconds / actuators) / growth * np.expm1(growth * part)
        block = np.zeros((actuators, len(times)))
        block[int(share)] = _AMPLITUDE * np.sin(phase)
        output.send(block)
        time.sleep(max(start + (frame + 1) * _FRAME - time.perf_counter(), 0.0))
