"""Contacts of surfaces against brute force over all triangles, and their patches against closed
forms and continuity."""

from __future__ import annotations

import gc
import importlib.util
import itertools
import sys
import weakref
from functools import cache
from pathlib import Path

import fcl
import numpy as np
import pytest
from haptic_tracing.core.contacts.narrow.frames import relative_pose
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.shapes import Box, ConvexHull, Cylinder, Mesh, Sphere

_spec = importlib.util.spec_from_file_location(
    "triangle_reference", Path(__file__).parents[2] / "references" / "triangle_reference.py"
)
reference = importlib.util.module_from_spec(_spec)
sys.modules["triangle_reference"] = reference
_spec.loader.exec_module(reference)

TOLERANCE, SUNK_IN, BAND = 0.012, 0.05, 1e-3


def poses_12(matrix):
    return np.concatenate([matrix[:3, :3].reshape(9, 1), matrix[:3, 3:]])


@cache
def phase(first, second):
    """That of two shapes, whose trees are built once."""
    return NarrowPhase([first, second])


def query(first, second, a, b, limit=TOLERANCE):
    """Distance, normal, centre and area of the contact of two shapes in these poses (4, 4), in the
    world."""
    found = phase(first, second).query(
        np.array([[0, 1]]), *relative_pose(poses_12(a), poses_12(b)), np.array([limit])
    )
    return (
        float(found.distance[0]),
        a[:3, :3] @ found.normal[:, 0],
        a[:3, :3] @ found.centre[:, 0] + a[:3, 3],
        float(found.area[0]),
    )


def rotation(random):
    w, x, y, z = (lambda q: q / np.linalg.norm(q))(random.normal(size=4))
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def pose(place, turn=None):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    if turn is not None:
        matrix[:3, :3] = turn
    return matrix


def body(points, triangles):
    model = fcl.BVHModel()
    model.beginModel(len(points), len(triangles))
    model.addSubModel(points, triangles)
    model.endModel()
    return fcl.CollisionObject(model)


def near_poses(one, other, random, count):
    """Poses of the second mesh in which it is within 3 cm of the first, crosses it or is inside
    it."""
    a, b = body(*one), body(*other)
    result = []
    while len(result) < count:
        turn, way = rotation(random), random.normal(size=3)
        way /= np.linalg.norm(way)
        through = random.uniform(-0.15, 0.15, size=3)
        b.setRotation(turn)
        away, target = 0.0, random.uniform(-0.01, 0.018)
        while True:  # outwards until they are as far apart as wanted, from anywhere within
            b.setTranslation(through + away * way)
            gap = fcl.distance(a, b, fcl.DistanceRequest(), fcl.DistanceResult())
            if gap > max(target, 0.0):
                break
            away += 0.004
        if gap < 0.05:
            result.append(pose(through + (away + min(target, 0.0)) * way, turn))
    return result


def placed(mesh, matrix):
    points, triangles = mesh
    return (points @ matrix[:3, :3].T + matrix[:3, 3])[triangles]


@cache
def solids_near_each_other(name_a, name_b):
    """Two solids in each of twelve poses: the pose of the second (4, 4), the triangles of both, and
    the distance between their surfaces by brute force."""
    one, other = reference.SOLIDS[name_a], reference.SOLIDS[name_b]
    random = np.random.default_rng(sum(map(ord, name_a + name_b)))
    found = []
    for matrix in near_poses(one, other, random, 12):
        first, second = placed(one, np.eye(4)), placed(other, matrix)
        found.append((matrix, first, second, reference.distance(first, second)))
    return found


PAIRS = list(itertools.combinations_with_replacement(sorted(reference.SOLIDS), 2))


@pytest.mark.slow
@pytest.mark.parametrize(("name_a", "name_b"), PAIRS, ids=[f"{a}-{b}" for a, b in PAIRS])
@pytest.mark.parametrize("solid", [True, False], ids=["solids", "shells"])
def test_contacts_are_those_of_all_triangles(name_a, name_b, solid):
    """None is missed and none invented beyond 1 mm; distances of those apart are exact, those of
    solids that cross within their bounds."""
    one, other = reference.SOLIDS[name_a], reference.SOLIDS[name_b]
    shapes = [Mesh(*mesh, sunk_in=SUNK_IN * solid) for mesh in (one, other)]
    most = min(SUNK_IN, *(np.ptp(points, axis=0).min() / 2 for points, _ in (one, other))) * solid
    apart = crossing = inside = 0
    for matrix, first, second, gap in solids_near_each_other(name_a, name_b):
        enclosed = solid and (
            reference.is_inside(second[:1, 0], first)[0]
            or reference.is_inside(first[:1, 0], second)[0]
        )
        distance, normal, centre, area = query(*shapes, np.eye(4), matrix)
        assert np.isfinite(normal).all() and np.isfinite(centre).all() and area >= 0
        if gap == 0:
            crossing += 1
            assert distance <= 1e-7 if not solid else -most - 1e-9 <= distance <= BAND
        elif enclosed:
            inside += 1
            assert (
                distance == pytest.approx(gap - most, abs=1e-6)
                if gap - most <= TOLERANCE
                else distance > TOLERANCE
            )
        elif gap <= TOLERANCE:
            apart += 1
            assert distance == pytest.approx(gap, abs=1e-6)
            for corners in (first.reshape(-1, 3), second.reshape(-1, 3)):
                assert (centre >= corners.min(axis=0) - gap).all() and (
                    centre <= corners.max(axis=0) + gap
                ).all()
        else:
            assert distance > TOLERANCE
    assert apart + crossing + inside >= 3


@pytest.mark.slow
def test_a_large_surface_in_parts_is_as_near_as_in_one_piece():
    """Of 40,000 triangles against one tree of all of them, and against a cylinder by closed form."""
    points, triangles = reference.box((0.3, 0.24, 0.2), 58)
    ripples = 1 + 0.02 * np.sin(40 * points[:, [1, 2, 0]])
    large = points * ripples, triangles
    small = reference.SOLIDS["torus"]
    assert len(triangles) > 40_000
    for matrix in near_poses(large, small, np.random.default_rng(11), 12):
        trees = body(*large), body(*small)
        trees[1].setTransform(fcl.Transform(matrix[:3, :3], matrix[:3, 3]))
        gap = max(fcl.distance(*trees, fcl.DistanceRequest(), fcl.DistanceResult()), 0.0)
        distance, *_ = query(Mesh(*large), Mesh(*small), np.eye(4), matrix, 0.05)
        assert distance == pytest.approx(gap, abs=1e-6) if gap > 0 else distance <= 1e-7
    for gap in (0.004, 0.0):
        distance, normal, *_ = query(
            Mesh(points, triangles), SMALL["cylinder"], np.eye(4), pose((0.1, 0.05, 0.12 + gap))
        )
        assert distance == pytest.approx(gap, abs=1e-7)
        np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-4)


@pytest.mark.parametrize("parts", [1, 7])
@pytest.mark.parametrize("below", ["slab", "shell", "hull"])
@pytest.mark.parametrize("gap", [0.01, 1e-4, 0.0, -1e-4, -0.02])
def test_a_box_on_a_slab(parts, below, gap):
    """Distance, normal, centre and area by closed form, however the faces are divided. A shell has
    no depth beyond its faces' own."""
    points, triangles = reference.box((3.0, 2.0, 0.2), parts)
    ground = (
        ConvexHull(points)
        if below == "hull"
        else Mesh(points, triangles, sunk_in=SUNK_IN * (below == "slab"))
    )
    top = Mesh(*reference.box((0.4, 0.3, 0.2), parts), sunk_in=SUNK_IN)
    distance, normal, centre, area = query(
        ground, top, pose((0, 0, -0.1)), pose((0.23, 0.11, 0.1 + gap))
    )
    assert distance == pytest.approx(gap, abs=1e-7)
    np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(centre, [0.23, 0.11, gap / 2], atol=1e-6)
    assert area == pytest.approx(0.12, rel=1e-4)


def uneven(random, flipped):
    """A shell of 2 m by 2 m with waves of up to a centimetre, its triangles seen from either
    side."""
    cells = int(random.integers(4, 24))
    along = np.linspace(-1, 1, cells + 1)
    x, y = (each.reshape(-1) for each in np.meshgrid(along, along, indexing="ij"))
    height = 10 ** random.uniform(-3.3, -2)
    waves = height * np.sin(7 * x + random.uniform(0, 6)) * np.cos(5 * y)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1)
    beside, across = corner + cells + 1, corner + cells + 2
    triangles = np.concatenate(
        [np.stack([corner, beside, across], 1), np.stack([corner, across, corner + 1], 1)]
    )
    return np.stack([x, y, waves], 1), triangles[:, ::-1] if flipped else triangles


def highest_under(points, triangles, base):
    """The height of the highest point of a surface above a convex base (k, 2), counter-clockwise:
    the triangles, clipped to it (Sutherland and Hodgman)."""
    heights = []
    for polygon in map(list, points[triangles]):
        for start, end in zip(base, np.roll(base, -1, axis=0), strict=True):
            across = np.array([start[1] - end[1], end[0] - start[0]])
            side = [float(across @ (corner[:2] - start)) for corner in polygon]
            clipped = []
            for k, corner in enumerate(polygon):
                before, height = polygon[k - 1], side[k - 1]
                if (height >= 0) != (side[k] >= 0):
                    clipped.append(before + (corner - before) * (height / (height - side[k])))
                if side[k] >= 0:
                    clipped.append(corner)
            polygon = clipped
        heights += [corner[2] for corner in polygon]
    return max(heights)


@pytest.mark.slow
@pytest.mark.parametrize("flipped", [False, True])
def test_a_block_on_uneven_ground_lies_on_the_highest_point_under_it(flipped):
    """However deep it has sunk beside the waves, it leaves the ground upwards."""
    random = np.random.default_rng(4)
    for _ in range(60):
        points, triangles = uneven(random, flipped)
        size = random.uniform(0.1, 0.5, 3)
        angle, (x, y) = random.uniform(0, 2 * np.pi), random.uniform(-0.6, 0.6, 2)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        base = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size[:2] / 2 @ turn.T + (x, y)
        depth = random.uniform(0.0, 2.0) * np.ptp(points[:, 2])
        height = highest_under(points, triangles, base) - depth
        whole = np.eye(3)
        whole[:2, :2] = turn
        distance, normal, centre, _ = query(
            Mesh(points, triangles),
            Mesh(*reference.box(tuple(size), int(random.integers(1, 5))), sunk_in=SUNK_IN),
            np.eye(4),
            pose((x, y, height + size[2] / 2), whole),
        )
        # Along the steepest part of the waves rather than upwards.
        assert -depth <= distance + 1e-6 and distance <= -depth * 0.95 + 1e-4
        assert normal[2] > 0.97
        assert abs(centre[2] - height) < depth + BAND


@pytest.mark.parametrize("flipped", [False, True])
def test_a_leaning_corner_leaves_a_shell_by_the_side_it_came_from(flipped):
    """Also where no faces lie on each other, and whichever way the shell's triangles run."""
    points = np.array([[0, 0, 0], [0.3, 0.1, 0.2], [0.5, -0.1, 0.2], [0.4, 0.1, 0.4]])
    solid = Mesh(points, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], sunk_in=SUNK_IN)
    around = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    shell = Mesh(around, faces[:, ::-1] if flipped else faces)
    _, normal, centre, _ = query(shell, solid, np.eye(4), pose((0.1, 0.2, -0.01)))
    np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-3)
    assert np.linalg.norm(centre - [0.12, 0.2, 0]) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("parts", [1, 6])
def test_patches_are_continuous(parts):
    """A concave body that sinks, tilts and slides on a slab: no step of the patch is larger than a
    few times that of the body."""
    u_shape = [
        (-0.3, -0.1),
        (0.3, -0.1),
        (0.3, 0.2),
        (0.2, 0.2),
        (0.2, 0.05),
        (-0.2, 0.05),
        (-0.2, 0.2),
        (-0.3, 0.2),
    ]
    body = Mesh(*reference.prism(u_shape, 0.3), sunk_in=SUNK_IN)
    slab = Mesh(*reference.box((3.0, 2.0, 0.3), parts), sunk_in=SUNK_IN)
    # On its back, the faces' normals being along z.
    standing = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    steps = np.linspace(0, 1, 201)
    paths = {
        "sinks": [pose((0.1, 0.05, 0.25 + 0.005 - 0.02 * t), standing) for t in steps],
        "tilts": [
            pose((0.1, 0.05, 0.25), np.array([[1, 0, 0], [0, 1, -a], [0, a, 1]]) @ standing)
            for a in 0.002 * (steps - 0.5)
        ],
        "slides": [pose((0.1 + 0.05 * t, 0.05, 0.25 - 0.002), standing) for t in steps],
    }
    for name, path in paths.items():
        found = [query(slab, body, pose((0, 0, -0.0)), matrix) for matrix in path]
        distances, normals, centres, areas = (np.array(each) for each in zip(*found, strict=True))
        assert np.abs(np.diff(distances)).max() < 4e-4, name
        assert np.abs(np.diff(normals, axis=0)).max() < 2e-2, name
        assert np.abs(np.diff(centres, axis=0)).max() < 6e-3, name
        assert np.abs(np.diff(areas)).max() < 0.05 * areas.max(), name


SMALL = {
    "mesh": Mesh(*reference.box((0.04, 0.04, 0.04)), sunk_in=SUNK_IN),
    "hull": ConvexHull(reference.box((0.04, 0.04, 0.04))[0]),
    "box": Box((0.04, 0.04, 0.04)),
    "sphere": Sphere(0.02),
    "cylinder": Cylinder(0.02, 0.04),
}


@pytest.mark.parametrize("parts", [1, 3])
@pytest.mark.parametrize("room", ["mesh", "hull"])
@pytest.mark.parametrize("small", SMALL)
@pytest.mark.parametrize("swapped", [False, True])
def test_what_is_inside_touches_down_to_a_depth(parts, room, small, swapped):
    """A fingertip in a sofa touches it, a lamp in the air of a room does not, nor what lies deep in
    the ground; whatever its shape."""
    large = reference.box((2.0, 2.0, 2.0), parts)
    room = (
        Mesh(*large, sunk_in=SUNK_IN) if room == "mesh" else ConvexHull(large[0], sunk_in=SUNK_IN)
    )
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    for beneath, touches in (
        (0.001, True),
        (0.015, True),
        (0.031, True),
        (0.033, False),
        (0.5, False),
    ):
        placed = [
            (room, pose((0, 0, 0), turn)),
            (SMALL[small], pose((0.3, 0.2, 1 - beneath - 0.02))),
        ]
        (first, a), (second, b) = placed[::-1] if swapped else placed
        distance, normal, centre, _ = query(first, second, a, b)
        assert (distance <= TOLERANCE) == touches
        if touches:
            assert distance == pytest.approx(beneath - 0.02, abs=1e-6)
            np.testing.assert_allclose(normal, [0, 0, -1 if swapped else 1], atol=1e-6)
            np.testing.assert_allclose(centre, [0.3, 0.2, 1 - beneath / 2], atol=0.021)


GROUND = Mesh(*reference.box((2.0, 2.0, 1.4), 3), sunk_in=SUNK_IN)
SINKING = {
    **{
        name: Mesh(*reference.SOLIDS[name], sunk_in=SUNK_IN)
        for name in ("box", "torus", "cup", "dumbbell", "star")
    },
    "convex box": Box((0.3, 0.24, 0.2)),
    "hull": ConvexHull(reference.SOLIDS["dumbbell"][0], sunk_in=SUNK_IN),
    "sphere": Sphere(0.15),
    "cylinder": Cylinder(0.12, 0.3),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SINKING)
@pytest.mark.parametrize("swapped", [False, True])
def test_a_body_sinks_wholly_into_a_solid(name, swapped):
    """From the air to where it touches no more: its distance changes by no more than it moves, and
    the patch doesn't jump, wherever the surfaces begin and cease to cross: where it moves far in a
    step, it moves less in smaller steps."""
    ground, body = GROUND, SINKING[name]
    corners = np.array(list(itertools.product(*np.transpose(body.local_bounds))))
    turn = rotation(np.random.default_rng(7))
    heights, step = (corners @ turn.T)[:, 2], 0.01

    def patch(below):
        """Distance, normal, centre and area with the body's bounds so far below the surface."""
        place = pose((0.21, 0.13, -below - heights.min()), turn)
        placed = [(ground, pose((0, 0, -0.7))), (body, place)]
        (first, a), (second, b) = placed[::-1] if swapped else placed
        return query(first, second, a, b)

    depths = np.arange(-0.01, np.ptp(heights) + 0.08, step)
    distance, normal, centre, area = (
        np.array(each) for each in zip(*map(patch, depths), strict=True)
    )
    (touching,) = (distance <= TOLERANCE).nonzero()
    assert len(touching) == touching[-1] - touching[0] + 1 < len(depths) - touching[0]
    assert np.abs(np.diff(distance[touching])).max() <= step + 1e-6
    assert (normal[touching, 2] * (-1 if swapped else 1)).min() > 0.5
    for values, most in ((centre, 0.02), (area[:, None], 0.05 * max(area.max(), 1e-3))):
        steps = np.linalg.norm(np.diff(values[touching], axis=0), axis=1)
        for k in np.flatnonzero(steps > most).tolist():
            ends, column = [depths[touching[k]], depths[touching[k] + 1]], 2 if most == 0.02 else 3
            for _ in range(8):
                points = [ends[0], sum(ends) / 2, ends[1]]
                between = [np.atleast_1d(patch(point)[column]) for point in points]
                far = int(np.linalg.norm(np.diff(between, axis=0), axis=1).argmax())
                ends = points[far : far + 2]
            last = np.linalg.norm(np.diff(between, axis=0)[far])
            assert last <= most / 2, (ends, between)


def test_what_is_inside_a_shell_touches_where_it_is_close():
    shell, tip = Mesh(*reference.box((2.0, 2.0, 2.0), 3)), SMALL["mesh"]
    assert query(shell, tip, np.eye(4), pose((0.3, 0.2, 1 - 0.015 - 0.02)))[0] > TOLERANCE
    assert query(shell, tip, np.eye(4), pose((0.3, 0.2, 1 - 0.005 - 0.02)))[0] == pytest.approx(
        0.005, abs=1e-7
    )


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("gap", [0.0, -0.001, 0.01])
def test_a_solid_without_a_depth_touches_as_a_shell(gap):
    """A face alone, as the Build modifier begins with: a box lies on it."""
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float64)
    triangles = np.array([(0, 1, 2), (0, 2, 3)])
    box, place = Box((0.5, 0.5, 0.5)), pose((0.1, 0.2, 0.25 + gap))
    solid, shell = (
        query(Mesh(corners, triangles, sunk_in=depth), box, np.eye(4), place)
        for depth in (SUNK_IN, 0.0)
    )
    for found, expected in zip(solid, shell, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_what_is_known_of_a_pair_has_the_bits_of_a_fresh_query():
    """Also after shapes were exchanged, of pairs in either order, of those that stay and of those
    that move."""
    random = np.random.default_rng(4)
    names = sorted(reference.SOLIDS)[:3]
    shapes = [Mesh(*reference.SOLIDS[name], sunk_in=SUNK_IN) for name in names]
    shapes += [Box((0.2, 0.1, 0.1)), Mesh(*reference.SOLIDS[names[0]])]
    places = [pose(random.uniform(-0.06, 0.06, size=3), rotation(random)) for _ in shapes]
    pairs = np.array(list(itertools.permutations(range(len(shapes)), 2)))
    warm = None
    for step in range(4):
        warm = NarrowPhase(shapes, before=warm)
        first, second = (
            np.concatenate([poses_12(places[k]) for k in side], axis=1) for side in pairs.T
        )
        asked = pairs, *relative_pose(first, second), np.full(len(pairs), TOLERANCE)
        for _ in range(2):
            known, fresh = warm.query(*asked), NarrowPhase(shapes).query(*asked)
            for name in ("distance", "normal", "centre", "area"):
                assert np.array_equal(getattr(known, name), getattr(fresh, name)), (step, name)
        shapes[step], shapes[step + 1] = shapes[step + 1], shapes[step]
        places[step] = pose(random.uniform(-0.06, 0.06, size=3), rotation(random))


def test_what_is_known_of_a_mesh_goes_with_it():
    first, second = (Mesh(*map(np.copy, reference.SOLIDS[n])) for n in sorted(reference.SOLIDS)[:2])
    warm = NarrowPhase([first, second])
    asked = np.array([[0, 1]]), np.eye(3)[..., None], np.full((3, 1), 0.01), np.array([TOLERANCE])
    warm.query(*asked)
    edited = weakref.ref(first.points)
    warm = NarrowPhase([Mesh(*reference.box((0.1, 0.1, 0.1))), second], before=warm)
    del first
    warm.query(*asked)
    gc.collect()
    assert edited() is None
