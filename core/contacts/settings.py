"""The input of the tracker: bodies, and the settings of contacts, which `core.scene.rules`
defines."""

from __future__ import annotations

import math

from ..frozen import frozen
from ..scene.rules import ContactSettings as ContactSettings
from ..scene.rules import ImpactEnergy as ImpactEnergy
from ..scene.rules import Motion as Motion
from ..scene.values import ALL_LAYERS, HapticObject
from .shapes import Shape


@frozen
class Body:
    """An object for the tracker. ``mass`` in kg, None if it has none. ``medium``: a volume (air,
    water) that touches what it overlaps; a mesh then stands for its hull. ``material``: its name in
    tables of rules. ``layers``: of collision, as bits."""

    name: str
    shape: Shape
    mass: float | None = None
    motion: Motion = Motion.DYNAMIC
    medium: bool = False
    material: str = ""
    layers: int = ALL_LAYERS

    @classmethod
    def of(cls, item: HapticObject, shape: Shape) -> Body:
        """A haptic object with the shape that it has now."""
        named = item.name, shape, item.mass, item.motion, item.medium, item.material
        return cls(*named, item.layers)

    @property
    def struck_in(self) -> int:
        """The layers, as bits, in which the body makes impacts and slides on others: none of a
        medium, because to enter it is not to hit it."""
        return 0 if self.medium else self.layers

    @property
    def named(self) -> tuple[str, str]:
        """Name and material, for tables of rules."""
        return self.name, self.material

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", Motion(self.motion))
        if self.mass is not None and not 0 <= self.mass < math.inf:
            raise ValueError(f"mass: must be finite and >= 0 kg, got {self.mass!r}")
