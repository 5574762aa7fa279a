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
    """An object for the tracker. ``mass`` in kg, None if it has none; what animation moves then
    strikes with that of its volume, by its ``density`` in kg/m^3, 0 if that is unknown. ``medium``:
    a volume (air, water) that touches what it overlaps; a mesh then stands for its hull.
    ``material``: its name in tables of rules. ``layers``: of collision, as bits."""

    name: str
    shape: Shape
    mass: float | None = None
    motion: Motion = Motion.DYNAMIC
    medium: bool = False
    material: str = ""
    layers: int = ALL_LAYERS
    density: float = 0.0

    @classmethod
    def of(cls, item: HapticObject, shape: Shape) -> Body:
        """A haptic object with the shape that it has now."""
        named = item.name, shape, item.mass, item.motion, item.medium, item.material
        weighed = item.mass is None and item.motion is Motion.KINEMATIC and not item.medium
        density = getattr(item.propagation, "density", 0.0) if weighed else 0.0
        return cls(*named, item.layers, density)

    @property
    def is_weighed_by_volume(self) -> bool:
        """Whether the mass follows from volume and density."""
        return self.mass is None and self.density > 0

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
