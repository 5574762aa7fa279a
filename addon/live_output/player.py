"""Output of traced frames to devices: blocks during playback, grains during scrubbing, silence
otherwise."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter as clock
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.devices.mapping import ListenerMapping, Loss, Place, map_listeners, shares
from ...core.devices.pacing import WATCHDOG
from ...core.frozen import frozen
from ...core.message import Cause, Message, Names
from ...core.render.frame_result import FrameResult
from ...core.render.playback import Playback, grain, recorded_grain
from ...core.scene.body_map import Spot
from ...core.signals import Automation, Decay, Product, Signal, Sine
from ..properties.actuators import places_of
from ..properties.preferences import preferences
from . import outputs, preview

SLOW = 8.0
"""Tracing time [ms] beyond which, after a few frames in a row, frames are played before they are
traced."""
_SLOW_FRAMES = 2


@frozen
class _PlayedAhead:
    """A frame that was played before it was traced: its scene (session id), the time at which its
    block was sent, and the listeners' choices."""

    scene: int
    frame: int
    sent: float
    choices: Mapping[str, str]


@dataclass(slots=True)
class _PlayerState:
    """lock: for what the worker uses when it corrects a block."""

    lock: threading.RLock = field(default_factory=threading.RLock)
    playing: bool = False
    scene: int | None = None
    result: FrameResult | None = None  # the last one that was played
    playback: Playback = field(default_factory=Playback)
    # Without and with bands: inputs, and it.
    mappings: dict[bool, tuple[tuple[Any, ...], ListenerMapping]] = field(default_factory=dict)
    timed: float | None = None  # the time [s] of the last frame whose tracing time was looked at
    slow: int = 0  # frames in a row that took long
    ahead: _PlayedAhead | None = None
    # The frame of the last block, and where it arrives at its listeners.
    arrived: tuple[FrameResult, FloatArray] | None = None


_state = _PlayerState()


def is_playing() -> bool:
    """True between the start and the end of playback."""
    return _state.playing


def is_wanted() -> bool:
    """True if there is any output."""
    return bool(outputs.running()) or preview.is_on()


def start(scene: int, time: float) -> None:
    """Playback begins in a scene (its session id), at ``time`` [s]."""
    with _state.lock:
        _state.playing, _state.scene, _state.result, _state.ahead = True, scene, None, None
        _state.playback.start(time)


def stop() -> None:
    """Playback ends: silence the devices, and release them unless the user keeps them awake."""
    _state.playing = False
    rest(release=not preferences().keep_awake)


def rest(release: bool = True) -> None:
    """Write zero and the release report now; the next frame plays again."""
    with _state.lock:
        _state.result = _state.ahead = _state.arrived = None
        _state.playback = Playback()
        (outputs.rest if release else outputs.silence)()
    preview.silence()


def play(
    scene: int,
    result: FrameResult,
    frame_seconds: float,
    choices: Mapping[str, str],
    recorded: bool = False,
) -> None:
    """Play a frame when its trace is complete.

    Args:
        scene: Session id of its scene.
        result: The frame; nothing happens if it was played last.
        frame_seconds: Duration of a frame [s].
        choices: The actuators chosen for listeners, by name, as `places_of` reads them.
        recorded: It was read from a track.
    """
    if _state.playing and scene != _state.scene:
        rest()
        _state.scene = scene
    if not result.listeners:
        rest()
    if _state.result is result or not result.listeners:
        return
    with _state.lock:
        _state.result, _state.ahead = result, None
        if _state.playing:
            samples = (
                _state.playback.recorded(result)
                if recorded
                else _state.playback.block(result, frame_seconds)
            )
        else:
            samples = recorded_grain(result) if recorded else grain(result, frame_seconds)
        if not samples.shape[1]:
            return
        _send(result, samples, choices, recorded)
    preview.play(result.listeners, samples, result.sample_rate)


def play_ahead(
    scene: int,
    latest: FrameResult,
    frame: int,
    time: float,
    frame_seconds: float,
    choices: Mapping[str, str],
) -> None:
    """Play a frame before it is traced if tracing has been slow, with the gains of an earlier one.

    Args:
        scene: Session id of its scene.
        latest: The last traced frame, whose gains it gets.
        frame: Its number.
        time: Its time [s].
        frame_seconds: Duration of a frame [s].
        choices: As of `play`.
    """
    if latest.time != _state.timed:
        _state.timed = latest.time
        _state.slow = _state.slow + 1 if sum(latest.milliseconds.values()) > SLOW else 0
    if not _state.playing or _state.scene != scene or _state.slow < _SLOW_FRAMES:
        return
    with _state.lock:
        sent = clock()
        samples = _state.playback.ahead(latest, time, frame_seconds)
        if samples is None:
            return
        _state.ahead = _PlayedAhead(scene, frame, sent, choices)
        _send(latest, samples, choices, sent=sent)
    preview.play(latest.listeners, samples, latest.sample_rate)


def went_ahead(scene: int, frame: int) -> bool:
    """Whether a frame was played before it was traced."""
    return _state.ahead is not None and (_state.ahead.scene, _state.ahead.frame) == (scene, frame)


def correct(result: FrameResult) -> None:
    """Replace the rest of the block that was played ahead by the ``result`` of its frame, traced
    meanwhile. Thread-safe."""
    with _state.lock:
        ahead = _state.ahead
        if ahead is None:
            return
        elapsed = clock() - ahead.sent
        samples = _state.playback.correction(result, elapsed)
        if samples is not None and samples.shape[1]:
            _send(result, samples, ahead.choices, sent=ahead.sent + elapsed)


def _send(
    result: FrameResult,
    samples: FloatArray,
    choices: Mapping[str, str],
    recorded: bool = False,
    sent: float | None = None,
) -> None:
    """Send a block and its continuation to the devices.

    Args:
        result: The frame that the block is of.
        samples: The block (l, n).
        choices: As of `play`.
        recorded: The block is of a track, which says itself how it continues.
        sent: When the block began [s of `perf_counter`]; None for now.
    """
    mapping = _mapping_of(result, choices, {})
    running = dict(outputs.running())
    before = after = None
    if mapping.pans:
        before = after = result.arrivals()
        if _state.arrived is not None and len(_state.arrived[1]) == len(after):
            before = _state.arrived[1]
        _state.arrived = result, after
    blocks = {
        key: block
        for key, block in mapping.blocks(samples, before, after).items()
        if key in running
    }
    times = {
        key: running[key].send(block) if sent is None else running[key].send(block, sent)
        for key, block in blocks.items()
    }
    if times and _state.playing and not recorded:
        following = _state.playback.following(result, WATCHDOG)
        outputs.expect(lambda: mapping.blocks(following(), after, after), times)


def spots() -> tuple[Spot, ...]:
    """The panned actuators, with their last amplitudes."""
    if _state.arrived is None or False not in _state.mappings:
        return ()
    (result, arrivals), (_, mapping) = _state.arrived, _state.mappings[False]
    found = []
    for device in mapping.weights.keys() & outputs.running().keys():
        for row, listener in enumerate(result.listeners):
            places = mapping.positions[device][mapping.panned(device, row)]
            if len(places):
                parts = np.sqrt(shares(places, arrivals[row])).tolist()
                within = (places - places.min(axis=0)) / np.maximum(np.ptp(places, axis=0), 1e-9)
                found += [
                    Spot(listener.body_part, x, y, part)
                    for (x, y), part in zip(within.tolist(), parts, strict=True)
                ]
    return tuple(found)


def mapping_of(result: FrameResult, choices: Mapping[str, str]) -> ListenerMapping:
    """The mapping of the listeners of a frame to actuators, with its losses."""
    return _mapping_of(result, choices, _bands(result))


def _mapping_of(
    result: FrameResult, choices: Mapping[str, str], bands: Mapping[str, tuple[float, float]]
) -> ListenerMapping:
    """The mapping for signals within these ``bands`` [Hz] by listener."""
    listeners = tuple((listener.name, listener.body_part) for listener in result.listeners)
    key = outputs.version(), listeners, tuple(sorted(choices.items())), tuple(bands.items())
    known = _state.mappings.get(bool(bands))
    if known is None or known[0] != key:
        known = _state.mappings[bool(bands)] = key, _mapped(dict(listeners), choices, bands)
    return known[1]


def _bands(result: FrameResult) -> dict[str, tuple[float, float]]:
    """The lowest and highest frequency [Hz] at each listener that only tones reach."""
    tones = [_tone(source.signal) for source in result.sources]
    bands = {}
    for row, listener in enumerate(result.listeners):
        heard = [
            tone
            for tone, gain in zip(tones, result.amplitudes[:, row].tolist(), strict=True)
            if gain > 0
        ]
        if heard and None not in heard:
            values = np.concatenate(
                [
                    f.values if isinstance(f, Automation) else [f]
                    for f in (tone.frequency for tone in heard if tone)
                ]
            )
            bands[listener.name] = float(values.min()), float(values.max())
    return bands


def _tone(signal: Signal | None) -> Sine | None:
    """The tone of a signal that is one, with or without decay, else None."""
    if isinstance(signal, Product) and all(isinstance(part, Decay) for part in signal.of[1:]):
        signal = signal.of[0]
    return signal if isinstance(signal, Sine) else None


def _mapped(
    listeners: Mapping[str, str],
    choices: Mapping[str, str],
    bands: Mapping[str, tuple[float, float]],
) -> ListenerMapping:
    devices = {key: output.profile for key, output in dict(outputs.running()).items()}
    known = {
        Place(key, actuator.name)
        for key, device in devices.items()
        for actuator in device.actuators
    }
    chosen: dict[str, list[Place]] = {}
    absent: list[Loss] = []
    for listener, choice in choices.items():
        places = places_of(choice)
        if places is None or listener not in listeners:
            continue
        chosen[listener] = [place for place in places if place in known]
        missing = [place for place in places if place not in known]
        if missing:
            names = Names(f"{place.actuator} of {place.device}" for place in missing)
            absent.append(Loss(listener, Message.of(Cause.ACTUATOR_GONE, actuators=names)))
    mapping = map_listeners(listeners, devices, chosen=chosen, bands=bands)
    return replace(mapping, losses=(*absent, *mapping.losses))
