"""Fixtures in Blender, and the layout that records what is drawn."""

import importlib.util
from pathlib import Path

import pytest
from in_blender import *  # noqa: F403

_spec = importlib.util.spec_from_file_location(
    "gain_plot_recording_layout", Path(__file__).parents[2] / "addon" / "recording_layout.py"
)
_module = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_module)


@pytest.fixture
def recording_layout():
    """Its class."""
    return _module.RecordingLayout
