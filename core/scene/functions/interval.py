"""Interval arithmetic: guaranteed bounds of a formula over ranges of its variables.

Ends are widened by one unit in the last place per operation, so that the true range always lies
inside. Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, *Introduction to Interval Analysis*, SIAM
2009, doi 10.1137/1.9780898717716.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Interval:
    """All real numbers from ``low`` to ``high``; the ends may be infinite."""

    low: float
    high: float


ENTIRE = Interval(-math.inf, math.inf)


def outward(low: float, high: float) -> Interval:
    """The interval widened for rounding; an end that is NaN becomes infinite."""
    return Interval(
        -math.inf if math.isnan(low) else math.nextafter(low, -math.inf),
        math.inf if math.isnan(high) else math.nextafter(high, math.inf),
    )


def add(a: Interval, b: Interval) -> Interval:
    return outward(a.low + b.low, a.high + b.high)


def subtract(a: Interval, b: Interval) -> Interval:
    return outward(a.low - b.high, a.high - b.low)


def multiply(a: Interval, b: Interval) -> Interval:
    corners = [_product(x, y) for x in (a.low, a.high) for y in (b.low, b.high)]
    return outward(min(corners), max(corners))


def _product(x: float, y: float) -> float:
    # 0 * inf is 0 here: the end is approached, never reached.
    return 0.0 if x == 0 or y == 0 else x * y


def divide(a: Interval, b: Interval) -> Interval:
    if b.low <= 0 <= b.high:
        return ENTIRE
    return multiply(a, outward(1 / b.low, 1 / b.high))


def logarithm(x: float) -> float:
    return math.log(x) if x > 0 else -math.inf


def power(a: Interval, b: Interval) -> Interval:
    if b.low == b.high and b.low == int(b.low) and abs(b.low) <= 64:
        return _integer_power(a, int(b.low))
    if a.low < 0:
        return ENTIRE
    return monotone(math.exp)(multiply(b, monotone(logarithm)(a)))


def _integer_power(a: Interval, n: int) -> Interval:
    if n < 0:
        return divide(Interval(1.0, 1.0), _integer_power(a, -n))
    if n == 0:
        return Interval(1.0, 1.0)
    ends = sorted((_finite_power(a.low, n), _finite_power(a.high, n)))
    if n % 2 == 0 and a.low <= 0 <= a.high:
        return outward(0.0, ends[1])
    return outward(ends[0], ends[1])


def _finite_power(x: float, n: int) -> float:
    try:
        return x**n
    except OverflowError:
        return math.inf if x > 0 or n % 2 == 0 else -math.inf


def monotone(function: Callable[[float], float]) -> Callable[[Interval], Interval]:
    """The interval version of an increasing function; outside its domain the end is infinite."""

    def end(x: float, overflow: float) -> float:
        try:
            return function(x)
        except OverflowError:
            return math.inf
        except ValueError:
            return overflow

    def apply(a: Interval) -> Interval:
        result = outward(end(a.low, -math.inf), end(a.high, math.inf))
        # The mathematical functions are accurate to one unit in the last place, not half.
        return outward(result.low, result.high)

    return apply


def absolute(a: Interval) -> Interval:
    if a.low >= 0:
        return a
    return Interval(0.0 if a.high >= 0 else -a.high, max(-a.low, a.high))


def minimum(a: Interval, b: Interval) -> Interval:
    return Interval(min(a.low, b.low), min(a.high, b.high))


def maximum(a: Interval, b: Interval) -> Interval:
    return Interval(max(a.low, b.low), max(a.high, b.high))


def within_unit(_: Interval) -> Interval:
    """Bounds of sine and cosine for any argument."""
    return Interval(-1.0, 1.0)
