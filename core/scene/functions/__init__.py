"""Modulation functions, which give the gain of each haptic connection.

Intra-connections use the propagation function of their object, inter-connections the transmission
function of their contact. A function returns the gain of a signal over a distance, between 0 and 1.
"""

from .checking import Finding, check_expression, excerpt, require_gains
from .contacts import Impedance, NormalForce, Resilient
from .expression import MIXING_VARIABLES, compile_expression
from .modulation import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Linear,
    ModulationFunction,
    Spectrum,
)
from .physical import Physical, Wave
from .registry import FUNCTIONS, TRANSMISSIONS, function_from_dict
