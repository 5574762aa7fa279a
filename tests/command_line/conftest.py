"""What several tests of the commands start from."""

import atexit

import bpy
import haptic_tracing
import pytest
from haptic_tracing.command_line import main, trace
from haptic_tracing.sample_scenes import build_sample


@pytest.fixture(scope="module")
def registered():
    """The add-on, enabled in an empty file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    yield
    haptic_tracing.unregister()


@pytest.fixture(scope="module")
def command(registered):
    """Runs a command that enables the add-on itself, in this process: it takes two seconds to start
    another one. Gives the exit code."""

    def run(*arguments):
        haptic_tracing.unregister()
        code = main([str(argument) for argument in arguments])
        atexit.unregister(trace.unregister)  # `registered` does it
        if not hasattr(bpy.types.Scene, "haptics"):
            haptic_tracing.register()
        return code

    return run


@pytest.fixture(scope="module")
def falling(registered, tmp_path_factory):
    """A hammer that hits a nail, as an opened file; and what File > Export writes of its frames 1
    to 30."""
    folder = tmp_path_factory.mktemp("hammer")
    build_sample("hammer_nail")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "hammer.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(folder / "hammer.blend"))
    bpy.ops.export_scene.haptic_tracks(
        filepath=str(folder / "addon.wav"), formats={"wav"}, frame_start=1, frame_end=30
    )
    return folder
