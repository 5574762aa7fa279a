"""*Time Stretching*: what is keyed is felt when Blender shows it."""

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.blender.time import seconds_of
from haptic_tracing.addon.io import sound_source
from haptic_tracing.addon.scene_reader.animated_curves import FREQUENCY, AnimatedCurves
from haptic_tracing.addon.session import session


@pytest.fixture(params=[(100, 200), (100, 50), (100, 100)], ids=["half", "double", "plain"])
def stretched(scene: Any, add_box: Callable[..., Any], request: pytest.FixtureRequest) -> Any:
    """A motor that shakes a seat, in a scene whose animation is stretched."""
    add_box("Floor", (0, 0, 0), (4, 4, 1))
    motor, seat = add_box("Motor", (0, 0, 1), (1, 1, 1)), add_box("Seat", (1.2, 0, 1), (1, 1, 1))
    motor.haptics.source.enabled = seat.haptics.listener.enabled = True
    scene.frame_start, scene.frame_end = 0, 48
    scene.render.frame_map_old, scene.render.frame_map_new = request.param
    return scene


def test_a_frequency_is_that_of_its_frame(stretched: Any) -> None:
    motor = bpy.data.objects["Motor"]
    for frame, hertz in ((6, 40.0), (18, 100.0), (22, 60.0)):
        motor.haptics.source.frequency = hertz
        motor.keyframe_insert(FREQUENCY, frame=frame)
    for key in fcurves_of(motor)[0].keyframe_points:
        key.interpolation = "LINEAR"
    automation = AnimatedCurves().of_source(motor, stretched)
    assert automation is not None
    for frame in range(49):
        stretched.frame_set(frame)
        shown = motor.haptics.source.frequency
        (read,) = automation.at(np.array([seconds_of(stretched, frame)]))
        assert read == pytest.approx(shown, rel=1e-5)


def test_a_trigger_plays_when_its_key_is_reached(stretched: Any) -> None:
    source = bpy.data.objects["Motor"].haptics.source
    source.one_shot, source.decay = True, 0.02
    for frame, value in ((0, 0.0), (11, 0.0), (12, 1.0), (13, 0.0)):
        source.trigger = value
        source.id_data.keyframe_insert("haptics.source.trigger", frame=frame)
    played = full = None
    for frame in range(49):
        stretched.frame_set(frame)
        if source.trigger == 1.0:
            full = frame
        if session.result_of(stretched).sources and played is None:
            played = frame
    assert full is not None and played == full


def test_the_volume_of_a_speaker_is_that_of_its_frame(stretched: Any) -> None:
    speaker = bpy.data.speakers.new("Speaker")
    obj = bpy.data.objects.new("Speaker", speaker)
    stretched.collection.objects.link(obj)
    for frame, volume in ((0, 0.2), (30, 0.8)):
        speaker.volume = volume
        speaker.keyframe_insert("volume", frame=frame)
    read = sound_source._volume(speaker, "volume", speaker.volume, stretched, 2.0)
    for frame in range(0, 48, 4):
        stretched.frame_set(frame)
        at = np.array([seconds_of(stretched, frame)])
        assert read.at(at) == pytest.approx([speaker.volume], rel=1e-5)


def test_a_bake_is_out_of_date_after_stretching(stretched: Any) -> None:
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    assert playback.stale_reasons(stretched) == ()
    stretched.render.frame_map_new = 77
    assert any("frame rate" in reason for reason in playback.stale_reasons(stretched))
