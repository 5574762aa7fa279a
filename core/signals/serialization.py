"""The JSON form of signals: {"signal": "sine", "frequency": 60, "amplitude": {"times": [...],
"values": [...]}}."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING

from .automation import Automation
from .base import Delay, Gain, Loop, Product, Sequence, Signal, Sum, json_fields
from .envelopes import Adsr, Constant, Decay, Keyed
from .impacts import DecayingSine, Impulse
from .noise import Noise
from .oscillators import Pulse, Saw, Sine, Square, Triangle
from .sampled import Sampled
from .struck import Struck

SIGNAL_KINDS: Mapping[str, type[Signal]] = {
    cls.kind: cls
    for cls in (
        Sine,
        Square,
        Triangle,
        Saw,
        Pulse,
        Noise,
        Constant,
        Adsr,
        Keyed,
        Decay,
        Impulse,
        DecayingSine,
        Sampled,
        Gain,
        Delay,
        Product,
        Sum,
        Sequence,
        Loop,
        Struck,
    )
}
"""The class of each `signal` name."""

MAX_NODES = 1000
MAX_DEPTH = 32
MAX_NUMBERS = 4_000_000


def signal_from_dict(data: object, pointer: str = "") -> Signal:
    """Return the signal whose JSON form is `data`.

    A form has at most 1,000 signals (cross-faded ones count twice), 32 levels, and 4,000,000
    numbers. Raises ValueError that names the place, a JSON pointer below `pointer`.
    """
    return _Reader().signal(data, pointer, 1, 1)


class _Reader:
    """Reads one form and counts its signals and numbers."""

    def __init__(self) -> None:
        self.nodes = 0
        self.numbers = 0

    def signal(self, data: object, pointer: str, depth: int, weight: int) -> Signal:
        self.nodes += weight
        if depth > MAX_DEPTH or self.nodes > MAX_NODES:
            raise ValueError(f"{pointer}: the signal is too complex")
        if not isinstance(data, dict):
            raise ValueError(f"{pointer}: must be an object")
        kind = data.get("signal")
        if not isinstance(kind, str) or kind not in SIGNAL_KINDS:
            raise ValueError(f"{pointer}/signal: must be one of {', '.join(SIGNAL_KINDS)}")
        cls = SIGNAL_KINDS[kind]
        known = json_fields(cls)
        unknown = sorted(str(key) for key in data.keys() - known.keys() - {"signal"})
        if unknown:
            raise ValueError(f"{pointer}/{unknown[0][:80]}: unknown key of {kind}")
        weight *= 2 if cls is Loop and data.get("crossfade", 0) != 0 else 1
        arguments = {}
        for key, entry in known.items():
            if key in data:
                arguments[entry.name] = self.value(data[key], f"{pointer}/{key}", depth, weight)
            elif entry.default is MISSING:
                raise ValueError(f"{pointer}/{key}: missing")
        try:
            return cls(**arguments)
        except ValueError as error:
            raise ValueError(f"{pointer}/{error}") from None

    def value(self, data: object, pointer: str, depth: int, weight: int) -> object:
        if isinstance(data, dict):
            return (
                self.signal(data, pointer, depth + 1, weight)
                if "signal" in data
                else self.automation(data, pointer)
            )
        if isinstance(data, list):
            if data and isinstance(data[0], dict):
                return tuple(
                    self.signal(part, f"{pointer}/{number}", depth + 1, weight)
                    for number, part in enumerate(data)
                )
            return self.column(data, pointer)
        return data

    def automation(self, data: dict[str, object], pointer: str) -> Automation:
        if data.keys() != {"times", "values"}:
            raise ValueError(f"{pointer}: must be a number or have times and values")
        columns = [self.column(data[name], f"{pointer}/{name}") for name in ("times", "values")]
        try:
            return Automation(columns[0], columns[1])
        except ValueError as error:
            raise ValueError(f"{pointer}/{error}") from None

    def column(self, data: object, pointer: str) -> list[float]:
        if not isinstance(data, list) or not all(
            isinstance(item, int | float) and not isinstance(item, bool) for item in data
        ):
            raise ValueError(f"{pointer}: must be a list of numbers")
        self.numbers += len(data)
        if self.numbers > MAX_NUMBERS:
            raise ValueError(f"{pointer}: the signal has more than {MAX_NUMBERS} numbers")
        return data
