"""The gateway between what Blender registers and what computes: modules that are imported when
something of them is first used.

Enabling the add-on registers classes, properties and handlers, and that must be quick. The core and
the layers that work with it are needed only once something is tagged, an output is used or a file
is exported. `install`, called before everything else, therefore puts a stand-in for each of these
modules into its package. In the modules that are imported at registration

    from ..session import session

binds the stand-in, and the first use, ``session.trace(...)``, imports the module. So those modules
import these as modules and take no names from them; types for annotations come from under
``TYPE_CHECKING``.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_LENT = {
    "addon.authoring": "body_kit materials",
    "addon.bake": "baking playback storage takes",
    "addon.io": "capture drawings frame_scene signal_library sound_source vibration_signal",
    "addon.live_output": "outputs player preview",
    "addon.properties": "actuators",
    "addon.scene_reader": "bone_parts functions kept_signal settings triggers",
    "addon.session": "session",
    "addon.view": "comparison explanation levels "
    "meter_layout meters overlay "
    "panel_picture paths sound_picture table watched",
    "core": "felt signals",
    "core.devices": "connection full_scale mapping profile_files profiles",
    "core.formats": "haptic_scene registry",
    "core.render": "limiter mixing",
    "core.scene": "spectra",
}
MODULES = tuple(f"{package}.{name}" for package, names in _LENT.items() for name in names.split())
"""Modules of the core that are lent as placeholders to modules imported at registration, by their
names in the extension's package."""

_ROOT = __package__.rpartition(".")[0]


class StandIn(ModuleType):
    """Stands for a module that may not be imported yet."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self.__name__), name)


def install() -> None:
    """Put the stand-ins of the modules that are not imported yet into their packages."""
    for name in MODULES:
        full_name = f"{_ROOT}.{name}"
        if full_name not in sys.modules:
            package, _, own_name = full_name.rpartition(".")
            setattr(import_module(package), own_name, StandIn(full_name))


def is_loaded(module: ModuleType) -> bool:
    """Whether a module of the gateway has been imported."""
    return module.__name__ in sys.modules
