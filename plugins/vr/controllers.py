"""The controllers of the session as a device of live output, and the hands that follow them, once
per frame of the session."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import bpy

from ...addon.blender.time import is_playing_anywhere
from ...addon.live_output import outputs
from ...addon.session import sessions
from ...core.devices.inventory import Found
from ...core.devices.profiles import Adjustment
from . import actions
from .device import LONGEST, PROFILE, VrControllers
from .hands import Grips, Hands

KEY = PROFILE.name
_START_SECONDS, _POLL = 30.0, 0.1  # within which a session begins to run, and between two looks


@dataclass(slots=True)
class _ControllersState:
    """action_set: that of our action. deadline: by time.monotonic, until when the session has to
    run; None since it does. output: the connected controllers, or those connected last. take: the
    grips by frame of the timeline, while hands are recorded."""

    action_set: str = ""
    deadline: float | None = None
    output: VrControllers | None = None
    hands: Hands | None = None
    take: dict[int, Grips] | None = None


_state = _ControllersState()


def begin(action_set: str) -> None:
    """Offer the controllers of the session that starts."""
    _state.action_set = action_set
    _state.deadline = time.monotonic() + _START_SECONDS
    outputs.offer(Found(KEY, PROFILE.title, "VR session", PROFILE, _open))
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_POLL, persistent=True)


def end() -> None:
    """Stop the controllers, and no longer offer them; the hands are gone."""
    use_hands(False)
    outputs.offer(None)
    _state.output, _state.action_set = None, ""
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def _open(adjustment: Adjustment) -> Any:
    """The controllers, which are used like a `DeviceOutput`."""
    _state.output = VrControllers(adjustment, stopping=call)
    _state.output.hands = _state.hands is not None
    return _state.output


def hands() -> Hands | None:
    """The hands, if they are used."""
    return _state.hands


def use_hands(wanted: bool) -> None:
    """Let the controllers play what two hands that touch the scene feel, or if not ``wanted`` what
    the scene's listeners feel."""
    before = _state.hands
    _state.hands = Hands() if wanted else None
    _state.take = None
    if before is not None:
        before.end()
    if _state.output is not None:
        _state.output.silence()
        _state.output.hands = wanted


def is_recording() -> bool:
    """Whether the hands are recorded."""
    return _state.take is not None


def record(wanted: bool) -> dict[int, Grips]:
    """Start or end to record the hands. Returns what was recorded before."""
    before = _state.take
    _state.take = {} if wanted else None
    return before or {}


def _tick() -> float | None:
    """Once per frame of the session, because Blender waits for the headset in its main loop."""
    if not actions.is_running():
        if _state.deadline is not None and time.monotonic() < _state.deadline:
            return _POLL
        end()
        return None
    _state.deadline = None
    _feel()
    call()
    return 0.0


def _feel() -> None:
    """Trace the hands where the controllers are now."""
    scene = bpy.context.scene
    now = time.perf_counter()
    own = None if scene is None or _state.hands is None else sessions.known(scene)
    if own is None or own.reading is None or _state.hands is None:
        return
    grips = actions.grips()
    plays = is_playing_anywhere()
    if plays and grips and _state.take is not None:
        _state.take[scene.frame_current] = grips
    frame = scene.frame_current if plays else None
    for felt in _state.hands.step(own.reading, frame, grips, now):
        block, rate = felt.block, felt.result.sample_rate
        if block is not None and _state.output is not None:
            block = block[:, -round(LONGEST * rate) :]  # what is older is over
            _state.output.send(block, now - block.shape[1] / rate, hands=True)


def call() -> None:
    """Make the calls that are due; without a session nothing vibrates."""
    output = _state.output
    if output is None:
        return
    for hand, due in output.calls(time.perf_counter()).items():
        if not actions.is_running():
            continue
        if due.amplitude:
            accepted = actions.vibrate(
                _state.action_set, hand, due.amplitude, due.frequency, due.seconds
            )
        else:
            accepted = actions.stop(_state.action_set, hand)
        output.answered(accepted)
