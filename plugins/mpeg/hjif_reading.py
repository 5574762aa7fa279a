"""Reading HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31), as the reference software
plays it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.budget import Budget
from ...core.formats.io.error import FormatError
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import read_json
from ...core.formats.tracks.vibration_file import Channel, VibrationFile
from ...core.forms import Form
from ...core.scene.body import BODY_PARTS
from ..keyframes.carrier import Carrier
from ..keyframes.channel import KeyframedChannel
from ..keyframes.left_out import without_damaged
from ..keyframes.transients import transient_carrier
from .wavelet import WaveletBand

_CHANNEL = ("perceptions", "*", "channels", "*")
_SCHEMA = Path(__file__).with_name("hjif.schema.json")
_PARTS = (_CHANNEL, (*_CHANNEL, "bands", "*"), (*_CHANNEL, "bands", "*", "effects", "*"))
_KEY_BYTES = 32
_PIECES = 16
"""Linear pieces of a cubic curve between two keys: an error below 0.3 % of the step between
them."""
LONGEST = 1e5
"""Longest duration (seconds) derived from a channel's number of samples."""

_WAVES = {
    "Sine": ("sine", 1),
    "Square": ("square", 1),
    "Triangle": ("triangle", 1),
    "SawToothUp": ("saw", 1),
    "SawToothDown": ("saw", -1),
}

Keyframe = Form


def read(path: Path) -> VibrationFile:
    """The channels of all perceptions. Raises FormatError or OSError."""
    document = read_json(path)
    losses: dict[str, None] = {}
    without_damaged(document, _PARTS, losses, lambda: validate(document, _SCHEMA, path))
    budget = Budget(path, is_json=True)
    channels = []
    for p, perception in enumerate(document["perceptions"]):
        library = {
            effect["id"]: effect for effect in perception["effect_library"] if "id" in effect
        }
        unit = 10.0 ** perception.get("perception_unit_exponent", 0)
        for c, form in enumerate(perception["channels"]):
            reader = _ChannelReader(document["timescale"], library, losses, budget)
            channels.append(reader.channel(form, unit, f"/perceptions/{p}/channels/{c}"))
    return VibrationFile(tuple(channels), tuple(losses))


def _body_part(channel: Form) -> str:
    """The body part with this mask and target, or none."""
    place = channel["body_part_mask"], tuple(channel.get("body_part_target", ()))
    return next(
        (part.name for part in BODY_PARTS if (part.mpeg_mask, part.mpeg_target) == place), ""
    )


class _ChannelReader:
    def __init__(
        self,
        timescale: int,
        library: Mapping[int, Any],
        losses: dict[str, None],
        budget: Budget,
    ) -> None:
        self.tick = 1 / timescale
        self.library = library
        self.losses = losses
        self.budget = budget

    def channel(self, form: Form, unit: float, place: str) -> Channel:
        gain = form["gain"] * unit
        carriers: list[Carrier] = []
        wavelets = []
        for b, band in enumerate(form["bands"]):
            effects = self._effects(band, f"{place}/bands/{b}")
            if band["band_type"] == "WaveletWave":
                wavelets += self._wavelet_band(band, list(effects), gain, f"{place}/bands/{b}")
            else:
                for carrier in (
                    carrier for effect in effects for carrier in self._carriers(band, effect, gain)
                ):
                    self.budget.take(carrier.size, place)
                    carriers.append(carrier)
        end = max(
            [carrier.end for carrier in carriers] + [band.end for band in wavelets], default=0.0
        )
        rate = form.get("frequency_sampling", 0)
        duration = max(end, min(form.get("sample_count", 0) / rate, LONGEST)) if rate else end
        samples, rate = (
            WaveletBand.summed(wavelets, partial(self.budget.take, pointer=place))
            if wavelets
            else (np.zeros(0), 0.0)
        )
        return KeyframedChannel(
            form["description"],
            duration,
            samples,
            rate,
            _body_part(form),
            carriers=tuple(carriers),
        )

    def _effects(self, band: Form, place: str) -> Iterator[Form]:
        """The basis effects of a band, with references to the library resolved."""
        for e, form in enumerate(band["effects"]):
            effect = form
            if form["effect_type"] == "Reference":
                if form["id"] not in self.library:
                    self._leave_out(f"{place}/effects/{e}", f"no effect {form['id']} to refer to")
                    continue
                effect = {**self.library[form["id"]], "position": form["position"]}
                self.budget.take(_KEY_BYTES * len(effect.get("keyframes", ())), place)
            if effect["effect_type"] == "Basis":
                yield {**effect, "keyframes": self._keyframes(effect.get("keyframes", []))}
            else:
                self.losses["composite effects are not read"] = None

    def _keyframes(self, keys: list[Keyframe]) -> list[Keyframe]:
        """The keyframes in the order of time, with amplitudes within ±1, which the reference
        encoder exceeds."""
        name = "amplitude_modulation"
        ordered = sorted(keys, key=_position)
        if ordered != keys:
            self.losses["keyframes that are not in the order of time are sorted"] = None
        if all(abs(key.get(name, 0)) <= 1 for key in keys):
            return ordered
        self.losses["amplitudes beyond 1 are clipped"] = None
        return [
            {**key, name: min(max(key[name], -1), 1)} if name in key else key for key in ordered
        ]

    def _carriers(self, band: Form, effect: Form, gain: float) -> Iterator[Carrier]:
        if band["band_type"] != "Curve":
            yield from carriers_of(band["band_type"], effect, self.tick, gain)
            return
        curve = band.get("curve_type", "Unknown")
        if curve not in ("Unknown", "Cubic", "Linear"):
            self.losses[f"{curve} curves are read as straight lines"] = None
        yield from _curve(effect, self.tick, gain, curve in ("Unknown", "Cubic"))

    def _wavelet_band(
        self, band: Form, effects: Sequence[Form], gain: float, place: str
    ) -> list[WaveletBand]:
        try:
            blocks = [
                (effect["position"] * self.tick, effect.get("wavelet_stream", ""))
                for effect in effects
            ]
            seconds = band.get("block_length", 0) * self.tick
            take = partial(self.budget.take, pointer=place)
            return [WaveletBand.decoded(blocks, seconds, band["upper_frequency_limit"], gain, take)]
        except FormatError:
            raise
        except ValueError as error:
            self._leave_out(place, str(error))
            return []

    def _leave_out(self, place: str, reason: str) -> None:
        self.losses[f"{place} is left out: {reason}"] = None


def carriers_of(kind: str, effect: Form, tick: float, gain: float = 1.0) -> Iterator[Carrier]:
    """The oscillations of a basis effect in a vectorial or transient band; ``tick``: seconds of a
    unit of time."""
    start = effect["position"] * tick
    keyframes = effect.get("keyframes", [])
    amplitudes = _keys(keyframes, "amplitude_modulation", tick)
    if kind == "Transient":
        if amplitudes is not None:
            for time, strength in zip(*amplitudes, strict=True):
                yield transient_carrier(start + float(time), float(strength) * gain)
        return
    end = start + (_position(keyframes[-1]) * tick if keyframes else 0.0)
    if end <= start:
        return
    frequencies = _keys(keyframes, "frequency_modulation", tick)
    if frequencies is None:
        return
    wave, sign = _WAVES[effect.get("base_signal", "Sine")]
    times, values = (np.zeros(1), np.ones(1)) if amplitudes is None else amplitudes
    phase = effect.get("phase", 0.0)
    yield Carrier(start, end, phase, times, values * (sign * gain), *frequencies, wave)


def _curve(effect: Form, tick: float, gain: float, is_cubic: bool) -> Iterator[Carrier]:
    """A curve is the vibration itself: an oscillation of frequency 0 at its crest. Cubic ones are
    level at each key."""
    start = effect["position"] * tick
    keys = _keys(effect.get("keyframes", []), "amplitude_modulation", tick)
    if keys is None:
        return
    times, values = keys
    end = start + float(times[-1])
    if is_cubic and len(times) > 1:
        share = np.arange(_PIECES) / _PIECES
        rise = share * share * (3 - 2 * share)
        times, values = (
            np.append((keys[:-1, None] + np.diff(keys)[:, None] * shape).ravel(), keys[-1])
            for keys, shape in ((times, share), (values, rise))
        )
    if end > start:
        yield Carrier(start, end, math.pi / 2, times, values * gain, np.zeros(1), np.zeros(1))


def _position(keyframe: Keyframe) -> int:
    """The ticks from the start of its effect."""
    return int(keyframe.get("relative_position", 0))


def _keys(
    keyframes: Sequence[Keyframe], name: str, tick: float
) -> tuple[FloatArray, FloatArray] | None:
    """Times (seconds) and values of the keyframes that have this value."""
    keys = [keyframe for keyframe in keyframes if name in keyframe]
    if not keys:
        return None
    times = np.array([_position(keyframe) for keyframe in keys], dtype=np.float64)
    return times * tick, np.array([keyframe[name] for keyframe in keys], dtype=np.float64)
