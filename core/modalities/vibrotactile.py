"""Vibration, the paper's modality: its sources have sampled signals, which `core.tracer` mixes and
renders."""

from __future__ import annotations

from ..scene.choices import Strategy
from ..scene.library import LibraryMaterial
from ..scene.values import Source
from .modality import Modality, lossless

VIBROTACTILE = Modality(
    name="vibrotactile",
    title="Vibration",
    description="Vibration that the skin feels between 20 and 1000 hertz",
    functions=("haptic_tracing", "identity", "constant", "linear", "exponential", "expression"),
    values=LibraryMaterial,
    source=Source,
    sampled=True,
    strategy=Strategy.AUTO,
    sensations=(),
    transmission=lossless,
)
