"""The materials of a scene's library."""

from __future__ import annotations

from dataclasses import field

from ..declaration import Declared, name_of
from ..frozen import frozen
from .functions.modulation import WAVE_SPEED
from .values import KAPPA, RHO


@frozen
class LibraryMaterial(Declared):
    """A haptic material. Objects refer to it in ``material`` and have a copy of its values."""

    name: str = field(metadata=name_of("Name, unique among materials").metadata)
    kappa: float = field(metadata=KAPPA)
    rho: float = field(metadata=RHO)
    wave_speed: float = field(default=0.0, metadata=WAVE_SPEED)
