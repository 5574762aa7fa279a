"""Vibration, the paper's modality: its sources have sampled signals, which `core.tracer` mixes and renders."""

from __future__ import annotations

from ..scene.choices import Strategy
from .modality import Modality, Quantity, lossless

VIBROTACTILE = Modality(
    name="vibrotactile",
    title="Vibration",
    description="Vibration that the skin feels between 20 and 1000 hertz",
    functions=("haptic_tracing", "identity", "constant", "linear", "exponential", "expression"),
    object_values=(
        Quantity("kappa", "Kappa (κ)", "The paper's transmissibility", "", 0.1, 0.0, 1.0),
        Quantity("rho", "Rho (ρ)", "The paper's density coefficient", "", 0.9, 0.0, 1.0),
        Quantity("wave_speed", "Wave Speed", "Speed of vibration in the material", "m/s", 0.0, 0.0, 20000.0),
    ),
    source_value=Quantity("amplitude", "Amplitude", "Strength of the emitted signal", "", 1.0, 0.0, 1.0),
    sampled=True,
    strategy=Strategy.AUTO,
    sensations=(),
    transmission=lossless,
)
