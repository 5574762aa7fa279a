"""The start of a virtual-reality session."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..blender.handlers import Handlers
from ..gateway import is_loaded
from . import actions, controllers


@persistent
def session_begins(*_: Any) -> None:
    """Come again after the handlers of all add-ons, of which one may activate its own actions."""
    bpy.app.handlers.xr_session_start_pre.append(_actions_exist)


@persistent
def _actions_exist(*_: Any) -> None:
    bpy.app.handlers.xr_session_start_pre.remove(_actions_exist)
    action_set = actions.create()
    if action_set:
        controllers.begin(action_set)


_HANDLERS = Handlers(xr_session_start_pre=session_begins)


def register() -> None:
    _HANDLERS.add()


def unregister() -> None:
    """Stop the controllers at once."""
    _HANDLERS.remove()
    if is_loaded(controllers):
        controllers.end()
