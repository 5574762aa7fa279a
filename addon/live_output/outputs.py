"""Found and driven devices. Nothing of it is saved, and no thread accesses Blender."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

from ...core.arrays import FloatArray
from ...core.devices import guard
from ...core.devices.guard import DeviceOutput
from ...core.devices.inventory import Found, Inventory, cancel, look
from ...core.devices.mapping import ActuatedDevice
from ...core.devices.profiles import Adjustment, Calibration
from ..properties.live_output import HapticDeviceProperties


@dataclass(slots=True)
class _DevicesState:
    """offered: a device that is there without a search. driven: the running devices, as found.
    version: changes with the set of running devices.
    renderer: the thread that renders the continuation of the last blocks, and its job."""

    inventory: Inventory | None = None
    offered: Found | None = None
    finder: threading.Thread | None = None
    running: dict[str, DeviceOutput] = field(default_factory=dict)
    driven: dict[str, Found] = field(default_factory=dict)
    version: int = 0
    renderer: ThreadPoolExecutor | None = None
    job: Future[None] | None = None
    rested: float = 0.0  # when the renderer may work again, by time.monotonic


_state = _DevicesState()


def version() -> int:
    """A number that changes with the set of driven devices."""
    return _state.version


def inventory() -> Inventory | None:
    """The result of the last search, with the device that is offered; None before the first search
    if none is."""
    if _state.offered is None:
        return _state.inventory
    found = _state.inventory or Inventory()
    return replace(found, devices=(_state.offered, *found.devices))


def offer(device: Found | None) -> None:
    """Offer a device without a search; None ends that, and disconnects the one offered before."""
    before, _state.offered = _state.offered, device
    if before is not None:
        disconnect(before.key)


def is_finding() -> bool:
    """True while a search for devices runs."""
    return _state.finder is not None and _state.finder.is_alive()


def find(folders: tuple[Path, ...] = (), sound_cards: bool = False, players: bool = False) -> None:
    """Search for devices in the background, because that is slow on some systems. ``folders``:
    those of the user's device profiles."""
    if not is_finding():
        _state.finder = threading.Thread(
            target=_find,
            args=(folders, sound_cards, players),
            name="haptics find devices",
            daemon=True,
        )
        _state.finder.start()


def _find(folders: tuple[Path, ...], sound_cards: bool, players: bool) -> None:
    """The thread of a search."""
    _state.inventory = look(folders, with_sound_cards=sound_cards, with_players=players)


def wait_until_found(timeout: float = 5.0) -> None:
    """Wait for the running search."""
    if _state.finder is not None:
        _state.finder.join(timeout)


def running() -> dict[str, DeviceOutput]:
    """The driven devices by key."""
    return _state.running


def found(key: str) -> Found | None:
    """A found or driven device by its key."""
    if key in _state.driven:
        return _state.driven[key]
    return next(
        (device for device in (inventory() or Inventory()).devices if device.key == key), None
    )


def preferred(part: str) -> str:
    """The key of the first found device whose name contains ``part``, else of the first device; ""
    if none was found."""
    devices = (inventory() or Inventory()).devices
    wanted = [
        device.key for device in devices if part.lower() in f"{device.key} {device.title}".lower()
    ]
    return next(iter([*wanted, *(device.key for device in devices)]), "")


def adjustment_of(settings: HapticDeviceProperties, device: ActuatedDevice) -> Adjustment:
    """The user's settings of a device, on top of its profile."""
    return Adjustment(
        calibrations={
            actuator.name: Calibration(
                gain=min(actuator.calibration.gain * settings.gain, 10.0),
                floor=max(actuator.calibration.floor, settings.floor),
                exponent=min(max(actuator.calibration.exponent * settings.curve, 0.1), 10.0),
            )
            for actuator in device.actuators
        },
        ceiling=settings.ceiling,
        delay=settings.offset / 1000,
    )


def connect(key: str, adjustment: Adjustment) -> None:
    """Drive a found device from now on. Raises ValueError if it is unknown."""
    device = found(key)
    if device is None:
        raise ValueError(f"device {key!r} is not connected")
    if key not in _state.running:
        output = device.open(adjustment)
        output.start()
        _state.running[key], _state.driven[key] = output, device
        _state.version += 1


def disconnect(key: str) -> None:
    """Zero, release and close a device, without waiting for it."""
    output = _state.running.pop(key, None)
    _state.driven.pop(key, None)
    if output is not None:
        output.request_stop()
        _state.version += 1


def expect(render: Callable[[], Mapping[str, FloatArray]], sent: Mapping[str, float]) -> None:
    """Send the devices the samples to play after the blocks ``sent`` (when, by key) if the next
    blocks are late.

    A separate thread calls ``render``, for at most a fifth of the time: if that is not enough, some
    frames are skipped.
    """
    if (_state.job is not None and not _state.job.done()) or time.monotonic() < _state.rested:
        return
    if _state.renderer is None:
        _state.renderer = ThreadPoolExecutor(1, "haptics following")
    _state.job = _state.renderer.submit(_expect, render, sent, dict(_state.running))


def _expect(
    render: Callable[[], Mapping[str, FloatArray]],
    sent: Mapping[str, float],
    running: Mapping[str, DeviceOutput],
) -> None:
    begun = time.monotonic()
    for key, ahead in render().items():
        if key in sent:
            running[key].expect(ahead, sent[key])
    ended = time.monotonic()
    _state.rested = ended + 4.0 * (ended - begun)


def rest() -> None:
    """All devices to zero, then release. Never blocks."""
    for output in _state.running.values():
        output.rest()


def silence() -> None:
    """All devices to zero. Never blocks."""
    for output in _state.running.values():
        output.silence()


def disconnect_all() -> None:
    """All devices to zero, released and closed, without waiting for them; a running search for
    devices is abandoned."""
    cancel()
    for key in tuple(_state.running):
        disconnect(key)


def stop_and_tell(timeout: float) -> list[tuple[str, str]]:
    """Disconnect all devices, waiting up to ``timeout`` seconds. Returns the title of each, and why
    it may still vibrate, or ""."""
    stopping = list(dict.fromkeys([*_state.running.values(), *guard.outputs()]))
    disconnect_all()
    guard.stop_all(timeout)
    return [
        (output.profile.title, "" if output.is_silent else output.status.message or "no answer")
        for output in stopping
    ]


def stop_all(timeout: float = 1.0) -> bool:
    """Disconnect all devices, waiting up to ``timeout`` seconds. Returns whether all are done."""
    disconnect_all()
    renderer, _state.renderer, _state.job = _state.renderer, None, None
    if renderer is not None:
        renderer.shutdown(cancel_futures=True)
    wait_until_found(timeout)
    return guard.stop_all(timeout)


def forget() -> None:
    """Discard the result of the search."""
    _state.inventory = None
