"""Meters: how much each listener feels, in the viewport and in the panel, why one feels nothing, and the four renderings compared."""

from __future__ import annotations


def register() -> None:
    """Start drawing, and offer the operators."""
    from . import draw, operators

    operators.register()
    draw.register()


def unregister() -> None:
    """Stop drawing."""
    from . import draw, explanation, operators, pictures

    draw.unregister()
    pictures.forget()
    operators.unregister()
    explanation.forget()
