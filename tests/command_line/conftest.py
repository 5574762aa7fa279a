"""What several tests of the commands start from."""

import bpy
import haptic_tracing
import pytest
from haptic_tracing.sample_scenes import build_sample


@pytest.fixture(scope="module")
def registered():
    """The add-on, enabled in an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    yield
    haptic_tracing.unregister()


@pytest.fixture(scope="module")
def falling(registered, tmp_path_factory):
    """A hammer that hits a nail, as an opened file; and what File > Export writes of its frames 1 to 30."""
    folder = tmp_path_factory.mktemp("hammer")
    build_sample("hammer_nail")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "hammer.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(folder / "hammer.blend"))
    bpy.ops.export_scene.haptic_tracks(filepath=str(folder / "addon.wav"), format="wav", frame_start=1, frame_end=30)
    return folder
