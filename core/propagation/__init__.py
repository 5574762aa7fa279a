"""Propagation: from the haptic graph to the gain of every source at every listener."""

from .result import Propagation

__all__ = ["Propagation"]
