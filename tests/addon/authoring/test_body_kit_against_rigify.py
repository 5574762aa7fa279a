"""The body kit on the armatures that Blender itself ships, Rigify's, before and after their control
rig is generated."""

import subprocess
import sys

import bpy
import pytest
from haptic_tracing.core.scene.body import BODY_PART, BODY_PARTS

FINGERS = {"index_finger.L", "index_finger.R"}

DRAW = """
import os
import sys
import bpy  # which knows where add-ons are
import addon_utils

for path in sys.argv[1:]:
    metarig, _, generated = os.path.basename(path).removesuffix(".blend").partition(" ")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    addon_utils.enable("rigify", default_set=True)
    getattr(bpy.ops.object, metarig)()
    if generated:
        bpy.ops.pose.rigify_generate()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.object.name = "rig in question"
    bpy.ops.wm.save_as_mainfile(filepath=path)
os._exit(0)
"""
RIGS = (
    "armature_human_metarig_add",
    "armature_basic_human_metarig_add",
    "armature_basic_human_metarig_add generated",
)
"""The operator that adds each armature, and whether its control rig is generated."""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """The armatures' files, drawn in a process of its own: Rigify leaves Blender 4.2 with a broken
    heap."""
    files = {name: tmp_path_factory.mktemp("rigs") / f"{name}.blend" for name in RIGS}
    subprocess.run(
        [sys.executable, "-c", DRAW, *files.values()],
        check=True,
        stdout=subprocess.DEVNULL,
        timeout=300,
    )
    return files


@pytest.fixture
def rig(request, drawn):
    bpy.ops.wm.open_mainfile(filepath=str(drawn[request.param]), use_scripts=False)
    return bpy.data.objects["rig in question"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "missing", "generated"),
    [
        (RIGS[0], set(), False),
        (RIGS[1], FINGERS, False),
        (RIGS[2], FINGERS, True),
    ],
    indirect=["rig"],
)
def test_every_part_has_its_bone(rig, missing, generated):
    bpy.context.view_layer.objects.active = rig
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    bpy.context.view_layer.update()
    listeners = {
        child.haptics.listener.body_part: child
        for child in rig.children
        if child.haptics.listener.enabled
    }
    assert set(listeners) == {part.name for part in BODY_PARTS} - missing
    place = {part: listener.matrix_world.translation for part, listener in listeners.items()}
    for part, position in place.items():
        side = BODY_PART[part].side
        assert (position.x > 0.02, position.x < -0.02) == (side == "L", side == "R")
    heights = [
        place[part].z
        for part in ("head", "chest.L", "belly", "hips", "upper_leg.L", "lower_leg.L", "foot.L")
    ]
    assert heights == sorted(heights, reverse=True)
    assert place["chest.L"].y < place["head"].y < place["upper_back.L"].y  # it faces -y
    assert all(child.parent_bone.startswith("DEF-") for child in listeners.values()) == generated
