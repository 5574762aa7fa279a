"""Tagged objects that are linked from another file and not overridden: everything that refers to
them by name finds them, also beside objects of the same names in this file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.blender.full_names import object_named
from haptic_tracing.addon.io.devices import written_devices
from haptic_tracing.addon.live_output import handlers as live_output
from haptic_tracing.addon.properties.actuators import MUTED
from haptic_tracing.addon.scene_reader.objects import calibrated
from haptic_tracing.addon.session import session
from haptic_tracing.addon.view import explanation
from haptic_tracing.core.message import Cause


def _fill(add_box: Any, collection: Any) -> None:
    """Add a motor that shakes a seat to a collection, and a bell that rings when a ball passes."""
    for name, place, size in (
        ("Floor", (0, 0, 0), (8, 8, 1)),
        ("Motor", (0, 0, 1), (1, 1, 1)),
        ("Seat", (1.5, 0, 1), (1, 1, 1)),
        ("Bell", (-1.5, 0, 1), (1, 1, 1)),
        ("Ball", (0, 0, 6), (1, 1, 1)),
        ("Gate", (0, 0, 4), (9, 9, 0.1)),
        ("Fan", (30, 0, 0), (1, 1, 1)),
        ("Shelf", (31, 0, 0), (1, 1, 1)),
    ):
        box = add_box(name, place, size, haptic=name != "Gate")
        bpy.context.scene.collection.objects.unlink(box)
        collection.objects.link(box)
    objects = collection.objects
    for name in ("Motor", "Bell", "Fan"):
        objects[name].haptics.source.enabled = True
    for name in ("Seat", "Shelf"):
        objects[name].haptics.listener.enabled = True
    objects["Fan"].haptics.source.muted = True
    bell, ball = objects["Bell"].haptics.source, objects["Ball"]
    bell.one_shot, bell.decay = True, 0.1
    for frame, trigger in ((1, 0.0), (4, 1.0)):
        bell.trigger = trigger
        objects["Bell"].keyframe_insert("haptics.source.trigger", frame=frame)
    for frame, height in ((1, 6.0), (5, 2.0)):
        ball.location.z = height
        ball.keyframe_insert("location", frame=frame)
    seat = objects["Seat"].haptics
    seat.live_output.actuators = MUTED
    seat.listener.full_scale, seat.listener.full_scale_unit = "20 9.81, 250 9.81", "m/s^2"


@pytest.fixture(params=[False, True], ids=["alone", "beside-the-same-names"])
def linked(add_box: Any, tmp_path: Path, request: pytest.FixtureRequest) -> dict[str, Any]:
    """The linked objects by their names in the library."""
    collection = bpy.data.collections.new("Rig")
    bpy.context.scene.collection.children.link(collection)
    _fill(add_box, collection)
    path = str(tmp_path / "rig.blend")
    bpy.data.libraries.write(path, {collection})
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.data.collections.remove(collection)
    if request.param:
        for name in ("Motor", "Seat", "Bell", "Ball", "Gate", "Fan"):
            add_box(name, (50, 0, 0), (1, 1, 1), haptic=False)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.collections = ["Rig"]
    bpy.context.scene.collection.children.link(wanted.collections[0])
    return {obj.name: obj for obj in wanted.collections[0].objects}


def test_objects_are_found_by_their_full_names(linked: dict[str, Any]) -> None:
    assert all(object_named(obj.name_full) == obj for obj in bpy.data.objects)
    assert object_named("Nobody") is object_named("Nobody [rig.blend]") is None


def test_the_actuators_of_a_linked_listener_count(scene: Any, linked: dict[str, Any]) -> None:
    scene.frame_set(1)
    result = session.result_of(scene)
    seat = linked["Seat"].name_full
    assert live_output.choices(result) == {seat: MUTED}
    felt = [
        place.listeners
        for device in written_devices(scene, result.listeners)
        for place in device.actuators
    ]
    assert all(seat not in names for names in felt)


def test_the_calibration_of_a_linked_listener_counts(scene: Any, linked: dict[str, Any]) -> None:
    scene.frame_set(1)
    live = next(item for item in session.result_of(scene).listeners if "Seat" in item.name)
    baked = replace(live, full_scale=())
    assert live.full_scale and calibrated(baked).full_scale == live.full_scale


def test_a_linked_source_is_triggered_by_its_own_keys(scene: Any, linked: dict[str, Any]) -> None:
    rung = []
    for frame in range(1, 8):
        scene.frame_set(frame)
        names = [source.name for source in session.result_of(scene).sources]
        rung.append(any("Bell" in name for name in names))
        assert session.problems_of(scene) == ()
    assert rung[:4] == [False, False, False, True]


def test_why_a_linked_source_is_silent(
    scene: Any, linked: dict[str, Any], settle: Any, as_events: None
) -> None:
    scene.frame_set(1)
    session.result_of(scene)
    shelf = linked["Shelf"].name_full
    found = settle(lambda: explanation.why_silent(scene, shelf))
    causes = [(reason.cause, reason.object) for reason in found.reasons]
    assert (Cause.MUTED, linked["Fan"].name_full) in causes


def test_a_missing_library_is_named(scene: Any, add_box: Any, tmp_path: Path, traced: Any) -> None:
    box = add_box("Box", (0, 0, 0), (1, 1, 1))
    library = tmp_path / "rig.blend"
    bpy.data.libraries.write(str(library), {box})
    bpy.data.objects.remove(box)
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Box"]
    scene.collection.objects.link(wanted.objects[0].override_create())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    traced()
    (problem,) = session.problems_of(bpy.context.scene)
    assert problem.object == "Box"
    assert "rig.blend" in problem.message and "Find Missing Files" in problem.message
