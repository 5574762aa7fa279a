"""``haptic-tracing serve``: answers poses from an engine with levels, impacts and samples, and
drives devices."""

from __future__ import annotations

import argparse
import errno
import secrets
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

from ...core.run_time import load
from .. import answer, say
from .conversation import Conversation
from .front import LOCAL, serve_forever
from .live_view import LiveView
from .osc import OscDoor
from .sockets import Door
from .stage import DeviceStage


def run(args: argparse.Namespace) -> NoReturn:
    """Serve until Ctrl-C, or until the program is asked to end."""
    signal.signal(signal.SIGTERM, _end)
    scene = None if args.scene is None else load(args.scene)
    host, port = _address(args.listen)
    if host not in LOCAL and args.token is None:
        raise ValueError(
            f"--listen {args.listen}: others than this machine may connect only with a token: "
            "name one by --token"
        )
    if args.osc is not None and scene is None:
        raise ValueError("--osc: needs a scene")
    if args.osc_devices and args.osc is None:
        raise ValueError("--osc-devices: needs --osc")
    token = args.token or secrets.token_urlsafe(12)
    stage = DeviceStage.of(args.device) if args.device else None
    view = LiveView(sys.stdout)
    holder = "OSC" if args.osc_devices else None
    door = Door(scene, stage, host, token, args.allow_origin, view.show, holder)
    osc = None
    try:
        with door.listen(port) as server:
            if args.osc is not None:
                osc = OscDoor(
                    Conversation(scene, lambda _: stage if args.osc_devices else None), args.osc
                )
                osc.start()
            address = f"{host}:{server.socket.getsockname()[1]}"
            say(_greeting(address, token, stage, args))
            answer(args, {"url": f"ws://{address}", "token": token})
            args.stdout.flush()
            serve_forever(server)
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise
        raise ValueError(
            "the port is in use: end the program that listens there, or choose another port; "
            "--listen HOST:0 takes a free one"
        ) from None
    finally:
        if osc is not None:
            osc.close()
        if stage is not None:
            stage.close()


def _end(number: int, frame: FrameType | None) -> NoReturn:
    """Called on SIGTERM: devices are silenced and closed on the way out."""
    raise SystemExit(0)


def _greeting(
    address: str, token: str, stage: DeviceStage | None, args: argparse.Namespace
) -> Sequence[str]:
    lines = [f"listening on ws://{address}, token {token}"]
    if args.osc is not None:
        lines.append(f"listening for OSC on udp://127.0.0.1:{args.osc}")
    if stage is not None:
        titles = [output.profile.title for output in stage.outputs.values()]
        users = "OSC" if args.osc_devices else "clients with the token"
        lines.append(f"devices: {_first_few(titles)}, for {users}")
    return lines


def _address(text: str) -> tuple[str, int]:
    """Host and port. Raises ValueError."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 <= int(port) <= 65535:
        raise ValueError(f"--listen {text}: expected HOST:PORT")
    return host.strip("[]"), int(port)


def _first_few(items: Sequence[str]) -> str:
    """Names for a person: the first few."""
    return ", ".join(items[:5]) + (f" and {len(items) - 5} more" if len(items) > 5 else "")
