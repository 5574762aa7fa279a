"""Looks at a designer's formula while it is written: what is wrong, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .expression import ExpressionError, compile_expression

REACH = 100.0
"""Metres over which a formula is tried."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What a formula has: the words, its 0-based ``column`` or None where it has no place, and whether it can be used all the same."""

    message: str
    column: int | None = None
    usable: bool = False


def check_expression(source: str, kappa: float, rho: float, epsilon: float, on_contact: bool = False) -> Finding | None:
    """What is wrong with a formula for these properties, or None. It is tried from 0 to `REACH` metres.

    ``on_contact``: it is of a contact, which has area, depth and angle; an object has none.
    """
    try:
        compiled = compile_expression(source)
    except ExpressionError as error:
        return Finding(error.reason, error.column)
    if compiled.uses_contact and not on_contact:
        name = next(name for name in ("area", "depth", "angle") if name in source)
        return Finding(f"{name} is 0 inside an object: only a contact has one", source.index(name), usable=True)
    distance = np.concatenate([[0.0], np.geomspace(1e-3, REACH, 200)])
    gains = compiled.evaluate(distance, {"kappa": kappa, "rho": rho, "epsilon": epsilon, "area": 0.01, "depth": 0.0, "angle": 0.0})
    for bad, message in (
        (~np.isfinite(gains), "no finite value at {} m; divided by zero?"),
        (gains < 0, "negative at {} m; a gain is 0 or more"),
    ):
        if bad.any():
            return Finding(message.format(f"{distance[bad][0]:.3g}"))
    if gains.max() > 1 + 1e-9:
        return Finding(f"amplifies: the gain is {gains.max():.3g} at {distance[gains.argmax()]:.3g} m", usable=True)
    return None


def excerpt(source: str, column: int, width: int = 36) -> tuple[str, int]:
    """At most ``width`` characters of a formula around a column, and where the column is in them; ``…`` stands for what is left out."""
    if len(source) <= width:
        return source, min(column, len(source))
    first = min(max(0, column - width // 2), len(source) - width)
    shown = source[first : first + width]
    if first > 0:
        shown = "…" + shown[1:]
    if first + width < len(source):
        shown = shown[:-1] + "…"
    return shown, column - first
