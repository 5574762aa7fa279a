"""All device families by name, and the families of a connected interface."""

from __future__ import annotations

from ... import plugins
from ...scene.references import named
from .dualsense import DUALSENSE, DUALSENSE_PCM
from .family import AnyFamily, Interface
from .pads import pad

_BUILT_IN: tuple[AnyFamily, ...] = (
    DUALSENSE,
    DUALSENSE_PCM,
    pad("dualshock4"),
    pad("xbox"),
    pad("stadia"),
)


def families() -> dict[str, AnyFamily]:
    """The families by name: those that are built in, then those of plug-ins."""
    offered = (family for module in plugins.modules("devices") for family in module.FAMILIES)
    return {family.name: family for family in (*_BUILT_IN, *offered)}


def family(name: str) -> AnyFamily:
    """The family called ``name``. Raises ValueError, which lists the known names, for any other."""
    return named(name, families(), "device")


def families_of(interface: Interface) -> tuple[AnyFamily, ...]:
    """Families that can drive this interface, the default one first."""
    return tuple(family for family in families().values() if family.matches(interface))
