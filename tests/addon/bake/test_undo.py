"""However a bake or a conversion ends, an undo leaves no pointer to what Blender has freed."""

import bpy
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.bake.baking import bake_job
from haptic_tracing.addon.blender import job


def by_a_script(scene):
    assert bpy.ops.haptic.bake() == {"FINISHED"}


def until_done(scene):
    running = bake_job(scene)
    while running.advance(0.01) is None:
        pass


def escaped_when_it_is_stored(scene):
    """Nothing is left to cancel then: what was baked is reported."""
    running = bake_job(scene)
    while scene.haptics.bake.track is None:
        running.advance(0.0)
    running.cancel()
    reports = running.advance(0.0)
    assert reports is not None and "baked" in reports[0][1]


def window_closed_when_it_is_stored(scene):
    running = bake_job(scene)
    while scene.haptics.bake.track is None:
        running.advance(0.0)
    running.cancel()


def escaped_before(scene):
    running = bake_job(scene)
    running.advance(0.0)
    running.cancel()
    with pytest.raises(job.Cancelled):
        running.advance(0.0)


@pytest.mark.parametrize(
    "bake",
    [
        by_a_script,
        until_done,
        escaped_when_it_is_stored,
        window_closed_when_it_is_stored,
        escaped_before,
    ],
)
def test_a_bake_is_one_undo_step_however_it_ends(shaken, bake):
    shaken.frame_end = 3
    for place in (0.1, 0.2):
        bpy.data.objects["crate"].location.y = place
        bpy.ops.ed.undo_push(message="moved")
    bake(shaken)
    is_stored = shaken.haptics.bake.track is not None
    assert is_stored == (bake is not escaped_before)
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert [text for text in bpy.data.texts if text.name.startswith("Haptic Track")] == []
    assert scene.haptics.bake.track is None
    expected = 0.2 if is_stored else 0.1
    assert bpy.data.objects["crate"].location.y == pytest.approx(expected)
    bpy.ops.ed.redo()
    assert (storage.track_of(bpy.context.scene) is not None) == is_stored
