"""The front door of the package: scenes from files or dictionaries, their gains, and runs that
answer poses with levels and samples."""

from __future__ import annotations

from ..formats.io.error import FormatError
from ..formats.registry import read
from .result import Pair, Result
from .run import Run
from .scene import Scene, load, loads
from .step import Step

__all__ = ["FormatError", "Pair", "Result", "Run", "Scene", "Step", "load", "loads", "open", "read"]


def open(scene: Scene, sample_rate: float = 8000.0) -> Run:
    """A run of ``scene``, whose samples have ``sample_rate``, from 100 to 192,000 Hz. Raises
    ValueError.

    >>> run = open(Scene(objects=[{"name": "bench", "kappa": 0.1, "rho": 0.8}]))
    >>> run.objects
    ('bench',)
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"open: expected a Scene, as load(path) gives, not {scene!r:.60}")
    return Run(scene.content, sample_rate)
