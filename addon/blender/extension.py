"""The add-on as an extension of Blender: its package and its folders."""

from __future__ import annotations

from pathlib import Path

import bpy

ROOT = __package__.rsplit(".addon", 1)[0]
"""The extension's own package: the key of its preferences."""


def profile_folders() -> tuple[Path, ...]:
    """The folder of the user's own device profiles: "devices" in the extension's folder, if the
    add-on is installed as an extension."""
    if not ROOT.startswith("bl_ext."):
        return ()
    return (Path(bpy.utils.extension_path_user(ROOT, path="devices")),)
