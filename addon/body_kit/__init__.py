"""The body kit: listeners on the parts of a body, whatever its armature calls its bones."""

from __future__ import annotations


def register() -> None:
    """Offer the operators."""
    from . import operators

    operators.register()


def unregister() -> None:
    """Take them away."""
    from . import operators

    operators.unregister()
