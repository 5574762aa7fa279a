"""Checks of a designer's formula, where it is typed or read: its faults and their places."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from ...frozen import frozen
from ...message import Cause, Message, sentence
from .expression import CONTACT_VARIABLES, ExpressionError, compile_expression
from .modulation import Expression, ModulationFunction

_DISTANCES = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 64)])
"""At which a formula is evaluated [m]."""
_ROUNDING = 1e-9


@frozen
class Finding:
    """A fault of a formula: its ``message``, the 0-based ``column`` (None if unknown), and whether
    the formula is ``usable`` nevertheless."""

    message: Message
    column: int | None = None
    usable: bool = False


@lru_cache(maxsize=256)
def check_expression(source: str, on_contact: bool = False) -> Finding | None:
    """The first fault of a formula, or None. It is evaluated from 1 mm to 1 km, for the least and
    the greatest kappa and rho: a gain is from 0 to 1, and that of an object does not rise with
    distance. ``on_contact``: it is that of a contact, so that area, depth, angle and force are
    available."""
    try:
        compiled = compile_expression(source)
    except ExpressionError as error:
        return Finding(error.message, error.column)
    for kappa, rho in itertools.product((0.0, 1.0), repeat=2):
        values = {"kappa": kappa, "rho": rho, "epsilon": 0.1, "force": 1.0}
        values |= {"area": 0.01 if on_contact else 0.0, "depth": 0.0, "angle": 0.0}
        gains = compiled.evaluate(_DISTANCES, values)
        rises = np.append(False, gains[1:] > gains[:-1] + _ROUNDING) & (not on_contact)
        for bad, cause in (
            (~np.isfinite(gains), Cause.FORMULA_NOT_FINITE),
            (gains < -_ROUNDING, Cause.FORMULA_NEGATIVE),
            (gains > 1 + _ROUNDING, Cause.FORMULA_AMPLIFIES),
            (rises, Cause.FORMULA_RISES),
        ):
            if bad.any():
                return Finding(
                    Message.of(
                        cause,
                        gain=f"{gains[bad][0]:.3g}",
                        distance=f"{_DISTANCES[bad][0]:.3g}",
                        kappa=f"{kappa:g}",
                        rho=f"{rho:g}",
                    )
                )
    if compiled.uses(*CONTACT_VARIABLES) and not on_contact:
        name = next(name for name in CONTACT_VARIABLES if compiled.uses(name))
        return Finding(
            Message.of(Cause.FORMULA_CONTACT_VARIABLE, name=name), source.index(name), usable=True
        )
    return None


def require_gains(function: ModulationFunction, on_contact: bool = False) -> None:
    """Raise ValueError that says why the formula of a function is not usable."""
    if isinstance(function, Expression):
        found = check_expression(function.expression, on_contact)
        if found is not None and not found.usable:
            raise ValueError(f"expression: {function.expression!r}: {sentence(found.message)}")


def excerpt(source: str, column: int, width: int = 36) -> tuple[str, int]:
    """At most ``width`` characters of a formula around a column, and the column's place in the
    excerpt; ``…`` replaces omitted text."""
    if len(source) <= width:
        return source, min(column, len(source))
    first = min(max(0, column - width // 2), len(source) - width)
    shown = source[first : first + width]
    if first > 0:
        shown = "…" + shown[1:]
    if first + width < len(source):
        shown = shown[:-1] + "…"
    return shown, column - first
