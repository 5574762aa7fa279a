"""Live output: what listeners feel goes to devices and loudspeakers while the timeline plays, and stops when anything else happens."""

from __future__ import annotations


def _modules() -> tuple:
    from . import handlers, keymap, operators, panels, refresh

    return (operators, panels, handlers, keymap, refresh)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
