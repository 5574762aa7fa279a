"""The haptic graph as geometry."""

from __future__ import annotations


def register() -> None:
    pass


def unregister() -> None:
    pass
