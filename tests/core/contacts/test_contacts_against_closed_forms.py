"""Contacts whose place, normal, distance and area are known, in any pose, with any margins."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.narrow.closed_forms import segment_to_triangle
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
    pose_matrix,
)
from haptic_tracing.core.contacts.tracker import ContactTracker
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Pose
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull as SciPyHull

PLANE = Mesh([[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]], [[0, 1, 2], [0, 2, 3]])
GROUNDS = {
    "box": (Box((100, 100, 2)), (0.0, 0.0, -1.0)),
    "mesh": (PLANE, (0.0, 0.0, 0.0)),
    "hull": (
        ConvexHull(
            [[x, y, z] for x in (-50, 50) for y in (-50, 50) for z in (-2, 0)] + [[0, 0, -4]]
        ),
        (0.0, 0.0, 0.0),
    ),
}
CUBE = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]

frames = st.builds(
    lambda position, rotation: pose_matrix(Pose(position, rotation)),
    st.tuples(*[st.floats(-5, 5)] * 3),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 1e-2),
)


def quaternion(matrix):
    """(w, x, y, z) of a rotation matrix, by its eigenvector."""
    m = matrix[:3, :3]
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    x, y, z, w = np.linalg.eigh(k / 3)[1][:, -1]
    return (float(w), float(x), float(y), float(z))


def contact(first: tuple[Shape, Pose], second: tuple[Shape, Pose], frame=None, tolerance=0.01):
    """The contacts of two shapes, seen and placed in a frame turned anyhow; results turned back."""
    frame = np.eye(4) if frame is None else frame
    objects = []
    for name, (shape, pose) in (("a", first), ("b", second)):
        placed = frame @ pose_matrix(pose)
        objects.append(
            HapticObject(
                name, 0.1, 0.9, shape=shape, pose=Pose(tuple(placed[:3, 3]), quaternion(placed))
            )
        )
    found = contacts_of_scene(HapticScene(tuple(objects)), tolerance)
    back = frame[:3, :3].T
    return found, (found.positions - frame[:3, 3]) @ back.T, found.normal @ back.T


def at(x=0.0, y=0.0, z=0.0, rotation=(1.0, 0.0, 0.0, 0.0)):
    return Pose((x, y, z), rotation)


LYING = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)  # z to -y


@pytest.mark.slow
@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("gap", [-0.003, -1e-6, 0.0, 1e-6, 0.004])
@settings(max_examples=15, derandomize=True, deadline=None)
@given(frame=frames)
def test_box_on_a_plane(ground, gap, frame):
    shape, origin = GROUNDS[ground]
    box = Box((1.2, 0.8, 0.6))
    found, positions, normal = contact(
        (box, at(0.7, -0.4, 0.3 + gap)), (shape, Pose(origin)), frame
    )
    assert len(found) == 1
    np.testing.assert_allclose(normal[0], [0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(found.distance[0], gap, atol=1e-6)
    np.testing.assert_allclose(found.depth[0], max(-gap, 0), atol=1e-6)
    np.testing.assert_allclose(found.area[0], 1.2 * 0.8, rtol=1e-5)
    np.testing.assert_allclose(positions[0, 0], [0.7, -0.4, gap], atol=2e-5)
    np.testing.assert_allclose(positions[0, 1], [0.7, -0.4, 0], atol=2e-5)


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("gap", [-0.003, 0.0, 0.004])
@pytest.mark.parametrize(
    ("shape", "rotation", "height", "area"),
    [
        (Sphere(0.3), (1, 0, 0, 0), 0.3, 0.0),
        (Sphere(0.3, margin=0.05), (1, 0, 0, 0), 0.35, 0.0),
        (Capsule(0.2, 0.5), (1, 0, 0, 0), 0.45, 0.0),
        (Capsule(0.2, 0.5), LYING, 0.2, 0.0),
        (Cylinder(0.4, 0.5), (1, 0, 0, 0), 0.25, np.pi * 0.16),
        (Cylinder(0.4, 0.5), LYING, 0.4, 0.0),
        (Cylinder(0.4, 0.5, rounding=0.04), (1, 0, 0, 0), 0.25, np.pi * 0.16),
        (Cone(0.4, 0.5), (1, 0, 0, 0), 0.25, np.pi * 0.16),
        (Cone(0.4, 0.5), (0, 1, 0, 0), 0.25, 0.0),
        (ConvexHull(CUBE), (1, 0, 0, 0), 0.5, 1.0),
        (ConvexHull(CUBE, rounding=0.04), (1, 0, 0, 0), 0.5, 1.0),
        (ConvexHull(CUBE, margin=0.1), (1, 0, 0, 0), 0.6, 1.0),
        (
            Mesh(
                CUBE,
                [
                    [0, 1, 3],
                    [0, 3, 2],
                    [4, 6, 7],
                    [4, 7, 5],
                    [0, 4, 5],
                    [0, 5, 1],
                    [2, 3, 7],
                    [2, 7, 6],
                    [0, 2, 6],
                    [0, 6, 4],
                ],
            ),
            LYING,
            0.5,
            1.0,
        ),
        (
            Compound.of(((Box((0.2, 0.2, 1.0)), at(0.5)), (Box((0.2, 0.2, 1.0)), at(-0.5)))),
            (1, 0, 0, 0),
            0.5,
            0.08,
        ),
    ],
)
def test_shapes_on_a_plane(ground, gap, shape, rotation, height, area):
    below, origin = GROUNDS[ground]
    if gap < 0 and ground == "mesh" and isinstance(shape, Mesh):
        gap = 0.0  # surfaces that cross have no depth
    found, positions, normal = contact(
        (below, Pose(origin)), (shape, at(0.3, 0.2, height + gap, rotation))
    )
    assert len(found) == 1
    np.testing.assert_allclose(found.distance[0], gap, atol=1e-5)
    np.testing.assert_allclose(normal[0], [0, 0, 1], atol=1e-5)
    np.testing.assert_allclose(found.area[0], area, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(positions[0].mean(axis=0), [0.3, 0.2, gap / 2], atol=2e-4)
    np.testing.assert_allclose(positions[0, 1, 2] - positions[0, 0, 2], gap, atol=1e-5)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(frame=frames, x=st.floats(-0.9, 0.9), y=st.floats(-0.9, 0.9))
def test_overlap_of_two_boxes(frame, x, y):
    found, positions, _ = contact((Box((1, 1, 1)), at()), (Box((1, 1, 1)), at(x, y, 1.001)), frame)
    np.testing.assert_allclose(found.area[0], (1 - abs(x)) * (1 - abs(y)), rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(positions[0].mean(axis=0), [x / 2, y / 2, 0.5005], atol=1e-4)


@settings(max_examples=30, derandomize=True, deadline=None)
@given(frame=frames, angle=st.floats(0.05, 1.5))
def test_octagon_of_turned_squares(frame, angle):
    """Two unit squares, one turned: what they share is the square cut off at the corners."""
    turned = at(0, 0, 1.0, (np.cos(angle / 2), 0, 0, np.sin(angle / 2)))
    found, positions, _ = contact((Box((1, 1, 1)), at()), (Box((1, 1, 1)), turned), frame)
    c, s = np.cos(angle), np.sin(angle)
    leg = (c + s - 1) / 2  # what sticks out of a corner over an edge
    np.testing.assert_allclose(found.area[0], 1 - 4 * leg * leg / (2 * s * c), rtol=1e-5)
    np.testing.assert_allclose(positions[0].mean(axis=0), [0, 0, 0.5], atol=2e-5)


@settings(max_examples=30, derandomize=True, deadline=None)
@given(frame=frames, tip=st.floats(0.1, 0.7), gap=st.floats(-0.004, 0.009))
def test_box_on_its_edge(frame, tip, gap):
    """A box tipped about y stands on the middle of its edge."""
    height = 0.4 * np.cos(tip) + 0.5 * np.sin(tip)
    box = at(0, 0, height + gap, (np.cos(tip / 2), 0, np.sin(tip / 2), 0))
    # Of the edge, midway through what overlaps.
    section = 0.6 * max(-gap / 2, 0) * (np.tan(tip) + 1 / np.tan(tip))
    for name, below in GROUNDS.items():
        found, positions, normal = contact(
            (below[0], Pose(below[1])), (Box((1, 0.6, 0.8)), box), frame
        )
        np.testing.assert_allclose(found.distance[0], gap, atol=1e-6)
        np.testing.assert_allclose(normal[0], [0, 0, 1], atol=1e-6)
        edge = 0.5 * np.cos(tip) - 0.4 * np.sin(tip)
        np.testing.assert_allclose(positions[0].mean(axis=0), [edge, 0, gap / 2], atol=2e-3)
        assert found.area[0] < (max(1e-3, section) if name == "hull" else 1e-3)


@settings(max_examples=30, derandomize=True, deadline=None)
@given(frame=frames, along=st.floats(-0.4, 0.4), gap=st.floats(-0.004, 0.009))
def test_capsule_across_the_edge_of_a_box(frame, along, gap):
    """A capsule at 45 degrees over an edge, square to it."""
    far = 0.2 + gap
    middle = np.array([0.5, along, 0.5]) + far * np.array([1, 0, 1]) / np.sqrt(2)
    turn = (np.cos(np.pi / 8), 0, -np.sin(np.pi / 8), 0)  # z towards (-1, 0, 1)
    found, positions, normal = contact(
        (Box((1, 1, 1)), at()), (Capsule(0.2, 0.8), Pose(tuple(middle), turn)), frame
    )
    np.testing.assert_allclose(found.distance[0], gap, atol=1e-6)
    np.testing.assert_allclose(normal[0], np.array([1, 0, 1]) / np.sqrt(2), atol=1e-5)
    np.testing.assert_allclose(positions[0, 0], [0.5, along, 0.5], atol=1e-3)


@settings(max_examples=50, derandomize=True, deadline=None)
@given(
    frame=frames,
    radii=st.tuples(st.floats(0.05, 1), st.floats(0.05, 1)),
    margins=st.tuples(st.floats(0, 0.1), st.floats(0, 0.1)),
    # Not so near the tolerance that rounding decides.
    gap=st.floats(-0.02, 0.02).filter(lambda gap: abs(gap - 0.01) > 1e-9),
)
def test_spheres(frame, radii, margins, gap):
    far = sum(radii) + sum(margins) + gap
    found, positions, normal = contact(
        (Sphere(radii[0], margins[0]), at()),
        (Sphere(radii[1], margins[1]), at(far)),
        frame,
        tolerance=0.01,
    )
    assert len(found) == (gap <= 0.01)
    if len(found):
        np.testing.assert_allclose(found.distance[0], gap, atol=1e-9)
        np.testing.assert_allclose(normal[0], [1, 0, 0], atol=1e-9)
        np.testing.assert_allclose(positions[0, 0], [radii[0] + margins[0], 0, 0], atol=1e-9)
        np.testing.assert_allclose(positions[0, 1], [radii[0] + margins[0] + gap, 0, 0], atol=1e-9)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(frame=frames, offset=st.tuples(*[st.floats(0.0, 0.3)] * 3))
def test_corners_of_boxes(frame, offset):
    """Boxes apart in all three directions: the distance of their corners."""
    apart = np.array(offset)
    found, _, _ = contact(
        (Box((10, 10, 10)), at()),
        (Box((10, 10, 10)), Pose(tuple(10 + apart))),
        frame,
        tolerance=1.0,
    )
    np.testing.assert_allclose(found.distance[0], np.linalg.norm(apart), atol=1e-6)


def test_rounded_box_on_its_corner_is_shorter():
    """A cube of Blender's default margin stands on its corner as if rounded there, unless on
    another box."""
    diagonal = np.array([1, 1, 1]) / np.sqrt(3)
    axis = np.cross(diagonal, [0, 0, 1])
    angle = np.arccos(diagonal[2]) + np.pi
    rotation = (np.cos(angle / 2), *(np.sin(angle / 2) * axis / np.linalg.norm(axis)))
    cube, inner = Box((1, 1, 1), rounding=0.04), 0.46 * np.sqrt(3) + 0.04
    for name, height in (("mesh", inner), ("hull", inner), ("box", 0.5 * np.sqrt(3))):
        shape, origin = GROUNDS[name]
        found, _, _ = contact((shape, Pose(origin)), (cube, at(0, 0, height + 0.002, rotation)))
        np.testing.assert_allclose(found.distance, [0.002], atol=1e-5, err_msg=name)


def test_media_touch_what_they_overlap():
    """Air around a body, water under it; the contact lies where they overlap."""
    air = HapticObject("air", 0.1, 0.9, shape=Box((10, 10, 10)), pose=Pose((0, 0, 5)), medium=True)
    shell = Mesh(
        [
            [-2, -2, -1],
            [2, -2, -1],
            [2, 2, -1],
            [-2, 2, -1],
            [-2, -2, 0],
            [2, -2, 0],
            [2, 2, 0],
            [-2, 2, 0],
        ],
        [
            [0, 1, 5],
            [0, 5, 4],
            [1, 2, 6],
            [1, 6, 5],
            [2, 3, 7],
            [2, 7, 6],
            [3, 0, 4],
            [3, 4, 7],
            [0, 2, 1],
            [0, 3, 2],
        ],
    )
    water = HapticObject("water", 0.1, 0.9, shape=shell, pose=Pose(), medium=True)
    ball = HapticObject("ball", 0.1, 0.9, shape=Sphere(0.1), pose=Pose((1, 1, 3)))
    stone = HapticObject("stone", 0.1, 0.9, shape=Box((0.2, 0.2, 0.2)), pose=Pose((0.5, 0, -0.5)))
    found = contacts_of_scene(HapticScene((air, water, ball, stone)))
    assert [tuple(pair) for pair in found.pairs.tolist()] == [(0, 1), (0, 2), (1, 3)]
    np.testing.assert_allclose(found.positions[1].mean(axis=0), [1, 1, 3], atol=1e-6)
    np.testing.assert_allclose(found.positions[2].mean(axis=0), [0.5, 0, -0.5], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("rounding", [0.0, 0.04])
@pytest.mark.parametrize("corners", [3, 5, 6, 8, 12])
def test_prisms_face_to_face(corners, rounding):
    """Hulls that touch exactly, or are next to touching, all over a face: found, with its area and
    its middle, in any position."""
    generator = np.random.default_rng(corners)
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) / 2
    prism = ConvexHull(
        np.concatenate([np.column_stack([ring, np.full(corners, z)]) for z in (-0.5, 0.5)]),
        rounding=rounding,
    )
    area = corners * np.sin(2 * np.pi / corners) / 8
    for gap in (-1e-3, -1e-6, 0.0, 1e-6, 1e-4, 5e-3):
        for _ in range(5):
            first = np.eye(4)
            first[:3, :3] = rotations(generator.normal(size=(3, 1)))[..., 0]
            first[:3, 3] = generator.normal(size=3) * 3
            second = first.copy()
            second[:3, 3] += first[:3, 2] * (1 + gap)
            placed = np.stack([first, second]).astype(np.float32).astype(np.float64)
            found = (
                ContactTracker([Body("a", prism), Body("b", prism)]).update(0.0, placed).contacts
            )
            assert len(found) == 1
            assert found.distance[0] == pytest.approx(gap, abs=2e-6)
            assert found.area[0] == pytest.approx(area, rel=2e-3)
            middle = first[:3, 3] + first[:3, 2] * (0.5 + gap / 2)
            np.testing.assert_allclose(found.positions[0].mean(axis=0), middle, atol=1e-3)


def test_depth_of_segments_through_triangles_against_the_minkowski_difference():
    """It is the distance of the origin from the nearest face of the difference's convex hull
    (SciPy's Qhull)."""
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(500, 3, 3))
    middle, way = corners.mean(axis=1), rng.normal(size=(500, 3))
    start, end = (
        middle + way * rng.uniform(0.05, 1.5, (500, 1)),
        middle - way * rng.uniform(0.05, 1.5, (500, 1)),
    )
    found = segment_to_triangle(start.T, end.T, corners.transpose(2, 1, 0))
    for k in range(500):
        difference = SciPyHull((corners[k][:, None] - np.stack([start[k], end[k]])).reshape(-1, 3))
        offsets = difference.equations[:, 3]
        assert offsets.max() < 0
        assert found.distance[k] == pytest.approx(offsets.max(), abs=1e-12)
        nearest = difference.equations[offsets.argmax(), :3]
        np.testing.assert_allclose(found.normal[:, k], -nearest, atol=1e-7)
        np.testing.assert_allclose(
            found.first[:, k] - found.second[:, k],
            -found.distance[k] * found.normal[:, k],
            atol=1e-9,
        )
