"""Felt and masked sources of the watched listener, computed while the panel is visible."""

from __future__ import annotations

from bpy.types import Scene

from ...core.render.masking import FeltSources, felt_sources, shown_sounding
from ..session.derived import Derived, Latest
from ..session.sessions import Traced
from .watched import watched


def _felt(traced: Traced, listener: str, before: FeltSources | None = None) -> FeltSources | None:
    """Computed on the worker; None if the frame does not have that listener."""
    result = traced.result
    names = [item.name for item in result.listeners]
    return felt_sources(shown_sounding(result), names.index(listener), result.sample_rate) if listener in names else None


_FELT: Derived[str, FeltSources | None] = Derived(_felt)


def felt_at_watched(scene: Scene) -> Latest[FeltSources | None] | None:
    """The last result for the watched listener, without waiting."""
    listener = watched(scene)
    return _FELT.latest(scene, listener) if listener else None
