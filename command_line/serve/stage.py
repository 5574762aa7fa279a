"""The devices that a server plays on, through the guard process."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence

from ...core.arrays import FloatArray
from ...core.devices.guard import DeviceOutput
from ...core.devices.inventory import look
from ...core.devices.mapping import ListenerMapping, map_listeners
from ...core.devices.profiles import Adjustment, Profile
from ...core.run_time import Run, Step
from .. import say

RATE = 8000.0
"""Samples per second of what devices play."""
SILENCE = 0.25
"""Seconds after the last step from which devices are silent."""
_LOOK = 0.02
_AGAIN = 2.0
"""Seconds between attempts to open a device that can't be silenced, or whose guard can't start."""


class DeviceStage:
    """Devices that play the blocks of one run at a time, ``latency`` seconds later. They fall
    silent `SILENCE` seconds after the last block; those that are lost meanwhile are named on
    stderr, and play again when they are back."""

    def __init__(self, outputs: dict[str, DeviceOutput]) -> None:
        self.outputs = outputs
        self.latency = max(
            (
                output.profile.latency
                for output in outputs.values()
                if isinstance(output.profile, Profile)
            ),
            default=0.0,
        )
        self._mapping: tuple[tuple[tuple[str, str], ...], ListenerMapping] | None = None
        self._played = 0.0
        self._lost: dict[str, float] = {}
        """When devices that are lost were last opened again [s], by their keys."""
        self._ended = threading.Event()
        self._watch = threading.Thread(
            target=self._silence_late, name="haptics silence", daemon=True
        )
        for output in outputs.values():
            output.start()
        self._watch.start()

    @classmethod
    def of(cls, wanted: Sequence[str]) -> DeviceStage:
        """The connected devices whose names contain one of the ``wanted`` texts, all without any.
        Raises ValueError."""
        found = look().devices
        if not wanted and not found:
            raise ValueError("no haptic device is connected")
        chosen = {} if wanted else {device.key: device.open(Adjustment()) for device in found}
        for text in wanted:
            alike = [
                device for device in found if text.lower() in f"{device.key} {device.title}".lower()
            ]
            if not alike:
                known = ", ".join(device.title for device in found) or "none"
                raise ValueError(f"device {text!r} is not connected; connected are: {known}")
            chosen[alike[0].key] = alike[0].open(Adjustment())
        return cls(chosen)

    def play(self, run: Run, step: Step) -> None:
        """Play the block of a step on the actuators of its listeners; of a long one its end, so
        that devices are never late."""
        if step.block.shape[1] and run.sample_rate == RATE:
            self.send(run.body_parts, step.block[:, -int(SILENCE * RATE) :])

    def send(self, body_parts: Mapping[str, str], block: FloatArray) -> None:
        """Play samples (listeners, n) at `RATE`. ``body_parts``: of each listener, by its name."""
        mapping = self.mapping(body_parts)
        self._revive()
        self._played = time.monotonic()
        for key, levels in mapping.blocks(block).items():
            self.outputs[key].send(levels)

    def mapping(self, body_parts: Mapping[str, str]) -> ListenerMapping:
        """The actuators of listeners at these body parts."""
        parts = tuple(body_parts.items())
        if self._mapping is None or self._mapping[0] != parts:
            devices = {key: output.profile for key, output in self.outputs.items()}
            self._mapping = parts, map_listeners(dict(parts), devices)
        return self._mapping[1]

    def _revive(self) -> None:
        """Name devices that were lost or are back, and open those again whose guard has ended."""
        if self._ended.is_set():
            return
        now = time.monotonic()
        for key, output in self.outputs.items():
            status = output.status
            if status.state == "open":
                if self._lost.pop(key, 0.0):
                    say([f"{output.profile.title}: plays again"])
                continue
            if key not in self._lost and status.message:
                say([f"{output.profile.title}: {status.message}"])
                self._lost[key] = now
            silenced = key in self._lost and output.is_silent
            if status.is_over and (silenced or now - self._lost.get(key, now) >= _AGAIN):
                self._lost[key] = now
                output.start()

    def stop(self) -> None:
        """Silence all devices."""
        self._played = 0.0
        for output in self.outputs.values():
            output.silence()

    def close(self) -> None:
        """Silence, release and close all devices."""
        self._ended.set()
        for output in self.outputs.values():
            output.request_stop()
        for output in self.outputs.values():
            output.stop()

    def _silence_late(self) -> None:
        """The thread that silences devices when no step comes."""
        while not self._ended.wait(_LOOK):
            if self._played and time.monotonic() - self._played > SILENCE - 2 * _LOOK:
                self.stop()
