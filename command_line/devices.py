"""``haptic-tracing devices``: what is connected, a test sweep, and reports as bytes."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import _SubParsersAction


def add_parser(subparsers: _SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register ``devices`` with its actions."""
    parser = subparsers.add_parser("devices", help="haptic devices: list, test, encode", description="List the connected haptic devices.")
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    encode = actions.add_parser("encode", help="print the report that drives a device, as hexadecimal")
    encode.add_argument("device", metavar="DEVICE", help="dualsense, switch-pro, xbox, ...")
    encode.add_argument("--transport", choices=("usb", "bt"), help="default: the device's first")
    encode.add_argument("--left", type=float, default=0.0, help="amplitude in [0, 1] of the left or low-frequency motor (default 0)")
    encode.add_argument("--right", type=float, default=0.0, help="amplitude in [0, 1] of the right or high-frequency motor (default 0)")
    encode.add_argument("--sequence", type=int, default=0, help="number of the report, 0 to 15 (default 0)")
    encode.set_defaults(run=run_encode)


def run_encode(args: argparse.Namespace) -> int:
    """Print one report as lower-case hexadecimal."""
    from ..core.devices.registry import rumble_report

    print(rumble_report(args.device, args.left, args.right, args.transport, args.sequence).data.hex())
    return 0
