"""Actuators, as the configuration files (ACF) of ``.haptic`` describe them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.error import FormatError
from ...core.formats.io.strict_json import parse_json, read_bytes
from ...core.forms import JsonObject
from ...core.frozen import frozen
from ..keyframes.carrier import Carrier
from ..keyframes.files import without_trailing_commas
from .json5 import as_json

DUCKING = 0.5
"""Factor of the continuous signal while an emphasis sounds."""
_SHAPES = "sine", "square"
_MOST = 20_000
"""Largest number of a file that is taken."""


@frozen
class Actuator:
    """What an actuator plays.

    low, high: frequencies [Hz] of the values 0 and 1 of the continuous signal. dull, sharp:
    frequency [Hz] and duration [ms] of an emphasis of frequency 0, a sine, and of 1, a square;
    between them frequency, duration and wave are mixed linearly.
    """

    low: float
    high: float
    dull: tuple[float, float]
    sharp: tuple[float, float]

    def sharpness(self, frequency: float) -> float:
        """The emphasis frequency, from 0 to 1, that plays a frequency (hertz)."""
        low, high = self.dull[0], self.sharp[0]
        return min(max((frequency - low) / (high - low), 0.0), 1.0)

    def burst_form(self, frequency: float) -> tuple[float, float]:
        """Seconds of the burst of an emphasis, and its power at amplitude 1, by frequency
        (hertz)."""
        sharpness = self.sharpness(frequency)
        return float(self.seconds(np.asarray(sharpness))), power(sharpness)

    def seconds(self, sharpness: FloatArray) -> FloatArray:
        """Duration of emphases of frequencies from 0 to 1."""
        long, short = self.dull[1], self.sharp[1]
        return np.asarray((long + (short - long) * sharpness) / 1000)

    def emphasis(
        self, begin: float, end: float, amplitude: float, frequency: float
    ) -> Iterator[Carrier]:
        """The waves of an emphasis: a sine that fades into a square as its frequency, from 0 to 1,
        rises."""
        low, high = self.dull[0], self.sharp[0]
        zero, hertz = np.zeros(1), np.full(1, low + (high - low) * frequency)
        for wave, share in zip(_SHAPES, (1 - frequency, frequency), strict=True):
            if share * amplitude > 0 and end > begin:
                level = np.full(1, share * amplitude)
                yield Carrier(begin, end, 0.0, zero, level, zero, hertz, wave)

    def configuration(self) -> JsonObject:
        """The parts of its file that renderers use."""
        ends = zip(
            ("frequency_min", "frequency_max"), (self.dull, self.sharp), _SHAPES, strict=True
        )
        emphasis = {
            key: {"output_frequency": frequency, "duration_ms": milliseconds, "shape": shape}
            for key, (frequency, milliseconds), shape in ends
        }
        return {
            "continuous": {
                "gain": 1.0,
                "emphasis_ducking": DUCKING,
                "frequency_min": self.low,
                "frequency_max": self.high,
            },
            "emphasis": {"gain": 1.0, "fade_out_percent": 0.0, **emphasis},
        }


ACTUATORS = {
    "quest": Actuator(55.0, 200.0, (55.0, 36.4), (165.0, 12.1)),
    "voice_coil": Actuator(20.0, 250.0, (55.0, 27.0), (130.0, 20.0)),
}
"""Those of MetaQuest.acf and Generic-Console-PCM.acf in Meta's haptics SDK (resources/acf)."""
_QUEST = ACTUATORS["quest"]


def actuator_beside(path: Path, losses: dict[str, None]) -> Actuator:
    """That of the ``.acf`` beside a clip; what the file does not give is that of Quest
    controllers."""
    beside = path.with_suffix(".acf")
    if not beside.is_file():
        losses["there is no .acf beside the file: frequencies are those of Quest controllers"] = (
            None
        )
        return _QUEST
    try:
        text = as_json(read_bytes(beside).decode("utf-8", "replace"))
        configuration = parse_json(without_trailing_commas(text.encode()), beside)
    except FormatError as error:
        losses[f"{beside.name} is not used: {error.reason}"] = None
        return _QUEST
    span = _numbers(configuration, ("continuous",), "frequency_min", "frequency_max")
    if span is None or span[0] > span[1]:
        losses[
            f"{beside.name} gives no range of frequencies: they are those of Quest controllers"
        ] = None
        return _QUEST
    dull, sharp = (
        _numbers(configuration, ("emphasis", key), "output_frequency", "duration_ms")
        for key in ("frequency_min", "frequency_max")
    )
    return Actuator(*span, dull or _QUEST.dull, sharp or _QUEST.sharp)


def _numbers(value: object, place: tuple[str, ...], *keys: str) -> tuple[float, float] | None:
    """Two numbers above 0 of the object at a place; None if they are not there."""
    for key in place:
        value = value.get(key) if isinstance(value, dict) else None
    first, second = (value.get(key) if isinstance(value, dict) else None for key in keys)
    if not isinstance(first, int | float) or not isinstance(second, int | float):
        return None
    is_taken = 0 < first <= _MOST and 0 < second <= _MOST
    return (float(first), float(second)) if is_taken else None


def power(sharpness: float) -> float:
    """Mean square of an emphasis of amplitude 1: of ``(1 - s) sin + s sgn(sin)``."""
    sine, square = 1 - sharpness, sharpness
    return sine**2 / 2 + 4 / math.pi * sine * square + square**2
