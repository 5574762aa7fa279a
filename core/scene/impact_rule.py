"""What an impact needs and what it plays."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

from ..signals import Signal


class ImpactTemplates(enum.StrEnum):
    """The signals that impacts play."""

    PLAIN = "plain"  # one for all
    BY_MATERIAL = "by_material"  # of the two impact materials, the plain one where either is unknown


@dataclass(frozen=True, slots=True)
class ImpactRule:
    """An impact is a begin of contact with at least ``least_energy`` (E_min) joules; ``full_energy`` (E_max) gives amplitude 1. A pair
    makes no second impact within ``refractory`` seconds. ``template``: what it plays."""

    least_energy: float = 5.0
    full_energy: float = 100.0
    refractory: float = 0.1
    template: ImpactTemplates | Signal = ImpactTemplates.BY_MATERIAL

    def __post_init__(self) -> None:
        if not isinstance(self.template, Signal):
            object.__setattr__(self, "template", ImpactTemplates(self.template))
        elif not self.template.duration < math.inf:
            raise ValueError("template: the signal of an impact must end")
        for key in ("least_energy", "refractory"):
            if not 0 <= getattr(self, key) < math.inf:
                raise ValueError(f"{key}: must be finite and >= 0, got {getattr(self, key)!r}")
        if not 0 < self.full_energy < math.inf:
            raise ValueError(f"full_energy: must be finite and > 0, got {self.full_energy!r}")

    def limits(self) -> ImpactRule:
        """What decides on impacts alone."""
        return replace(self, template=ImpactTemplates.PLAIN)
