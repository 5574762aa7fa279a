"""The properties of a modulation function: which one, and its parameters."""

from __future__ import annotations

from bpy.props import FloatProperty, StringProperty
from bpy.types import Context, PropertyGroup

from ..changes.revisions import mark_changed

FUNCTION_ITEMS = (
    ("haptic_tracing", "Haptic Tracing", "K e^(-max(K, ε) d) with K = (1 - κ) ρ: fades with distance as the two properties say"),
    ("exponential", "Exponential", "e^(-α d): fades with distance alone"),
    ("linear", "Linear", "1 - d / range: silent from the range on"),
    ("constant", "Constant", "The same gain over any distance"),
    ("identity", "Identity", "Passes everything on unchanged"),
    ("expression", "Expression", "Your own formula of x, d, kappa, rho, epsilon"),
    ("conduction", "Conduction", "e^(-m d) with m = √(2 h / (k t)): fades as heat does that leaks into the air on its way"),
)
FUNCTION_TITLES = {name: (title, description) for name, title, description in FUNCTION_ITEMS}

# Which properties are the parameters of which function, and their names in the core.
PARAMETERS = {
    "exponential": {"alpha": "alpha"},
    "linear": {"range": "range"},
    "constant": {"gain": "constant"},
    "expression": {"expression": "expression"},
}


def changed(self: PropertyGroup, context: Context) -> None:
    """An author changed what is traced."""
    mark_changed()


class FunctionParameters:
    """Mixin: the parameters of the functions that have some."""

    alpha: FloatProperty(
        name="Alpha",
        description="Attenuation per metre; 0.2 is the paper's distance-only function",
        default=0.2,
        min=0.0,
        soft_max=5.0,
        precision=3,
        update=changed,
    )
    range: FloatProperty(
        name="Range",
        description="Distance from which on nothing is felt",
        default=10.0,
        min=0.001,
        soft_max=100.0,
        unit="LENGTH",
        update=changed,
    )
    constant: FloatProperty(
        name="Gain", description="The gain over any distance", default=0.5, min=0.0, max=1.0, subtype="FACTOR", update=changed
    )
    expression: StringProperty(
        name="Expression",
        description="Formula of x (the signal), d (metres), kappa, rho, epsilon. "
        "Functions: exp, log, sqrt, tanh, atan, sin, cos, abs, min, max, where",
        default="x * exp(-0.2 * d)",
        maxlen=500,
        update=changed,
    )
