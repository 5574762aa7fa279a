"""Enabling the add-on loads nothing that computes: the core follows when an object is tagged, an
output is used or a file is exported."""

import json
import os
import subprocess
import sys

import pytest
from haptic_tracing.addon import gateway

# Modules of the core that are data, beside `core.scene`, from whose declarations Blender's
# properties are made.
LEAVES = {
    "arrays",
    "declaration",
    "devices",
    "diagnosis",
    "formats",
    "formats.io",
    "formats.io.catalogue",
    "forms",
    "frozen",
    "message",
    "plugins",
    "perception",  # closed forms: a listener has a calibration
    "render",
}

PROGRAM = """
import atexit, json, sys
import bpy
import haptic_tracing

@atexit.register
def remaining():
    called = [handler for name in dir(bpy.app.handlers) if isinstance(some := getattr(bpy.app.handlers, name), list) for handler in some]
    print([handler.__name__ for handler in called if handler.__module__.startswith("haptic_tracing")])

def modules():
    prefix = "haptic_tracing."
    return sorted(name.removeprefix(prefix) for name in sys.modules if name.startswith(prefix))

bpy.ops.wm.read_homefile(use_factory_startup=True)  # a cube, a camera, a light
haptic_tracing.register()
loaded = {"registered": modules()}
scene, cube = bpy.context.scene, bpy.data.objects["Cube"]
for frame in (1, 2, 5):
    scene.frame_set(frame)
cube.location.x = 1.0
bpy.context.view_layer.update()
loaded["frames and edits"] = modules()

bpy.data.objects.remove(cube)
haptic_tracing.unregister()
haptic_tracing.register()
bpy.ops.wm.read_homefile(use_factory_startup=True)
loaded["removed"] = modules()

scene, cube = bpy.context.scene, bpy.data.objects["Cube"]
bpy.ops.haptic.find_devices()
loaded["devices"] = modules()
cube.haptics.enabled = True
bpy.context.view_layer.update()
scene.frame_set(6)
loaded["tagged"] = modules()
try:
    bpy.ops.export_scene.haptic_tracks(filepath="x.wav")
except RuntimeError:
    pass  # nobody listens
loaded["exported"] = modules()
print(json.dumps(loaded))  # and it ends with the add-on enabled
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """What a program that uses one part after the other had loaded at each moment."""
    folder = tmp_path_factory.mktemp("loading")
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    *_, shown, remaining = done.stdout.splitlines()
    assert (
        remaining == "[]"
    )  # handlers, which Blender as a module would call when their names have been cleared
    return {moment: set(names) for moment, names in json.loads(shown).items()}


def of_the_core(modules):
    """The modules of the core among these, without the values of scenes."""
    return {
        name.removeprefix("core.")
        for name in modules
        if name.startswith("core.") and not name.startswith("core.scene")
    }


@pytest.mark.slow
def test_registering_frames_and_edits_of_an_untagged_scene_load_no_stage_of_the_core(loaded):
    for moment in ("registered", "frames and edits", "removed"):
        assert of_the_core(loaded[moment]) <= LEAVES
        assert not loaded[moment] & set(gateway.MODULES)


@pytest.mark.slow
def test_each_part_of_the_core_is_loaded_when_it_is_used(loaded):
    before = loaded["removed"]
    assert of_the_core(before) <= LEAVES
    for step, stages in (
        ("devices", {"devices.inventory"}),
        ("tagged", {"tracer", "contacts.tracker"}),
        ("exported", {"formats.export"}),
    ):
        assert stages <= of_the_core(loaded[step] - before), step
        before = loaded[step]
