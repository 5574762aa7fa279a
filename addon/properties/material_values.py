"""Properties that haptic materials and their objects share; each user adds its own options."""

from __future__ import annotations

from typing import Any

from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty

from ...core.scene.bands import BAND_COUNT
from .kinds import number, share, switch

NAMES = ("kappa", "rho", "wave_speed", "use_bands", "band_decays", "conductivity")


def kappa(**more: Any) -> FloatProperty:
    """The property κ; ``more``: its options."""
    return share(
        "Kappa (κ)",
        "A higher κ passes on less, but over a longer distance; 1 passes on nothing. The paper's transmissibility: as its "
        "function is published, only (1 - κ) ρ counts",
        0.1,
        precision=3,
        **more,
    )


def rho(**more: Any) -> FloatProperty:
    """The property ρ."""
    return share(
        "Rho (ρ)",
        "A higher ρ passes on more but fades faster with distance; 0 passes on nothing. The paper's density coefficient",
        0.9,
        precision=3,
        **more,
    )


def wave_speed(**more: Any) -> FloatProperty:
    """The speed of waves [m/s]."""
    return number(
        "Wave Speed", "Speed of vibration in this material; 0 passes signals on without delay", 0.0, (0.0, 5000.0), unit="VELOCITY", **more
    )


def use_bands(**more: Any) -> BoolProperty:
    """Whether frequency bands are attenuated differently."""
    return switch("Frequency Bands", "Attenuate each frequency band by its own value per metre", **more)


def band_decays(**more: Any) -> FloatVectorProperty:
    """The extra attenuation of each frequency band [1/m]."""
    return FloatVectorProperty(
        name="Band Attenuation",
        description="Extra attenuation per metre in this band of frequencies; 0 adds none",
        size=BAND_COUNT,
        default=(0.0,) * BAND_COUNT,
        min=0.0,
        soft_max=5.0,
        precision=3,
        **more,
    )
