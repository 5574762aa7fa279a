"""All device families by name, and which of them a connected interface belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .dualsense import DUALSENSE
from .dualsense_pcm import DUALSENSE_PCM
from .dualshock4 import DUALSHOCK4
from .eightbitdo import EIGHTBITDO
from .family import AnyFamily, Interface
from .shield import SHIELD_2015, SHIELD_2017
from .sinput import SINPUT
from .stadia import STADIA
from .steam_controller import STEAM_CONTROLLER, STEAM_CONTROLLER_PCM
from .steam_deck import STEAM_DECK
from .switch import JOYCON_LEFT, JOYCON_RIGHT, SWITCH_PRO
from .xbox import LUNA, XBOX

_SONY: tuple[AnyFamily, ...] = (DUALSENSE, DUALSENSE_PCM, DUALSHOCK4)
_NINTENDO = (SWITCH_PRO, JOYCON_LEFT, JOYCON_RIGHT)
_VALVE: tuple[AnyFamily, ...] = (STEAM_DECK, STEAM_CONTROLLER, STEAM_CONTROLLER_PCM)
_OTHERS = (LUNA, SHIELD_2017, SHIELD_2015, EIGHTBITDO, SINPUT)

FAMILIES: Mapping[str, AnyFamily] = MappingProxyType({it.name: it for it in (*_SONY, *_NINTENDO, XBOX, STADIA, *_VALVE, *_OTHERS)})


def family(name: str) -> AnyFamily:
    """The family called ``name``. Raises ValueError that lists the known names."""
    if name not in FAMILIES:
        raise ValueError(f"device {name!r} is unknown: use one of {', '.join(FAMILIES)}")
    return FAMILIES[name]


def families_of(interface: Interface) -> tuple[AnyFamily, ...]:
    """Families that can drive this interface, the default one first."""
    return tuple(family for family in FAMILIES.values() if family.matches(interface))
