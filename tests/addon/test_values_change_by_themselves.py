"""Each way in which a haptic value changes without an edit of it, after the first trace: what is
traced is what Blender's property has in the frame."""

import bpy
import pytest
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.session import session

PATH = "haptics.source.amplitude"


@pytest.fixture
def box(scene, add_box, add_empty):
    """A box that is a source and a listener, and is traced."""
    obj = add_box("box", (0, 0, 0), (1, 1, 1))
    obj.haptics.source.enabled = obj.haptics.listener.enabled = True
    add_empty("other", (5, 0, 0))["value"] = 0.5
    scene.frame_set(1)
    assert session.result_of(scene).sources[0].amplitude == 1.0
    return obj


def assert_followed(scene, box, frames, *expected):
    """The amplitudes are traced as the property has them in these frames."""
    found = []
    for frame in frames:
        scene.frame_set(frame)
        found.append(box.haptics.source.amplitude)
        assert session.result_of(scene).sources[0].amplitude == pytest.approx(found[-1]), frame
    assert found == pytest.approx(expected)


def driven(box, expression):
    driver = box.haptics.source.driver_add("amplitude")
    driver.driver.expression = expression
    return driver


def keyed(box, name, *values):
    """A new action of the box, with these values in frames 1, 3, ..., and straight lines."""
    box.animation_data_create().action = bpy.data.actions.new(name)
    curve = compatibility.ensure_fcurve(box, PATH)
    for k, value in enumerate(values):
        curve.keyframe_points.insert(1 + 2 * k, value).interpolation = "LINEAR"
    return curve


def test_a_driver_is_added_edited_muted_and_removed(scene, box):
    driver = driven(box, "0.5 if frame < 10 else 0.75")
    assert_followed(scene, box, (2, 3, 12), 0.5, 0.5, 0.75)
    driver.driver.expression = "0.25"
    assert_followed(scene, box, (13, 14), 0.25, 0.25)
    driver.mute = True
    box.haptics.source.amplitude = 0.125
    assert_followed(scene, box, (15,), 0.125)
    driver.mute = False
    assert_followed(scene, box, (16,), 0.25)
    box.haptics.source.driver_remove("amplitude")
    box.haptics.source.amplitude = 1.0
    assert_followed(scene, box, (17,), 1.0)
    driven(box, "0.5")
    assert_followed(scene, box, (18,), 0.5)


def test_a_driver_reads_a_property_of_another_object(scene, box):
    driver = driven(box, "value")
    variable = driver.driver.variables.new()
    variable.name, other = "value", bpy.data.objects["other"]
    variable.targets[0].id, variable.targets[0].data_path = other, '["value"]'
    assert_followed(scene, box, (2,), 0.5)
    other["value"] = 0.25
    other.update_tag()
    assert_followed(scene, box, (3,), 0.25)


def test_actions_are_added_swapped_and_taken_away(scene, box):
    keyed(box, "first", 0.5, 1.0)
    assert_followed(scene, box, (1, 2, 3), 0.5, 0.75, 1.0)
    keyed(box, "second", 0.25, 0.75)
    assert_followed(scene, box, (1, 2, 3), 0.25, 0.5, 0.75)
    box.animation_data.action = bpy.data.actions["first"]
    assert_followed(scene, box, (1, 2), 0.5, 0.75)
    box.animation_data_clear()
    box.haptics.source.amplitude = 0.125
    assert_followed(scene, box, (3,), 0.125)


def test_keys_are_set_in_one_call(scene, box):
    curve = keyed(box, "keys", 0.5, 1.0)
    assert_followed(scene, box, (1, 3), 0.5, 1.0)
    curve.keyframe_points.foreach_set("co", [1.0, 0.25, 3.0, 0.75])
    curve.update()
    assert_followed(scene, box, (1, 2, 3), 0.25, 0.5, 0.75)


def test_an_action_becomes_a_strip_that_is_muted(scene, box):
    keyed(box, "strip", 0.5, 1.0)
    action = box.animation_data.action
    box.animation_data.action = None
    track = box.animation_data.nla_tracks.new()
    track.strips.new("strip", 1, action)
    assert_followed(scene, box, (1, 2, 3), 0.5, 0.75, 1.0)
    track.mute = True
    box.haptics.source.amplitude = 0.125
    assert_followed(scene, box, (1, 2), 0.125, 0.125)
