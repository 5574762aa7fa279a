"""Properties of modulation functions: their kinds and their parameters."""

from __future__ import annotations

from bpy.props import EnumProperty

from ...core.scene.functions import (
    FUNCTIONS,
    Constant,
    Exponential,
    Expression,
    Linear,
    NormalForce,
    Resilient,
)
from ...core.scene.functions import TRANSMISSIONS as ALL_FUNCTIONS
from .declared import holding, items_of
from .kinds import choice

VIBRATION_FUNCTIONS = tuple(FUNCTIONS)
"""Functions of haptic objects."""
TRANSMISSIONS = (
    "impedance",
    "identity",
    "constant",
    "linear",
    "exponential",
    "expression",
    "resilient",
    "normal_force",
)
"""Functions of contacts."""


def function_property(names: tuple[str, ...], default: str) -> EnumProperty:
    """The choice of one of the functions ``names``."""
    items = items_of(
        {name: (ALL_FUNCTIONS[name].label, ALL_FUNCTIONS[name].about) for name in names}
    )
    return choice("Function", "How the signal fades on its way through", items, default=default)


@holding(Expression)
@holding(Constant, gain_value="constant")
@holding(Linear)
@holding(Exponential)
@holding(
    Resilient,
    more={"loss_factor": {"options": {"HIDDEN"}}},  # 0 and 0.5 differ by 1 dB at most
    frequency="spring_frequency",
    loss_factor="spring_loss",
)
class FunctionParameters:
    """Mixin: the parameters of all functions of objects."""

    reasons = dict.fromkeys(
        ("constant", "expression", "range"), "who writes a function of their own"
    )


@holding(NormalForce)
class ContactParameters(FunctionParameters):
    """Mixin: the parameters of the functions of contacts."""

    reasons = dict.fromkeys(("reference", "exponent"), "contacts that pass on more under load")
