"""Objects whose world matrix is not finite, as exploding simulations and failing scripts leave
them: they are named, and everything else is traced as without them."""

import math
from collections.abc import Callable
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.session import session


@pytest.fixture
def shaken(scene: Any, add_box: Callable[..., Any]) -> Any:
    """A scene with a motor that shakes a seat, and a second one on the same floor."""
    add_box("Floor", (0, 0, 0), (8, 8, 1))
    for name, x in (("Motor", 0.0), ("Second", -1.5), ("Seat", 1.5)):
        add_box(name, (x, 0, 1), (1, 1, 1))
    objects = bpy.data.objects
    objects["Motor"].haptics.source.enabled = objects["Second"].haptics.source.enabled = True
    objects["Seat"].haptics.listener.enabled = True
    return scene


def _problems(scene: Any) -> list[tuple[str, str]]:
    return [(item.object, item.message) for item in session.problems_of(scene)]


@pytest.mark.parametrize("path", ["location", "rotation_euler", "scale"])
def test_a_lost_object_is_named_and_the_others_are_felt(shaken: Any, path: str) -> None:
    shaken.frame_set(1)
    both = session.result_of(shaken).amplitudes
    second = bpy.data.objects["Second"]
    for frame, lost in ((2, True), (3, True), (4, False), (5, True)):
        before = tuple(getattr(second, path))
        if lost:
            getattr(second, path)[1] = math.nan
        shaken.frame_set(frame)
        result = session.result_of(shaken)
        assert [source.name for source in result.sources] == ["Motor"] + ["Second"] * (not lost)
        assert result.amplitudes == pytest.approx(both[: len(result.sources)])
        named = [name for name, message in _problems(shaken) if "not a number" in message]
        assert named == ["Second"] * lost
        setattr(second, path, before)


def test_a_source_on_a_lost_empty_is_named(shaken: Any, add_empty: Callable[..., Any]) -> None:
    empty = add_empty("Spot", (0, 0, 0.5), bpy.data.objects["Floor"])
    empty.haptics.source.enabled = True
    shaken.frame_set(1)
    assert len(session.result_of(shaken).sources) == 3
    empty.location.x = math.nan
    shaken.frame_set(2)
    assert len(session.result_of(shaken).sources) == 2
    assert [name for name, _ in _problems(shaken)] == ["Spot"]


def test_what_is_lost_in_a_frame_of_an_animation(shaken: Any) -> None:
    second = bpy.data.objects["Second"]
    for frame in (1, 3, 5):
        second.keyframe_insert("location", index=1, frame=frame)
    (curve,) = fcurves_of(second)
    for key in curve.keyframe_points:
        key.interpolation = "CONSTANT"
    curve.keyframe_points[1].co[1] = math.nan
    found = []
    for frame in range(1, 7):
        shaken.frame_set(frame)
        found.append([source.name for source in session.result_of(shaken).sources])
    assert found == [["Motor", "Second"]] * 2 + [["Motor"]] * 2 + [["Motor", "Second"]] * 2


@pytest.fixture
def instance(shaken: Any) -> Any:
    """An instance of a spring on the floor."""
    collection = bpy.data.collections.new("Rig")
    spring = bpy.data.objects["Second"].copy()
    spring.name = "Spring"
    spring.haptics.surface, spring.haptics.source.enabled = "CONVEX_HULL", False
    collection.objects.link(spring)
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    shaken.collection.objects.link(instance)
    return instance


def test_a_lost_instance_is_named(shaken: Any, instance: Any) -> None:
    for frame, value in ((1, 0.0), (2, math.nan), (3, 0.0)):
        instance.location.y = value
        shaken.frame_set(frame)
        assert len(session.result_of(shaken).objects) == (4 if frame == 2 else 5)
        assert [name for name, _ in _problems(shaken)] == ["Spring"] * (frame == 2)


def test_an_instance_that_grows_from_nothing_is_there(shaken: Any, instance: Any) -> None:
    for frame, scale in ((1, 0.0), (3, 0.0), (5, 1.0)):
        instance.scale = (scale,) * 3
        instance.keyframe_insert("scale", frame=frame)
    found = []
    for frame in range(1, 7):
        shaken.frame_set(frame)
        found.append(len(session.result_of(shaken).objects))
    assert found == [4, 4, 4, 5, 5, 5]
