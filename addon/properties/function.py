"""Properties of a modulation function: which one, and its parameters."""

from __future__ import annotations

from bpy.props import EnumProperty, FloatProperty, StringProperty

from .callbacks import edited

FUNCTIONS = {
    "identity": ("Identity", "Passes everything on unchanged"),
    "constant": ("Constant", "The same gain over any distance"),
    "linear": ("Linear", "1 - d / range: silent from the range on"),
    "exponential": ("Exponential", "e^(-α d): fades with distance alone"),
    "haptic_tracing": ("Haptic Tracing", "K e^(-max(K, ε) d) with K = (1 - κ) ρ: fades with distance as the two properties say"),
    "expression": ("Expression", "Your own formula of x, d, kappa, rho, epsilon"),
    "physical": ("Physical", "Spreads and fades as measured materials do, by loss factor, wave speed and kind of wave"),
    "conduction": ("Conduction", "e^(-m d) with m = √(2 h / (k t)): fades as heat does that leaks into the air on its way"),
}
"""Title and description of each function of the core, by its name. Files hold a choice by its place in this order."""

VIBRATION_FUNCTIONS = tuple(name for name in FUNCTIONS if name != "conduction")
"""Those that vibration can pass through."""

PARAMETERS = {
    "exponential": {"alpha": "alpha"},
    "linear": {"range": "range"},
    "constant": {"gain": "constant"},
    "expression": {"expression": "expression"},
    "physical": {
        "wave": "wave",
        "loss_factor": "loss_factor",
        "phase_speed": "phase_speed",
        "thickness": "plate_thickness",
        "absorption": "absorption",
        "material_k": "material_k",
        "reference_distance": "reference_distance",
        "extent": "extent",
    },
}
"""Which properties are the parameters of which function, by their names in the core."""


def function_property(names: tuple[str, ...], default: str) -> EnumProperty:
    """The choice of one of the functions ``names``."""
    return EnumProperty(
        name="Function",
        description="How the signal fades on its way through",
        items=tuple((name, *FUNCTIONS[name]) for name in names),
        default=default,
        update=edited("function"),
    )


class FunctionParameters:
    """Mixin: the parameters of the functions that have some."""

    alpha: FloatProperty(
        name="Alpha (1/m)",
        description="Attenuation per metre; 0.2 is the paper's distance-only function",
        default=0.2,
        min=0.0,
        soft_max=5.0,
        precision=3,
        update=edited("alpha"),
    )
    range: FloatProperty(
        name="Range",
        description="Distance from which on nothing is felt",
        default=10.0,
        min=0.001,
        soft_max=100.0,
        unit="LENGTH",
        update=edited("range"),
    )
    constant: FloatProperty(
        name="Gain", description="The gain over any distance", default=0.5, min=0.0, max=1.0, subtype="FACTOR", update=edited("constant")
    )
    expression: StringProperty(
        name="Expression",
        description="Formula of x (the signal), d (metres), kappa, rho, epsilon. "
        "Functions: exp, log, sqrt, tanh, atan, sin, cos, abs, min, max, where",
        default="x * exp(-0.2 * d)",
        maxlen=500,
        update=edited("expression"),
    )
