"""The materials of a scene's library."""

from __future__ import annotations

from dataclasses import field

from ..declaration import Declared, name_of, switch
from ..frozen import frozen
from .bands import BAND_COUNT
from .functions.modulation import BAND_DECAYS, WAVE_SPEED
from .values import KAPPA, RHO


@frozen
class LibraryMaterial(Declared):
    """A haptic material. Objects refer to it in ``material`` and have a copy of its values."""

    name: str = field(metadata=name_of("Name, unique among materials").metadata)
    kappa: float = field(metadata=KAPPA)
    rho: float = field(metadata=RHO)
    use_delay: bool = switch(
        False, "Delay", "Delay signals by this material's wave speed; makes tracing slower"
    )
    wave_speed: float = field(default=0.0, metadata=WAVE_SPEED)
    use_bands: bool = switch(
        False, "Frequency Bands", "Attenuate each frequency band by its own value per metre"
    )
    band_decays: tuple[float, ...] = field(default=(0.0,) * BAND_COUNT, metadata=BAND_DECAYS)
