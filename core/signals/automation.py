"""Automation of parameters: piecewise linear functions of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..declaration import Number, declare
from ..forms import JsonObject
from ..frozen import frozen
from .limits import MAX_SECONDS, checked_column


class Automation:
    """A value keyed over time, linear between the keys and constant before the first and after the
    last.

    times: seconds, shape (n,), n >= 1, never decreasing; two keys at one time are a jump (the later
    one holds from that time on). values: shape (n,), finite. Raises ValueError that names the
    argument.
    """

    __slots__ = "_areas", "_origin", "_slopes", "times", "values"

    def __init__(
        self, times: Sequence[float] | FloatArray, values: Sequence[float] | FloatArray
    ) -> None:
        self.times: FloatArray = checked_column("times", times, MAX_SECONDS)
        self.values: FloatArray = checked_column("values", values, 1e9)
        if len(self.times) != len(self.values):
            raise ValueError(f"values: {len(self.values)} for {len(self.times)} times")
        widths = np.diff(self.times)
        if np.any(widths < 0):
            raise ValueError("times: must not decrease")
        rises = np.diff(self.values)
        # No time lies within a jump or within a segment so short that its slope overflows.
        steps = widths > 1e-12
        self._slopes = np.append(
            np.divide(rises, widths, out=np.zeros_like(rises), where=steps), 0.0
        )
        self._areas = np.append(0.0, np.cumsum(widths * (self.values[:-1] + self.values[1:]) / 2))
        self._origin = 0.0
        self._origin = float(self.integral(np.zeros(1))[0])

    def at(self, times: FloatArray) -> FloatArray:
        """Return the values at `times` (seconds, any shape)."""
        key = self._followed(times)
        value = self.values[key]
        slope = self._slopes[key]
        if isinstance(key, int) and slope == 0.0:
            return np.full(np.shape(times), value)
        return np.asarray(value + slope * np.maximum(times - self.times[key], 0.0))

    def integral(self, times: FloatArray) -> FloatArray:
        """Return the integral from 0 to each of `times`, exact for straight lines."""
        key = self._followed(times)
        since = times - self.times[key]
        rate = self.values[key] + np.maximum(since, 0.0) * self._slopes[key] / 2
        return np.asarray(self._areas[key] + since * rate - self._origin)

    def _followed(self, times: FloatArray) -> int | NDArray[np.intp]:
        """Return the number of the key that each of `times` follows, one number where all follow
        the same."""
        if len(self.times) == 1:
            return 0
        if np.size(times):
            first, last = np.searchsorted(
                self.times, (times.min(), times.max()), side="right"
            ).tolist()
            if max(first, 1) == max(last, 1):
                return int(max(first - 1, 0))
        return np.maximum(np.searchsorted(self.times, times, side="right") - 1, 0)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Automation):
            return NotImplemented
        return self is other or (
            np.array_equal(self.times, other.times) and np.array_equal(self.values, other.values)
        )

    def __hash__(self) -> int:
        return hash((self.times.tobytes(), self.values.tobytes()))

    def __repr__(self) -> str:
        return f"Automation({self.times.tolist()}, {self.values.tolist()})"


def ramp(start: float, end: float, duration: float) -> Automation:
    """Return the automation from `start` to `end` within `duration` seconds (> 0), constant
    afterwards."""
    return Automation((0.0, duration), (start, end))


@frozen(kw_only=True)
class Parameter(Number):
    """A parameter of a signal: a number; infinite, too, where it is optional; where it is
    ``keyed``, also an automation."""

    keyed: bool = False

    def checked(self, value: Any) -> Any:
        if self.keyed and isinstance(value, Automation):
            for end in (value.values.min(), value.values.max()):
                Number.checked(self, float(end))
            return value
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(f"must be a number, not {type(value).__name__}")
        if self.optional and value == math.inf:
            return value
        number = Number.checked(self, value)
        return number if self.whole else float(number)

    def schema(self) -> JsonObject:
        return {"$ref": "#/$defs/parameter"} if self.keyed else Number.schema(self)


def parameter(default: Any, about: str, low: float, high: float, **more: Any) -> Any:
    """The field of a parameter from `low` to `high`; `about`: what it is, for the JSON Schema."""
    return declare(default, Parameter(about=about, low=low, high=high, **more))


def largest(parameter: float | Automation) -> float:
    """Return the largest magnitude that a number or an automation takes."""
    return (
        float(np.max(np.abs(parameter.values)))
        if isinstance(parameter, Automation)
        else abs(parameter)
    )


def values_of(parameter: float | Automation, times: FloatArray) -> float | FloatArray:
    """Return a number as it is, or an automation's values at `times`."""
    return parameter.at(times) if isinstance(parameter, Automation) else parameter
