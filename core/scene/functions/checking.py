"""Checks of a designer's formula while it is being written: its faults and their places."""

from __future__ import annotations

import numpy as np

from ...frozen import frozen
from ...message import Cause, Message
from .expression import CONTACT_VARIABLES, ExpressionError, compile_expression

FARTHEST = 100.0
"""Largest distance at which a formula is evaluated [m]."""


@frozen
class Finding:
    """A fault of a formula: its ``message``, the 0-based ``column`` (None if unknown), and whether
    the formula is ``usable`` nevertheless."""

    message: Message
    column: int | None = None
    usable: bool = False


def check_expression(
    source: str, kappa: float, rho: float, epsilon: float, on_contact: bool = False
) -> Finding | None:
    """The first fault of a formula, or None. It is evaluated from 0 to `FARTHEST` metres.

    Args:
        source: the formula.
        kappa: of the object.
        rho: of the object.
        epsilon: of the scene.
        on_contact: it is that of a contact, so that area, depth, angle and force are available.
    """
    try:
        compiled = compile_expression(source)
    except ExpressionError as error:
        return Finding(error.message, error.column)
    if compiled.uses(*CONTACT_VARIABLES) and not on_contact:
        name = next(name for name in CONTACT_VARIABLES if compiled.uses(name))
        return Finding(
            Message.of(Cause.FORMULA_CONTACT_VARIABLE, name=name), source.index(name), usable=True
        )
    distance = np.concatenate([[0.0], np.geomspace(1e-3, FARTHEST, 200)])
    gains = compiled.evaluate(
        distance,
        {
            "kappa": kappa,
            "rho": rho,
            "epsilon": epsilon,
            "area": 0.01,
            "depth": 0.0,
            "angle": 0.0,
            "force": 1.0,
        },
    )
    for bad, cause in (
        (~np.isfinite(gains), Cause.FORMULA_NOT_FINITE),
        (gains < 0, Cause.FORMULA_NEGATIVE),
    ):
        if bad.any():
            return Finding(Message.of(cause, distance=f"{distance[bad][0]:.3g}"))
    if gains.max() > 1 + 1e-9:
        loudest = Message.of(
            Cause.FORMULA_AMPLIFIES,
            gain=f"{gains.max():.3g}",
            distance=f"{distance[gains.argmax()]:.3g}",
        )
        return Finding(loudest, usable=True)
    return None


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
