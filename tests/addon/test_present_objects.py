"""Objects that are disabled in viewports, excluded or hidden, between a source and a listener, as
soon as that changes."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.session import session


@pytest.fixture
def tower(scene, add_box):
    """A floor with a source, and a hand on a block in a collection of its own."""
    floor = add_box("floor", (0, 0, 0), (2, 2, 1))
    block = add_box("block", (0, 0, 1), (1, 1, 1))
    hand = add_box("hand", (0, 0, 2), (1, 1, 1))
    floor.haptics.source.enabled = hand.haptics.listener.enabled = True
    shelf = bpy.data.collections.new("shelf")
    scene.collection.children.link(shelf)
    scene.collection.objects.unlink(block)
    shelf.objects.link(block)
    return block


def is_felt(frame):
    """Whether the hand feels the floor in a frame."""
    bpy.context.scene.frame_set(frame)
    result = session.result_of(bpy.context.scene)
    assert result.objects == ("block", "floor", "hand") or "block" not in result.objects
    return bool(result.gains.max() > 0)


def shelf_layer():
    return bpy.context.view_layer.layer_collection.children["shelf"]


@pytest.mark.parametrize(
    ("owner", "switch", "conducts"),
    [
        (lambda block: block, "hide_viewport", False),
        (lambda block: block.users_collection[0], "hide_viewport", False),
        (lambda _: shelf_layer(), "exclude", False),
        (lambda block: block, "hide_render", True),
        (lambda _: shelf_layer(), "hide_viewport", True),  # the eye
    ],
    ids=["object", "collection", "excluded", "render", "eye"],
)
def test_what_is_not_there_conducts_nothing_until_it_is_back(tower, owner, switch, conducts):
    assert is_felt(2)
    setattr(owner(tower), switch, True)
    assert is_felt(3) == is_felt(4) == conducts
    setattr(owner(tower), switch, False)
    assert is_felt(5)


def test_an_object_that_appears_by_animation(tower, scene):
    """Its bake is up to date in every frame, and plays the same."""
    tower.hide_viewport = True
    tower.keyframe_insert("hide_viewport", frame=1)
    tower.hide_viewport = False
    tower.keyframe_insert("hide_viewport", frame=5)
    felt = {frame: is_felt(frame) for frame in (3, 4, 5, 6, 4, 5)}
    assert felt == {3: False, 4: False, 5: True, 6: True}
    scene.frame_end = 8
    bpy.ops.haptic.bake()
    for frame, expected in felt.items():
        scene.frame_set(frame)
        assert playback.stale_reasons(scene) == ()
        assert is_felt(frame) == expected


def test_rigid_bodies_take_part_as_in_blenders_physics(tower, scene):
    """Blender's bodies fall on a floor that is disabled in viewports."""
    bpy.context.view_layer.objects.active = tower
    with bpy.context.temp_override(object=tower):
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    tower.hide_viewport = True
    assert is_felt(2)
