"""Fixtures in Blender, and the traced frames of the tests of the overlay."""

import importlib.util
from pathlib import Path

from in_blender import *  # noqa: F403

_spec = importlib.util.spec_from_file_location(
    "overlay_frames", Path(__file__).parents[2] / "addon" / "overlay" / "conftest.py"
)
_module = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_module)
BRIDGE, random_scene, traced_frame = _module.BRIDGE, _module.random_scene, _module.traced
bridge, camera, shown = _module.bridge, _module.camera, _module.shown
