"""Reading HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31), as the reference software
plays it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...scene.body import BODY_PARTS
from ...signals import Automation
from ..io.budget import Budget
from ..io.error import FormatError
from ..io.schema import validate
from ..io.strict_json import read_json
from .carrier import Carrier
from .transients import transient_carrier
from .vibration_file import Channel, VibrationFile
from .wavelet import WaveletBand

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

Keyframe = Mapping[str, Any]


def read(path: Path) -> VibrationFile:
    """The channels of all perceptions. Raises FormatError or OSError."""
    document = read_json(path)
    validate(document, "hjif", path)
    losses: dict[str, None] = {}
    budget = Budget(path, is_json=True)
    channels = []
    for p, perception in enumerate(document["perceptions"]):
        library = {
            effect["id"]: effect for effect in perception["effect_library"] if "id" in effect
        }
        unit = 10.0 ** perception.get("perception_unit_exponent", 0)
        for c, form in enumerate(perception["channels"]):
            reader = _ChannelReader(path, document["timescale"], library, losses, budget)
            channels.append(reader.channel(form, unit, f"/perceptions/{p}/channels/{c}"))
    return VibrationFile(tuple(channels), tuple(losses))


def _body_part(channel: Mapping[str, Any]) -> str:
    """The body part with this mask and target, or none."""
    place = channel["body_part_mask"], tuple(channel.get("body_part_target", ()))
    return next(
        (part.name for part in BODY_PARTS if (part.mpeg_mask, part.mpeg_target) == place), ""
    )


class _ChannelReader:
    def __init__(
        self,
        path: Path,
        timescale: int,
        library: Mapping[int, Any],
        losses: dict[str, None],
        budget: Budget,
    ) -> None:
        self.path, self.tick, self.library, self.losses, self.budget = (
            path,
            1 / timescale,
            library,
            losses,
            budget,
        )

    def channel(self, form: Mapping[str, Any], unit: float, place: str) -> Channel:
        gain = form["gain"] * unit
        carriers: list[Carrier] = []
        wavelets = []
        for b, band in enumerate(form["bands"]):
            effects = self._effects(band, f"{place}/bands/{b}")
            if band["band_type"] == "WaveletWave":
                wavelets.append(self._wavelet_band(band, list(effects), gain, f"{place}/bands/{b}"))
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
            else (None, 0.0)
        )
        return Channel(
            form["description"], duration, tuple(carriers), samples, rate, _body_part(form)
        )

    def _effects(self, band: Mapping[str, Any], place: str) -> Iterator[Mapping[str, Any]]:
        """The basis effects of a band, with references to the library resolved."""
        for e, form in enumerate(band["effects"]):
            effect = form
            if form["effect_type"] == "Reference":
                if form["id"] not in self.library:
                    raise FormatError(
                        self.path,
                        f"{place}/effects/{e}/id",
                        f"the effect library has no effect {form['id']}",
                    )
                effect = {**self.library[form["id"]], "position": form["position"]}
                self.budget.take(_KEY_BYTES * len(effect.get("keyframes", ())), place)
            if effect["effect_type"] == "Basis":
                yield self._clipped(effect)
            else:
                self.losses["composite effects are not read"] = None

    def _clipped(self, effect: Mapping[str, Any]) -> Mapping[str, Any]:
        """The effect with amplitudes within ±1, which the reference encoder exceeds."""
        name = "amplitude_modulation"
        keys = effect.get("keyframes", ())
        if all(abs(key.get(name, 0)) <= 1 for key in keys):
            return effect
        self.losses["amplitudes beyond 1 are clipped"] = None
        return {
            **effect,
            "keyframes": [
                {**key, name: min(max(key[name], -1), 1)} if name in key else key for key in keys
            ],
        }

    def _carriers(
        self, band: Mapping[str, Any], effect: Mapping[str, Any], gain: float
    ) -> Iterator[Carrier]:
        if band["band_type"] != "Curve":
            yield from carriers_of(band["band_type"], effect, self.tick, gain)
            return
        curve = band.get("curve_type", "Unknown")
        if curve not in ("Unknown", "Cubic", "Linear"):
            self.losses[f"{curve} curves are read as straight lines"] = None
        yield from _curve(effect, self.tick, gain, curve in ("Unknown", "Cubic"))

    def _wavelet_band(
        self, band: Mapping[str, Any], effects: Sequence[Mapping[str, Any]], gain: float, place: str
    ) -> WaveletBand:
        try:
            blocks = [
                (effect["position"] * self.tick, effect.get("wavelet_stream", ""))
                for effect in effects
            ]
            seconds, take = (
                band.get("block_length", 0) * self.tick,
                partial(self.budget.take, pointer=place),
            )
            return WaveletBand.decoded(blocks, seconds, band["upper_frequency_limit"], gain, take)
        except FormatError:
            raise
        except ValueError as error:
            raise FormatError(self.path, place, str(error)) from None


def carriers_of(
    kind: str, effect: Mapping[str, Any], tick: float, gain: float = 1.0
) -> Iterator[Carrier]:
    """The oscillations of a basis effect in a vectorial or transient band; ``tick``: seconds of a
    unit of time."""
    start, keyframes = effect["position"] * tick, effect.get("keyframes", [])
    amplitudes = _keys(keyframes, "amplitude_modulation", tick)
    if kind == "Transient":
        if amplitudes is not None:
            for time, strength in zip(*amplitudes, strict=True):
                yield transient_carrier(start + float(time), float(strength) * gain)
        return
    end = start + (keyframes[-1].get("relative_position", 0) * tick if keyframes else 0.0)
    if end <= start:
        return
    frequencies = _keys(keyframes, "frequency_modulation", tick)
    if frequencies is None:
        return
    wave, sign = _WAVES[effect.get("base_signal", "Sine")]
    times, values = (np.zeros(1), np.ones(1)) if amplitudes is None else _played(*amplitudes)
    for begin, until, phase in _phases(*frequencies, end - start):
        carrier = Carrier(
            start, end, 0.0, times, values * (sign * gain), *_played(*frequencies), wave
        )
        part = carrier if (begin, until) == (0.0, end - start) else carrier.part(begin, until)
        yield replace(part, phase=effect.get("phase", 0.0) + phase)


def _curve(
    effect: Mapping[str, Any], tick: float, gain: float, is_cubic: bool
) -> Iterator[Carrier]:
    """A curve is the vibration itself: an oscillation of frequency 0 at its crest. Cubic ones are
    level at each key."""
    start = effect["position"] * tick
    keys = _keys(effect.get("keyframes", []), "amplitude_modulation", tick)
    if keys is None:
        return
    times, values = _played(*keys)
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


def _keys(
    keyframes: Sequence[Keyframe], name: str, tick: float
) -> tuple[FloatArray, FloatArray] | None:
    """Times (seconds) and values of the keyframes that have this value."""
    keys = [keyframe for keyframe in keyframes if name in keyframe]
    if not keys:
        return None
    times = np.array([keyframe.get("relative_position", 0) for keyframe in keys], dtype=np.float64)
    return times * tick, np.array([keyframe[name] for keyframe in keys], dtype=np.float64)


def _played(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Keys with ascending times that reproduce the reference software's result if times decrease.

    It searches for the first key in the list at or after a time, and interpolates from the key
    before it in the list.
    """
    if (times[1:] >= times[:-1]).all():
        return times, values
    keys = [(float(times[0]), float(values[0]))]
    reached = float(times[0])
    for k in range(1, len(times)):
        if times[k] <= reached:
            continue
        if times[k - 1] < reached:
            share = (reached - times[k - 1]) / (times[k] - times[k - 1])
            keys.append((reached, float(values[k - 1] + share * (values[k] - values[k - 1]))))
        keys.append((float(times[k]), float(values[k])))
        reached = float(times[k])
    ordered, levels = np.array(keys).T
    return ordered, levels


def _phases(
    times: FloatArray, values: FloatArray, length: float
) -> Iterator[tuple[float, float, float]]:
    """Parts (begin, end) of an effect of ``length`` seconds with the phase (radians) at the
    beginning of each.

    There is one part unless times decrease. The reference software adds up the cycles between
    neighbours in the list, which may be negative, so that the phase jumps where it goes on from an
    earlier time.
    """
    if (times[1:] >= times[:-1]).all():
        yield 0.0, length, 0.0
        return
    cycles = np.concatenate(
        [[times[0] * values[0]], np.diff(times) * (values[1:] + values[:-1]) / 2]
    ).cumsum()
    begin, phase, reached = 0.0, 0.0, float(times[0])
    for k in range(1, len(times)):
        if times[k] <= reached:
            continue
        if times[k - 1] < reached and reached < length:
            yield begin, reached, phase
            begin = reached
            line = Automation(times[k - 1 : k + 1] - times[k - 1], values[k - 1 : k + 1])
            phase = (
                2
                * math.pi
                * float(cycles[k - 1] + line.integral(np.array([reached - times[k - 1]]))[0])
            )
        reached = float(times[k])
    yield begin, length, phase
