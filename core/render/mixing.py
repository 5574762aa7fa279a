"""Mixing of the signals at one listener, within its ceiling s_max."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Literal

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from ..message import Cause, Message
from ..scene.functions import MIXING_VARIABLES, Finding
from ..scene.functions.expression import CompiledExpression, ExpressionError, compile_expression

CustomMixing = Callable[[FloatArray, FloatArray], FloatArray]
"""A designer's own method: signals, shape (n_signals, n), and their weights, shape (n_signals,), to
one signal, shape (n,)."""

MixingMethod = Literal["cumulative", "weighted", "strongest", "power"] | CustomMixing


@frozen
class MixingExpression:
    """A designer's formula over `MIXING_VARIABLES` as a mixing method, such as ``s_max * tanh(sum /
    s_max)``.

    Raises ExpressionError, a ValueError, for a rejected formula.
    """

    expression: str
    s_max: float = 1.0

    def __post_init__(self) -> None:
        _compiled(self.expression)

    def __call__(self, signals: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the formula's value at every sample, shape (n,); 0 if that is not finite."""
        mix = _compiled(self.expression).evaluate(
            np.zeros(signals.shape[1]), _values(signals, weights, self.s_max)
        )
        return np.where(np.isfinite(mix), mix, 0.0)


@lru_cache(maxsize=256)
def _compiled(expression: str) -> CompiledExpression:
    return compile_expression(expression, MIXING_VARIABLES)


def _values(
    signals: FloatArray, weights: FloatArray, s_max: float
) -> dict[str, float | FloatArray]:
    """Return the values of `MIXING_VARIABLES`."""
    mixes = (method(signals, weights) for method in METHODS.values())
    return dict(zip(MIXING_VARIABLES, (*mixes, s_max), strict=True))


def check_mixing(expression: str, s_max: float = 1.0) -> Finding | None:
    """Return the fault of a mixing formula, or None. It is evaluated for sums of two tones, and for
    silence."""
    try:
        compiled = _compiled(expression)
    except ExpressionError as error:
        return Finding(error.message, error.column)
    tones = np.sin(2.0 * np.pi * np.outer([3.0, 7.0], np.arange(200) / 200.0)) * np.array(
        [[1.0], [0.5]]
    )
    bad = ~np.isfinite(compiled.evaluate(np.zeros(200), _values(tones, np.ones(2), s_max)))
    if bad.any():
        return Finding(
            Message.of(Cause.MIX_NOT_FINITE, sum=f"{cumulative(tones)[bad][0]:.3g}"), usable=True
        )
    silence = {**dict.fromkeys(MIXING_VARIABLES, 0.0), "s_max": s_max}
    rest = float(compiled.evaluate(np.zeros(1), silence)[0])
    if math.isfinite(rest) and rest != 0.0:
        return Finding(Message.of(Cause.MIX_NOT_SILENT, value=f"{rest:.3g}"), usable=True)
    return None


def cumulative(signals: FloatArray) -> FloatArray:
    """Return the sum over `signals`, shape (n_signals, n); shape (n,)."""
    return np.asarray(signals.sum(axis=0))


def weighted(signals: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the sum over `signals` times their priorities `weights`, shape (n_signals,)."""
    return np.asarray(np.einsum("v,vn->n", weights, signals))


def strongest(signals: FloatArray) -> FloatArray:
    """Return, sample by sample, the signal of the greatest magnitude (the first of equals);
    signals: (n_signals, ...).

    The result jumps when a signal of the opposite sign becomes the strongest, so this suits sources
    of which one masks the rest.
    """
    if not len(signals):
        return np.zeros(signals.shape[1:])
    highest = signals.max(axis=0)
    lowest = signals.min(axis=0)
    result = np.where(highest >= -lowest, highest, lowest)
    tied = (highest == -lowest) & (highest > 0.0)
    if tied.any():
        among = signals[:, tied]
        result[tied] = among[np.argmax(np.abs(among), axis=0), np.arange(among.shape[1])]
    return np.asarray(result)


def power(signals: FloatArray) -> FloatArray:
    """Return the root of the sum of squares with the sign of the sum (+ where the sum is 0);
    signals: (n_signals, ...).

    Incoherent vibrations add up in power: at least the strongest, at most the sum of their
    magnitudes. A single signal is unchanged; where several cancel, the result changes sign at full
    amplitude.
    """
    return np.asarray(
        np.copysign(
            np.sqrt(np.einsum("i...,i...->...", signals, signals)), signals.sum(axis=0) + 0.0
        )
    )


METHODS: Mapping[str, CustomMixing] = {
    "cumulative": lambda signals, weights: cumulative(signals),
    "weighted": weighted,
    "strongest": lambda signals, weights: strongest(signals),
    "power": lambda signals, weights: power(signals),
}
"""The methods by name, in the order of their `MIXING_VARIABLES`."""


def saturated(total: FloatArray, s_max: float | FloatArray) -> FloatArray:
    """Return `total` where its magnitude is at most s_max, else s_max with its sign."""
    return np.clip(total, -s_max, s_max)


def checked_method(method: str) -> str:
    """Return the name of a method. Raises ValueError for an unknown one."""
    if method not in METHODS:
        raise ValueError(f"method: unknown mixing method {method!r}")
    return method


def mixed(method: MixingMethod, signals: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the mix of `signals`, shape (n_signals, n), by `method`, without a limit; silence if
    there are none.

    `strongest` and `power` take further dimensions, (n_signals, ...), at once.

    Raises ValueError if a custom method returns another shape or values that are not finite.
    """
    if not len(signals):
        return np.zeros(signals.shape[1:])
    if not callable(method):
        return METHODS[checked_method(method)](signals, weights)
    mix = np.asarray(method(signals, weights), dtype=np.float64)
    if mix.shape != signals.shape[1:]:
        raise ValueError(f"method: returned shape {mix.shape} for {signals.shape[1]} samples")
    if not np.isfinite(mix).all():
        raise ValueError("method: returned a sample that is not finite")
    return mix
