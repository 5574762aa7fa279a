"""Haptic Tracing: vibration propagated through touching objects.

Outside Blender this is the package ``haptic_tracing``; inside it is the extension
``bl_ext.<repository>.haptic_tracing``.

>>> import haptic_tracing as ht
>>> scene = ht.load("bench.json")  # doctest: +SKIP
>>> scene.gains()  # doctest: +SKIP
{('jackhammer', 'seat'): 0.42}
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .core import __version__ as __version__

if TYPE_CHECKING:
    from .core.run_time import FormatError as FormatError
    from .core.run_time import Pair as Pair
    from .core.run_time import Result as Result
    from .core.run_time import Run as Run
    from .core.run_time import Scene as Scene
    from .core.run_time import Step as Step
    from .core.run_time import load as load
    from .core.run_time import loads as loads
    from .core.run_time import open as open
    from .core.run_time import read as read

_FRONT_DOOR = (
    "FormatError",
    "Pair",
    "Result",
    "Run",
    "Scene",
    "Step",
    "load",
    "loads",
    "open",
    "read",
)
"""What the package offers outside Blender, imported when it is asked for."""


def __getattr__(name: str) -> Any:
    if name in _FRONT_DOOR:
        return getattr(import_module(".core.run_time", __package__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*_FRONT_DOOR, "__version__"]


def register() -> None:
    """Called by Blender when the extension is enabled."""
    _registration().register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    _registration().unregister()


def add_plugin(name: str, plugin: ModuleType) -> None:
    """Called by another extension when it is registered: it offers formats or more."""
    _registration().add_plugin(name, plugin)


def remove_plugin(name: str) -> None:
    """Called by the other extension when it is unregistered."""
    _registration().remove_plugin(name)


def _registration() -> Any:
    """The part of the add-on that registers it."""
    from .addon import gateway

    gateway.install()
    from .addon import registration

    return registration
