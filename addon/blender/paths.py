"""Paths that are stored in a .blend, which may come from somebody else."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.types import ID

from .words import TranslatedError


def local_path(stored: str, owner: ID) -> Path:
    """A path that is stored with ``owner``, as an absolute path. Raises ValueError for a URL or the
    path of a network (UNC), which could keep Blender waiting, unless the user permits online
    access; mounted drives are local."""
    full = bpy.path.abspath(stored, library=owner.library)
    if ("://" in full or full.startswith(("\\\\", "//"))) and not bpy.app.online_access:
        raise TranslatedError(
            "{} is on another computer: allow online access in Blender's preferences, or "
            "copy the file",
            full,
        )
    return Path(full)
