"""Takes: bakes under a name, played in turn from the same place; their difference is that of their
levels."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import playback, storage, takes
from haptic_tracing.addon.session import session
from haptic_tracing.core.render.integers import FULL_SCALE


@pytest.fixture
def two_takes(scene, add_box, add_empty):
    """A shaker on the ground, baked at full and at half amplitude; the second is played."""
    ground = add_box("ground", (0, 0, -0.1), (4, 4, 0.2))
    source = add_empty("shaker", (-0.25, 0, 0), ground).haptics.source
    source.enabled, source.signal, source.amplitude = True, "SINE", 1.0
    add_empty("foot", (0, 0, 0), ground).haptics.listener.enabled = True
    scene.frame_end = 12
    for amplitude in (1.0, 0.5):
        source.amplitude = amplitude
        bpy.ops.haptic.bake()
        assert bpy.ops.haptic.keep_take() == {"FINISHED"}
    scene.frame_set(7)
    return scene


def test_a_new_bake_leaves_the_take_alone(two_takes):
    tracks = [storage.track_in(take.track) for take in two_takes.haptics.bake.takes]
    assert [take.name for take in two_takes.haptics.bake.takes] == ["Take 1", "Take 2"]
    assert np.abs(tracks[0].samples).max() == pytest.approx(
        2 * np.abs(tracks[1].samples).max(), rel=1e-3
    )
    assert not bpy.ops.haptic.keep_take.poll()


def test_a_take_plays_from_the_same_place(two_takes, playing):
    blocks = []
    for index in (1, 0, 1):
        assert bpy.ops.haptic.play_take(index=index) == {"FINISHED"}
        assert two_takes.frame_current == 7
        two_takes.frame_set(7)
        assert playback.is_from_track(session.result_of(two_takes))
        blocks.append(session.result_of(two_takes).block)
    assert np.abs(blocks[1]).max() == pytest.approx(2 * np.abs(blocks[0]).max(), rel=1e-3)
    assert (blocks[2] == blocks[0]).all()


def test_the_difference_is_in_decibels(two_takes, settle):
    bpy.ops.haptic.play_take(index=0)
    (found,) = settle(lambda: takes.differences(two_takes)).value
    assert found.here - found.there == pytest.approx(20 * np.log10(2), abs=0.01)
    samples = storage.track_of(two_takes).samples[0] / FULL_SCALE
    assert found.here == pytest.approx(20 * np.log10(np.sqrt((samples**2).mean())), abs=0.01)


def test_playing_a_take_keeps_the_bake_of_now_and_deleting_one_frees_it(two_takes):
    bake = two_takes.haptics.bake
    bpy.ops.haptic.bake()
    bpy.ops.haptic.play_take(index=0)
    assert [take.name for take in bake.takes] == [
        "Take 1",
        "Take 2",
        "Take 3",
    ] and bake.compared == bake.takes[2].track
    text = bake.takes[0].track.name
    bpy.ops.haptic.delete_bake()
    assert [take.name for take in bake.takes] == ["Take 2", "Take 3"] and text not in bpy.data.texts
    assert storage.track_of(two_takes) is None and storage.track_in(bake.takes[0].track) is not None
    assert bpy.ops.haptic.play_take(index=9) == {"CANCELLED"}
