"""The body kit on the armatures that Blender itself ships, Rigify's, before and after their control rig is generated."""

import addon_utils
import bpy
import pytest
from haptic_tracing.core.body import BODY_PART, BODY_PARTS

FINGERS = {"index_finger.L", "index_finger.R"}


@pytest.fixture
def rigify():
    addon_utils.enable("rigify", default_set=True)
    yield
    addon_utils.disable("rigify", default_set=True)


@pytest.mark.parametrize(
    ("metarig", "missing", "steps"),
    [("armature_human_metarig_add", set(), (False,)), ("armature_basic_human_metarig_add", FINGERS, (False, True))],
)
def test_every_part_has_its_bone(rigify, metarig, missing, steps):
    getattr(bpy.ops.object, metarig)()
    for generated in steps:
        if generated:
            bpy.ops.pose.rigify_generate()
        armature = bpy.context.object
        if armature.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.haptic.add_default_listeners(parts="ALL")
        bpy.context.view_layer.update()
        listeners = {child.haptics.listener.body_part: child for child in armature.children if child.haptics.listener.enabled}
        assert set(listeners) == {part.name for part in BODY_PARTS} - missing
        place = {part: listener.matrix_world.translation for part, listener in listeners.items()}
        for part, position in place.items():
            side = BODY_PART[part].side
            assert (position.x > 0.02, position.x < -0.02) == (side == "L", side == "R")
        heights = [place[part].z for part in ("head", "chest.L", "belly", "hips", "upper_leg.L", "lower_leg.L", "foot.L")]
        assert heights == sorted(heights, reverse=True)
        assert place["chest.L"].y < place["head"].y < place["upper_back.L"].y  # it faces -y
        assert all(child.parent_bone.startswith("DEF-") for child in listeners.values()) == generated
