"""Cloth and soft bodies, which Blender lets rest at a distance, touch what they rest on."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session
from making_haptic import make_haptic

OUTER = 0.02
"""Blender's outer thickness of what cloth collides with [m]."""


@pytest.fixture
def floor(scene, add_box):
    return add_box("floor", (0, 0, -0.1), (20, 20, 0.2), haptic=False)


def falling(kind, floor):
    """A sheet that falls onto the floor from 0.3 m."""
    bpy.ops.mesh.primitive_grid_add(
        x_subdivisions=8, y_subdivisions=8, size=2, location=(0, 0, 0.3)
    )
    sheet = bpy.context.object
    modifier = sheet.modifiers.new("falls", kind)
    if kind == "SOFT_BODY":
        modifier.settings.use_goal = False
    make_haptic(floor, sheet)
    floor.haptics.source.enabled = sheet.haptics.listener.enabled = True
    return sheet, modifier


def frame(scene, number, sheet):
    """The height of the sheet over the floor [m], and whether it feels the floor."""
    while scene.frame_current < number:
        scene.frame_set(scene.frame_current + 1)
    evaluated = sheet.evaluated_get(bpy.context.evaluated_depsgraph_get())
    height = min(vertex.co.z for vertex in evaluated.data.vertices) + sheet.location.z
    return height, bool(session.result_of(scene).gains.any())


@pytest.mark.parametrize(("kind", "own"), [("CLOTH", 0.015), ("SOFT_BODY", 0.0)])
def test_a_sheet_feels_the_floor_that_it_rests_on(scene, floor, kind, own):
    floor.modifiers.new("collides", "COLLISION")
    sheet, _ = falling(kind, floor)
    assert floor.collision.thickness_outer == pytest.approx(OUTER)
    height, feels = frame(scene, 5, sheet)
    assert height > own + OUTER + 0.02 and not feels
    height, feels = frame(scene, 30, sheet)
    assert abs(height - own - OUTER) < 0.005 and feels


def test_its_distances_can_be_changed_and_switched_off(scene, floor):
    """Of a cloth at rest 0.3 m above the floor, by the distance of a contact: the tolerance is
    0.01 m."""
    floor.modifiers.new("collides", "COLLISION")
    _, modifier = falling("CLOTH", floor)
    scene.gravity = (0, 0, 0)
    felt = []
    for distance, is_used in ((0.015, True), (0.275, True), (0.285, True), (0.285, False)):
        modifier.collision_settings.distance_min = distance
        floor.collision.use = is_used
        scene.frame_set(scene.frame_current + 1)
        felt.append(bool(session.result_of(scene).gains.any()))
    assert felt == [False, True, True, False]


def test_cloth_that_collides_with_nothing_is_its_surface(scene, floor):
    sheet, _ = falling("CLOTH", floor)
    scene.gravity = (0, 0, 0)
    felt = []
    for height in (0.005, 0.02):
        sheet.location.z = height
        sheet.modifiers["falls"].point_cache.frame_start = scene.frame_current + 1
        scene.frame_set(scene.frame_current + 1)
        felt.append(bool(np.any(session.result_of(scene).gains)))
    assert felt == [True, False]
