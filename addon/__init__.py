"""The Blender side: properties, panels, operators, handlers and overlays. Thin: what is computed is computed in `core`."""

from __future__ import annotations


def _modules() -> tuple:
    from . import bake, formats, handlers, operators, overlay, panels, properties

    return (properties, operators, panels, bake, formats, overlay, handlers)


def register() -> None:
    """Register everything; the reverse of `unregister`."""
    for module in _modules():
        module.register()


def unregister() -> None:
    """Remove everything that `register` added."""
    for module in reversed(_modules()):
        module.unregister()
