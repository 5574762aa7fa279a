"""Heat that spreads through a body and leaks into the air on its way, in the steady state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from .modulation import ModulationFunction, require


@dataclass(frozen=True, slots=True, kw_only=True)
class Conduction(ModulationFunction):
    """``exp(-m d)`` with ``m = sqrt(2 h / (k t))``: the excess temperature along a long plate that is warm at one end.

    It is the solution of the fin equation ``k t T'' = 2 h T`` (Incropera et al., "Fundamentals of Heat and Mass Transfer", section 3.6).
    conductivity: k, W/(m K). thickness: t, metres. exchange: h, W/(m^2 K), the heat that either face gives off; 10 is a calm room.
    """

    name: ClassVar[str] = "conduction"
    conductivity: float = 1.0
    thickness: float = 0.1
    exchange: float = 10.0

    def __post_init__(self) -> None:
        for key in ("conductivity", "thickness", "exchange"):
            require(key, getattr(self, key))
        for key in ("conductivity", "thickness"):
            if getattr(self, key) == 0:
                raise ValueError(f"{key}: must be greater than 0")

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> tuple[float, float]:
        return 1.0, math.sqrt(2.0 * self.exchange / (self.conductivity * self.thickness))
