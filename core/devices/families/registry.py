"""All device families by name, and the families of a connected interface."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ... import plugins
from ...scene.references import named
from .asked import EIGHTBITDO, SINPUT
from .dualsense import DUALSENSE, DUALSENSE_PCM
from .family import AnyFamily, Interface
from .pads import pad
from .steam import STEAM_CONTROLLER, STEAM_CONTROLLER_PCM, STEAM_DECK
from .switch import JOYCON_LEFT, JOYCON_RIGHT, SWITCH_PRO

_SONY: tuple[AnyFamily, ...] = (DUALSENSE, DUALSENSE_PCM, pad("dualshock4"))
_NINTENDO = (SWITCH_PRO, JOYCON_LEFT, JOYCON_RIGHT)
_VALVE: tuple[AnyFamily, ...] = (STEAM_DECK, STEAM_CONTROLLER, STEAM_CONTROLLER_PCM)
_OTHERS = (pad("luna"), pad("shield-2017"), pad("shield-2015"), EIGHTBITDO, SINPUT)
_ALL = (*_SONY, *_NINTENDO, pad("xbox"), pad("stadia"), *_VALVE, *_OTHERS)

FAMILIES: Mapping[str, AnyFamily] = MappingProxyType({family.name: family for family in _ALL})
"""Those that are built in."""


def families() -> dict[str, AnyFamily]:
    """The families by name, those of plug-ins among them."""
    return {**FAMILIES, **{family.name: family for family in plugins.offered("devices")}}


def family(name: str) -> AnyFamily:
    """The family called ``name``. Raises ValueError, which lists the known names, for any other."""
    return FAMILIES[name] if name in FAMILIES else named(name, families(), "device")


def families_of(interface: Interface) -> tuple[AnyFamily, ...]:
    """Families that can drive this interface, the default one first."""
    return tuple(family for family in families().values() if family.matches(interface))
