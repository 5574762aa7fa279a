"""Plug-ins: packages that offer formats or device families, and may have a part in Blender.

Found are those in the folder `plugins`, those that other packages name as entry points
(``haptic_tracing.formats``, ``haptic_tracing.devices``), and those that another extension of
Blender adds. A plug-in lists what it offers as ``FORMATS`` and ``DEVICES``. One that fails is left
out, and the reason kept.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

_ROOT = __package__.rpartition(".")[0]
_FOLDER = Path(__file__).parents[1] / "plugins"
_KINDS = ("formats", "devices")

_plugins: dict[str, ModuleType] = {}
failures: dict[str, str] = {}
"""Why a plug-in is left out, by its name."""


def plugins() -> dict[str, ModuleType]:
    """The plug-ins by name."""
    _find()
    return _plugins


def offered(kind: str) -> list[Any]:
    """What the plug-ins offer of a kind: "formats", "devices", "drivers", "players", "exports"."""
    return [item for plugin in plugins().values() for item in getattr(plugin, kind.upper(), ())]


def modules(kind: str) -> list[ModuleType]:
    """The modules that plug-ins name for "devices", "drivers" or "players", without those that
    fail."""
    found = []
    for name in offered(kind):
        try:
            found.append(import_module(name))
        except Exception as error:
            note_failure(name, error)
    return found


def add(name: str, load: Callable[[], ModuleType]) -> None:
    """Add a plug-in, whatever loading it does."""
    try:
        _plugins[name] = load()
    except Exception as error:
        note_failure(name, error)


def remove(name: str) -> None:
    """Forget a plug-in that was added."""
    _plugins.pop(name, None)
    failures.pop(name, None)


def note_failure(name: str, error: Exception) -> None:
    """Keep the reason why a plug-in, or its part in Blender, is left out."""
    failures[name] = f"{type(error).__name__}: {error}"


@cache
def _find() -> None:
    for path in sorted(_FOLDER.glob("*/__init__.py")):
        name = path.parent.name
        add(name, partial(import_module, f"{_ROOT}.plugins.{name}"))
    known = entry_points()
    for kind in _KINDS:
        for point in known.select(group=f"haptic_tracing.{kind}"):
            add(point.name, point.load)
