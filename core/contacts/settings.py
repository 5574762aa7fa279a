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
    tables of rules. ``layers``: of collision, as bits. What animation moves without a mass strikes
    with that of its volume, by its ``density`` [kg/m^3], 0 if that is unknown. ``limbs``: of a
    compound whose parts bones move the masses [kg] with which these strike, 0 for that of their
    volume."""

    name: str
    shape: Shape
    mass: float | None = None
    motion: Motion = Motion.DYNAMIC
    medium: bool = False
    material: str = ""
    layers: int = ALL_LAYERS
    density: float = 0.0
    limbs: tuple[float, ...] = ()

    @classmethod
    def of(cls, item: HapticObject, shape: Shape, limbs: tuple[float, ...] = ()) -> Body:
        """A haptic object with the shape that it has now."""
        named = item.name, shape, item.mass, item.motion, item.medium, item.material
        animated = item.mass is None and item.motion is Motion.KINEMATIC and not item.medium
        density = getattr(item.propagation, "density", 0.0) if animated or limbs else 0.0
        return cls(*named, item.layers, density, limbs)

    @property
    def is_weighed_by_volume(self) -> bool:
        """Whether it is moved by animation without a mass of its own."""
        animated = self.motion is Motion.KINEMATIC and self.mass is None
        return animated and self.density > 0 and not self.limbs

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
