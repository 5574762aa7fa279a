"""Labels stay in sight, beside their places and off each other; projection against Blender's
own."""

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from haptic_tracing.addon.blender.text import shortened, text_width
from haptic_tracing.addon.view.annotations import placed_annotations
from haptic_tracing.addon.view.hud import TEXT_SIZE
from haptic_tracing.addon.view.label_placement import place_labels, project
from haptic_tracing.addon.view.render_data import Options, render_data
from haptic_tracing.addon.view.symbols import Symbol
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Settings
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mathutils import Vector

from .conftest import BRIDGE, traced

SIZE = (400.0, 300.0)
ROOM = (20.0, 10.0, 390.0, 280.0)


def _perspective(scene, camera, size=SIZE):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return np.array(
        camera.calc_matrix_camera(depsgraph, x=int(size[0]), y=int(size[1]))
        @ camera.matrix_world.inverted()
    )


def test_project_against_blender(scene, camera):
    scene.render.resolution_x, scene.render.resolution_y = map(int, SIZE)
    random = np.random.default_rng(1)
    position = random.uniform(-3, 3, (200, 3))
    pixels = project(position, _perspective(scene, camera), SIZE)
    for place, pixel in zip(position, pixels, strict=True):
        x, y, depth = world_to_camera_view(scene, camera, Vector(place))
        if 0 < x < 1 and 0 < y < 1 and camera.data.clip_start < depth < camera.data.clip_end:
            assert pixel == pytest.approx((x * SIZE[0], y * SIZE[1]), abs=1e-3)
        else:
            assert np.isnan(pixel).all()


def _overlap(a, b):
    return (a[:2] < b[2:]).all() and (b[:2] < a[2:]).all()


@settings(
    deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_labels_never_overlap(seed, count):
    random = np.random.default_rng(seed)
    anchor = random.uniform(-50, SIZE, (count, 2))
    anchor = anchor[(anchor >= 0).all(axis=1)]
    count = len(anchor)
    extent = random.uniform((30, 10), (120, 20), (count, 2))
    occupied = np.array([[300.0, 0.0, 400.0, 60.0]])
    corner = place_labels(
        anchor, extent, np.full(count, 8.0), ROOM, occupied, random.uniform(0, SIZE, (200, 2))
    )
    placed = np.column_stack([corner, corner + extent])[~np.isnan(corner[:, 0])]
    assert (placed[:, :2] >= np.array(ROOM[:2]) - 1e-9).all()
    assert (placed[:, 2:] <= np.array(ROOM[2:]) + 1e-9).all()
    for k, rectangle in enumerate(placed):
        assert not _overlap(rectangle, occupied[0])
        assert not any(_overlap(rectangle, other) for other in placed[:k])


@given(st.floats(150, 250), st.floats(100, 200))
def test_a_label_with_room_is_placed(x, y):
    corner = place_labels(
        np.array([[x, y]]),
        np.array([[80.0, 15.0]]),
        np.array([8.0]),
        ROOM,
        np.zeros((0, 4)),
        np.zeros((0, 2)),
    )
    assert np.isfinite(corner).all()


def test_a_free_label_stands_at_the_right_of_its_place():
    corner = place_labels(
        np.array([[100.0, 100.0]]),
        np.array([[60.0, 20.0]]),
        np.array([15.0]),
        ROOM,
        np.zeros((0, 4)),
        np.zeros((0, 2)),
    )
    assert corner[0] == pytest.approx((115, 90))


def test_a_label_leaves_paths_free():
    path = np.column_stack([np.linspace(105, 190, 40), np.full(40, 100.0)])
    corner = place_labels(
        np.array([[100.0, 100.0]]),
        np.array([[60.0, 20.0]]),
        np.array([15.0]),
        ROOM,
        np.zeros((0, 4)),
        path,
    )
    assert corner[0] == pytest.approx((25, 90))  # at the left


def test_annotations_name_what_is_there_and_keeps_within_what_is_free(scene, camera, bridge):
    data = render_data(bridge, BRIDGE.settings, Options())
    size, free, meters = (900.0, 700.0), (60.0, 30.0, 690.0, 640.0), (70.0, 40.0, 200.0, 120.0)
    items = placed_annotations(data, _perspective(scene, camera, size), size, 1.0, free, (meters,))
    words = [text.words for text in items.texts]
    assert {
        "truck",
        "driver",
        "walker",
        "hermit",
        "0 dB",
        "−60",
    } <= set(words)
    assert set(items.lines.shape.astype(int)) <= {Symbol.LINE, Symbol.PLATE}
    legend = items.lines.position[0]
    assert legend[1, 0] <= free[2]
    assert legend[0, 1] >= free[1]
    for text in items.texts:
        assert free[0] <= text.position[0] <= free[2] - text_width(text.words, text.size)
        assert free[1] <= text.position[1] <= free[3]
    plates = items.lines.position[items.lines.shape == Symbol.PLATE]
    for low, high in plates[:, :, :2].tolist():
        assert not _overlap(np.array([*low, *high]), np.array(meters))


def test_legend_scales_with_the_user_interface(scene, camera, bridge):
    data = render_data(bridge, BRIDGE.settings, Options(labelled=""))
    size = (800.0, 600.0)
    one, two = (
        placed_annotations(data, _perspective(scene, camera), size, scale, (0.0, 0.0, *size))
        for scale in (1.0, 2.0)
    )
    extents = [np.ptp(items.lines.position[0], axis=0)[:2] for items in (one, two)]
    assert extents[1] == pytest.approx(2 * extents[0], rel=0.03)
    assert [text.size * 2 for text in one.texts] == pytest.approx([text.size for text in two.texts])


def test_the_legend_is_as_high_as_its_texts(scene, camera):
    nothing = traced(HapticScene((HapticObject("deck", 0.0, 1.0),), ()))
    size = (900.0, 700.0)
    items = placed_annotations(
        render_data(nothing, Settings(), Options()),
        _perspective(scene, camera, size),
        size,
        1.0,
        (0.0, 0.0, *size),
    )
    assert items.texts
    assert set(items.lines.shape.astype(int)) <= {Symbol.LINE, Symbol.PLATE}
    ((_, _, _, top),) = items.bounds
    assert 0 <= max(text.position[1] for text in items.texts) + items.texts[0].size <= top
    assert top - max(text.position[1] for text in items.texts) < 2 * TEXT_SIZE


@pytest.mark.parametrize(
    "name",
    ["upper_leg.L.001", "upper_leg.R.001", "middle_back.R", "index_finger-left", "Forearm_r.012"],
)
def test_shortened_names_keep_the_side_of_the_body(name):
    """Here every character is as wide as any other."""
    side = name[max(name.rfind(mark) for mark in (".L", ".R", "-left", "_r")) :]
    for room in range(len(side) + 2, len(name)):
        short = shortened(name, room, 1.0, lambda words, size: len(words) * size)
        assert (
            len(short) <= room
            and short.endswith(side)
            and short[0] == name[0]
            and "\u2026" in short
        )


def test_names_without_a_side_keep_both_ends():
    measure = lambda words, size: len(words) * size  # noqa: E731
    assert shortened("Jackhammer", 7, 1.0, measure) == "Jac\u2026mer"
    assert shortened("Jackhammer", 10, 1.0, measure) == "Jackhammer"
    assert shortened("upper_leg.L.001", 4, 1.0, measure) == "up\u20261"
    assert shortened("Jackhammer", 2, 1.0, measure) == ""
