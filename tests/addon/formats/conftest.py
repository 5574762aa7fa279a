"""The layout that records what is drawn; `scene_files` can be imported."""

import importlib.util
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

_spec = importlib.util.spec_from_file_location(
    "formats_recording_layout", Path(__file__).parents[1] / "recording_layout.py"
)
_module = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_module)


@pytest.fixture
def recording_layout():
    """Its class."""
    return _module.RecordingLayout
