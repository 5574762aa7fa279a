"""Assignment of listeners to actuators, and its losses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..message import Cause, Hertz, Message, Names, Seconds
from ..scene.body import body_part
from .profiles import Profile
from .sound_card import SoundCard

LATEST = 0.050
"""Seconds by which touch may lag behind the picture unnoticed (Di Luca and Mahnan, 2019)."""


ActuatedDevice = Profile | SoundCard


@frozen
class Place:
    """An actuator of a device with the gain, >= 0, of a listener's signal; equality ignores the
    gain."""

    device: str
    actuator: str
    gain: float = field(default=1.0, compare=False)


@frozen
class Loss:
    """A part of a listener's signal that is not felt. message: what is lost, without the listener's
    name."""

    listener: str
    message: Message


@frozen
class ListenerMapping:
    """Mapping from the samples of listeners to the blocks of devices.

    listeners: names, in the order of the samples' rows. weights: for each device an array
    (actuators, listeners) of gains. positions: for each device those of its actuators (actuators,
    2), NaN if unknown.
    """

    listeners: tuple[str, ...]
    weights: Mapping[str, FloatArray]
    losses: tuple[Loss, ...]
    positions: Mapping[str, FloatArray]

    def panned(self, device: str, row: int) -> IntArray:
        """The actuators of a device over which listener number ``row`` is panned; none if there are
        fewer than two with positions."""
        chosen = np.flatnonzero(
            np.isfinite(self.positions[device][:, 0]) & (self.weights[device][:, row] > 0)
        )
        return chosen if len(chosen) > 1 else chosen[:0]

    @property
    def pans(self) -> bool:
        """Whether any actuator has a position."""
        return any(np.isfinite(positions).any() for positions in self.positions.values())

    def blocks(
        self, samples: FloatArray, before: FloatArray | None = None, after: FloatArray | None = None
    ) -> dict[str, FloatArray]:
        """For each device the sum of its listeners, (actuators, n). samples: (listeners, n).

        before, after: position of each listener in the unit square of its actuators at the
        beginning and the end of the block, (listeners, 2), by which it is panned.
        """
        if samples.ndim != 2 or samples.shape[0] != len(self.listeners):
            raise ValueError(
                f"samples has the shape {samples.shape}, not ({len(self.listeners)}, n)"
            )
        blocks = {device: weights @ samples for device, weights in self.weights.items()}
        if before is None or after is None:
            return blocks
        ramp = np.arange(samples.shape[1]) / max(samples.shape[1], 1)
        for device, weights in self.weights.items():
            for row in range(len(self.listeners)):
                chosen = self.panned(device, row)
                if len(chosen):
                    begin, end = (
                        shares(self.positions[device][chosen], place[row])[:, None]
                        for place in (before, after)
                    )
                    blocks[device][chosen] += (
                        weights[chosen, row, None]
                        * (np.sqrt(begin + (end - begin) * ramp) - 1.0)
                        * samples[row]
                    )
        return blocks


def shares(positions: FloatArray, place: FloatArray) -> FloatArray:
    """Shares (k,) of the power of a signal at ``place`` in the unit square for actuators at
    ``positions`` (k, 2).

    They add up to 1, so that amplitudes are those of the energy model, sqrt(1 - beta) and
    sqrt(beta) at the fraction beta of the distance between two actuators (A. Israr, I. Poupyrev,
    "Tactile Brush", CHI 2011, doi 10.1145/1978942.1979235): along rows and columns if the actuators
    fill a grid, otherwise weighted by inverse distance.
    """
    where = positions.min(axis=0) + np.ptp(positions, axis=0) * place
    ticks = [np.unique(column) for column in positions.T]
    if len(ticks[0]) * len(ticks[1]) != len(positions):
        near = 1.0 / np.maximum(np.hypot(*(positions - where).T), 1e-9)
        return np.asarray(near / near.sum())
    parts = np.ones(len(positions))
    for tick, column, here in zip(ticks, positions.T, where.tolist(), strict=True):
        parts *= np.array([np.interp(here, tick, row) for row in np.eye(len(tick))])[
            np.searchsorted(tick, column)
        ]
    return parts


def map_listeners(
    listeners: Mapping[str, str],
    devices: Mapping[str, ActuatedDevice],
    *,
    chosen: Mapping[str, Sequence[Place]] | None = None,
    bands: Mapping[str, tuple[float, float]] | None = None,
) -> ListenerMapping:
    """Give each listener the actuators that are felt at its body part.

    listeners: name to body part, or to "" for none. devices: the connected devices by name. chosen:
    listeners with their actuators as chosen by the user; an empty choice means muted and is no
    loss. bands: the frequencies (low, high) in Hz that a listener's signal has, where known. Raises
    ValueError for an unknown body part, listener, device or actuator.
    """
    chosen = dict(chosen or {})
    bands = dict(bands or {})
    for name, given in (("chosen", chosen), ("bands", bands)):
        unknown = sorted(set(given) - set(listeners))
        if unknown:
            raise ValueError(f"{name} names an unknown listener: {unknown[0]!r}")
    names = tuple(listeners)
    weights = {
        device: np.zeros((len(profile.actuators), len(names)))
        for device, profile in devices.items()
    }
    losses: list[Loss] = []
    for row, (listener, part) in enumerate(listeners.items()):
        places = chosen[listener] if listener in chosen else _places_at(part, devices)
        if not places and listener not in chosen:
            message = (
                Message.of(Cause.NO_ACTUATOR, body_part=part)
                if part
                else Message.of(Cause.NO_BODY_PART)
            )
            losses.append(Loss(listener, message))
        for place in places:
            if place.device not in devices:
                raise ValueError(f"device {place.device!r} is not connected")
            weights[place.device][_index(devices[place.device], place), row] = place.gain
    for device, profile in devices.items():
        losses += _losses(profile, weights[device], names, bands)
    positions = {
        device: np.array(
            [actuator.position or (np.nan, np.nan) for actuator in profile.actuators],
            dtype=np.float64,
        ).reshape(-1, 2)
        for device, profile in devices.items()
    }
    return ListenerMapping(names, weights, tuple(losses), positions)


def _places_at(part: str, devices: Mapping[str, ActuatedDevice]) -> list[Place]:
    if not part:
        return []
    name = body_part(part).name
    return [
        Place(device, actuator.name)
        for device, profile in devices.items()
        for actuator in profile.actuators
        if name in actuator.body_parts
    ]


def _index(profile: ActuatedDevice, place: Place) -> int:
    names = [actuator.name for actuator in profile.actuators]
    if place.actuator not in names:
        raise ValueError(
            f"{place.device} has no actuator {place.actuator!r}: use one of {', '.join(names)}"
        )
    return names.index(place.actuator)


def _losses(
    profile: ActuatedDevice,
    weights: FloatArray,
    names: tuple[str, ...],
    bands: Mapping[str, tuple[float, float]],
) -> Iterator[Loss]:
    """The losses of a device for each of its listeners."""
    for actuator, felt in zip(profile.actuators, weights, strict=True):
        sharing = [names[row] for row in np.flatnonzero(felt)]
        for listener in sharing:
            names_of = {"actuator": actuator.name, "device": profile.title}
            others = Names(name for name in sharing if name != listener)
            if others:
                yield Loss(
                    listener, Message.of(Cause.SHARED_ACTUATOR, listeners=others, **names_of)
                )
            low, high = actuator.band
            least, most = bands.get(listener, actuator.band)
            if not low <= least <= most <= high:
                cause = (
                    Cause.OUT_OF_BAND if most < low or least > high else Cause.PARTLY_OUT_OF_BAND
                )
                limits = {
                    "low": Hertz(least),
                    "high": Hertz(most),
                    "lowest": Hertz(low),
                    "highest": Hertz(high),
                }
                yield Loss(listener, Message.of(cause, **limits, **names_of))
            if not profile.plays_frequency:
                yield Loss(listener, Message.of(Cause.STRENGTH_ONLY, **names_of))
            if actuator.latency > LATEST:
                message = Message.of(
                    Cause.LATE, delay=Seconds(actuator.latency), limit=Seconds(LATEST), **names_of
                )
                yield Loss(listener, message)
