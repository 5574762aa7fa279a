"""Scenes with several view layers, as renders in layers need them: the layer of the window is
traced, whichever layers Blender evaluates besides."""

from collections.abc import Callable
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.bake import storage
from haptic_tracing.addon.session import session


@pytest.fixture
def layers(scene: Any, add_box: Callable[..., Any]) -> tuple[Any, Any]:
    """A scene's layers: with everything that shakes a seat, and without the motor."""
    add_box("Floor", (0, 0, 0), (4, 4, 1))
    motor, seat = add_box("Motor", (0, 0, 1), (1, 1, 1)), add_box("Seat", (1.2, 0, 1), (1, 1, 1))
    motor.haptics.source.enabled = seat.haptics.listener.enabled = True
    collection = bpy.data.collections.new("Engine")
    scene.collection.children.link(collection)
    collection.objects.link(motor)
    scene.collection.objects.unlink(motor)
    bare = scene.view_layers.new("Without Engine")
    bare.layer_collection.children["Engine"].exclude = True
    return scene.view_layers[0], bare


def _sources(result: Any) -> list[str]:
    return [source.name for source in result.sources]


def test_a_frame_is_that_of_the_windows_layer(scene: Any, layers: tuple[Any, Any]) -> None:
    expected = (["Motor"], [])
    frame = 1
    for _ in range(2):
        for layer, sources in zip(layers, expected, strict=True):
            bpy.context.window.view_layer = layer
            for _ in range(2):
                frame += 1
                scene.frame_set(frame)
                assert _sources(session.result_of(scene)) == sources


def test_a_frame_of_another_scene_is_that_of_its_first_layer(
    scene: Any, layers: tuple[Any, Any]
) -> None:
    bpy.ops.scene.new(type="EMPTY")
    scene.frame_set(2)
    assert _sources(session.result_of(scene)) == ["Motor"]


def test_an_edit_is_traced_in_the_windows_layer(scene: Any, layers: tuple[Any, Any]) -> None:
    scene.frame_set(2)
    bpy.data.objects["Seat"].location.x = 1.4
    for layer in reversed(layers):  # as two windows do
        layer.update()
    assert _sources(session.result_of(scene)) == ["Motor"]


@pytest.mark.parametrize("chosen", [0, 1])
def test_a_bake_is_of_the_windows_layer(
    scene: Any, layers: tuple[Any, Any], traced: Callable[[], Any], chosen: int
) -> None:
    bpy.context.window.view_layer = layers[chosen]
    scene.frame_end = 4
    now = traced()
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    track = storage.track_of(scene)
    assert track is not None
    for frame in range(1, 5):
        baked = track.result(frame)
        assert baked is not None and _sources(baked) == _sources(now)
        assert baked.amplitudes == pytest.approx(now.amplitudes)
