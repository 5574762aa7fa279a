"""Contacts as continuous functions of the poses: centre, area and weight of boxes that rest, tip,
slide and part."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.hull import convex_hull
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Box, ConvexHull, Mesh, Sphere
from haptic_tracing.core.contacts.tracker import ContactTracker
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.scene.functions import Constant
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Pose
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull as SciPyHull
from scipy.spatial import HalfspaceIntersection
from scipy.spatial.transform import Rotation

BRICK = np.array([1.0, 0.5, 0.5])
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def bevelled(bevel):
    """A brick whose edges are cut off, as far as ``bevel`` along both faces."""
    return ConvexHull(
        np.concatenate([CORNERS * (BRICK / 2 - bevel * (1 - axis)) for axis in np.eye(3)])
    )


def rotation_vector(turn, first):
    """The rotation vector of a ``turn`` after that of ``first``."""
    return (Rotation.from_rotvec(turn) * Rotation.from_rotvec(first)).as_rotvec()


def placed(places, turns):
    matrices = np.tile(np.eye(4), (len(places), 1, 1))
    matrices[:, :3, 3] = places
    matrices[:, :3, :3] = rotations(np.asarray(turns, dtype=np.float64).T).transpose(2, 0, 1)
    return matrices


def contact(shapes, places, turns):
    """Centre, area, weight and distance of the one contact of two bodies, or None."""
    found = (
        ContactTracker([Body("a", shapes[0]), Body("b", shapes[1])])
        .update(0.0, placed(places, turns))
        .contacts
    )
    return (
        None
        if len(found) == 0
        else (found.positions[0].mean(axis=0), found.area[0], found.weight[0], found.distance[0])
    )


BRICKS = (Box(tuple(BRICK)), Box(tuple(BRICK)))
SLAB = (
    Mesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]]),
    Box(tuple(BRICK)),
)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    slide=st.tuples(st.floats(-0.8, 0.8), st.floats(-0.3, 0.3)),
    gap=st.floats(-5e-4, 5e-4),
    tilt=st.tuples(st.floats(-4e-4, 4e-4), st.floats(-4e-4, 4e-4)),
)
# Edges as far apart as those that coincide may be.
@example(slide=(0.0, 0.0), gap=0.0, tilt=(1e-9, 0.0))
@example(slide=(1e-9, 0.0), gap=0.0, tilt=(1e-9, 0.0))
def test_a_resting_face_is_the_overlap_of_the_faces(slide, gap, tilt):
    """Whatever a resting brick trembles by: the patch is the rectangle that both faces cover."""
    centre, area, weight, _ = contact(
        BRICKS, [(0, 0, 0), (*slide, 0.5 + gap)], [(0, 0, 0), (*tilt, 0)]
    )
    sides = BRICK[:2] - np.abs(slide)
    assert area == pytest.approx(sides.prod(), abs=3e-4 * BRICK[:2].sum())
    np.testing.assert_allclose(centre[:2], np.array(slide) / 2, atol=3e-4)
    assert weight == 1.0


STEP = 1e-5


@pytest.mark.parametrize("shapes", [BRICKS, SLAB], ids=["brick on brick", "brick on mesh"])
@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), tilt=st.sampled_from([0.0, 1e-4, 1e-3]))
def test_a_brick_that_tips_and_slides(shapes, seed, tilt):
    """Small steps move the centre of a resting patch by at most its lever arm (the face over the
    patch's gap) times the step."""
    generator = np.random.default_rng(seed)
    half = 0.25 if shapes is BRICKS else 0.0
    place = np.array(
        [*generator.uniform(-0.35, 0.35, 2), half + 0.25 + generator.uniform(-1e-3, 1e-3)]
    )
    turn = np.array([*generator.normal(size=2) * tilt, generator.uniform(-0.5, 0.5)])
    before = contact(shapes, [(0, 0, 0), place], [(0, 0, 0), turn])
    place += generator.uniform(-1, 1, 3) * STEP
    turn += generator.uniform(-1, 1, 3) * STEP
    after = contact(shapes, [(0, 0, 0), place], [(0, 0, 0), turn])
    assert np.linalg.norm(after[0] - before[0]) < 1000 * STEP
    assert abs(after[1] - before[1]) < 1000 * STEP
    assert abs(after[2] - before[2]) < 1000 * STEP


@settings(max_examples=80, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), apart=st.tuples(st.floats(-1e-3, 8e-3), st.floats(-1e-3, 8e-3)))
def test_diagonal_bricks(seed, apart):
    """Edges that lie along each other: the centre stays in the middle of what both have in common,
    however they tremble, and they weigh as much as faces that are as near."""
    generator = np.random.default_rng(seed)
    along = generator.uniform(-0.3, 0.3)
    turns = generator.uniform(-1e-4, 1e-4, (2, 3))
    found = contact(BRICKS, [(0, 0, 0), (1 + apart[0], along, 0.5 + apart[1])], turns)
    if found is None:
        assert np.hypot(*np.maximum(apart, 0.0)) > 0.0098
        return
    centre, _, weight, distance = found
    np.testing.assert_allclose(
        centre, [0.5 + apart[0] / 2, along / 2, 0.25 + apart[1] / 2], atol=0.06
    )
    face = contact(BRICKS, [(0, 0, 0), (0, 0, 0.5 + distance)], np.zeros((2, 3)))
    assert weight == pytest.approx(face[2], abs=1e-6)


EDGE, DIAGONAL = (np.pi / 4, 0.0, 0.0), 0.5 * np.sqrt(2.0)
CORNER = np.arctan2(1.0, DIAGONAL)
"""Turn about y that puts the corner lowest of a brick that stands on an edge."""


@pytest.mark.parametrize(
    ("turn", "other", "apart"),
    [
        (EDGE, EDGE, DIAGONAL),
        (rotation_vector((0.0, 0.0, np.pi / 2), EDGE), EDGE, DIAGONAL),
        (rotation_vector((0.0, 0.0, 0.2), EDGE), EDGE, DIAGONAL),
        (EDGE, (0.0, 0.0, 0.0), 0.25 + DIAGONAL / 2),
        (rotation_vector((0.0, CORNER, 0.0), EDGE), (0.0, 0.0, 0.0), 0.25 + 0.5 * np.sqrt(1.5)),
    ],
    ids=["edges along", "edges across", "edges aslant", "edge on face", "corner on face"],
)
@pytest.mark.parametrize("gap", [0.001, 0.003, 0.005, 0.006, 0.008])
def test_edges_weigh_as_much_whatever_shape_says_that_they_are_there(turn, other, apart, gap):
    """Bricks as boxes, as meshes, and as the hulls that are left as their edges are bevelled by ever
    less: by the distance alone, as no bevel is too small to be a round edge."""
    hull = convex_hull(CORNERS * BRICK / 2)
    found = {
        "box": BRICKS[0],
        "mesh": Mesh(hull.points, hull.triangles),
        "solid": Mesh(hull.points, hull.triangles, sunk_in=0.05),
        **{bevel: bevelled(bevel) for bevel in (1e-3, 1e-4, 1e-5)},
    }
    weight = {}
    for name, shape in found.items():
        *_, weight[name], distance = contact(
            (shape, shape), [(0, 0, 0), (0, 0, apart + gap)], [other, turn]
        )
        assert distance == pytest.approx(gap, abs=1e-6 + 2 * (0 if isinstance(name, str) else name))
    share = min(max((gap - 0.002) / 0.008, 0.0), 1.0)
    expected = 1 - share * share * (3 - 2 * share)
    for name in ("box", "mesh", "solid"):
        assert weight[name] == pytest.approx(expected, rel=1e-3)
    error = [abs(weight[bevel] - weight["box"]) for bevel in (1e-3, 1e-4, 1e-5)]
    assert error[0] >= error[1] >= error[2]
    assert abs(20 * np.log10(weight[1e-5] / weight["box"])) < 0.2


@pytest.mark.slow
@pytest.mark.parametrize(
    "shapes", [BRICKS, (Box(tuple(BRICK)), Sphere(0.25))], ids=["face", "ball"]
)
def test_weight_falls_smoothly_to_the_tolerance(shapes):
    gaps = np.arange(-0.002, 0.01, 2e-5)
    weights = np.array(
        [contact(shapes, [(0, 0, 0), (0, 0, 0.5 + gap)], np.zeros((2, 3)))[2] for gap in gaps]
    )
    assert (weights[gaps <= 0.002] == 1).all()
    assert (np.diff(weights) <= 1e-12).all()
    assert np.abs(np.diff(weights)).max() < 0.02
    assert weights[-1] < 1e-3
    assert contact(shapes, [(0, 0, 0), (0, 0, 0.51001)], np.zeros((2, 3))) is None


def test_weight_multiplies_what_a_contact_passes_on():
    bodies = (HapticObject("a", 0.1, 0.9), HapticObject("b", 0.1, 0.9))
    for weight, gain in ((1.0, 0.5), (0.25, 0.125)):
        touching = Contact(
            ("a", "b"), ((0, 0, 0), (0, 0, 0)), transmission=Constant(gain_value=0.5), weight=weight
        )
        graph = graph_of_scene(HapticScene(bodies, (touching,)))
        assert graph.transmission_loss[0] == pytest.approx([-np.log(gain)] * 2)


def test_a_trembling_pile_is_traced_like_a_fresh_one():
    generator = np.random.default_rng(3)
    bodies = [Body(f"b{k}", Box(tuple(BRICK)), 1.0) for k in range(6)]
    places = np.array([(0.3 * k, 0.0, 0.5 * k) for k in range(6)])
    tracker = ContactTracker(bodies)
    for frame in range(20):
        matrices = placed(
            places + generator.normal(size=(6, 3)) * 3e-6, generator.normal(size=(6, 3)) * 3e-6
        )
        live = tracker.update(frame / 24, matrices).contacts
        fresh = ContactTracker(bodies).update(0.0, matrices).contacts
        for name in ("pairs", "positions", "normal", "distance", "area", "weight"):
            assert getattr(live, name).tobytes() == getattr(fresh, name).tobytes()


def test_scenes_at_rest_have_weights():
    objects = [
        HapticObject(name, 0.1, 0.9, shape=BRICKS[0], pose=Pose((0, 0, z)))
        for name, z in (("a", 0), ("b", 0.5), ("c", 1.006))
    ]
    found = contacts_of_scene(HapticScene(tuple(objects)))
    assert found.weight[0] == 1.0 and 0 < found.weight[1] < 1
    assert [c.weight for c in found.to_contacts(["a", "b", "c"])] == found.weight.tolist()


def ball(radius, count=400):
    """A hull with corners all over a sphere (a Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * k / count), np.pi * (1 + 5**0.5) * k
    return ConvexHull(
        radius
        * np.stack(
            [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1
        )
    )


BALL = ball(0.2)


def common_section(placed_points, middle, normal):
    """By SciPy: area of what convex hulls have in common with each other and a plane."""
    u = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.7 else [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    frame = np.stack([u, np.cross(normal, u)], axis=1)
    planes = np.concatenate([SciPyHull(points).equations for points in placed_points])
    flat = np.column_stack([planes[:, :3] @ frame, planes[:, :3] @ middle + planes[:, 3]])
    return SciPyHull(HalfspaceIntersection(flat, np.zeros(2)).intersections).volume


@pytest.mark.slow
@settings(max_examples=30, derandomize=True, deadline=None)
@given(overlap=st.floats(0.006, 0.03), seed=st.integers(0, 10**6))
def test_overlapping_round_hulls_have_the_area_of_their_common_section(overlap, seed):
    """Though two of their faces have a sliver in common."""
    generator = np.random.default_rng(seed)
    way = generator.normal(size=3)
    way *= (0.4 - overlap) / np.linalg.norm(way)
    # Beside the two, a ball on a box: pairs of several kinds are looked at together.
    poses = placed(
        [(0, 0, 0), way, (3, 0, 0), (3, 0, 0.69)],
        [(0, 0, 0), generator.uniform(-3, 3, 3), (0, 0, 0), (0, 0, 0)],
    )
    bodies = [Body("a", BALL), Body("b", BALL), Body("c", Box((1.0, 1.0, 1.0))), Body("d", BALL)]
    found = ContactTracker(bodies).update(0.0, poses).contacts
    assert found.pairs.tolist() == [[0, 1], [2, 3]]
    points = [np.array(BALL.points) @ pose[:3, :3].T + pose[:3, 3] for pose in poses[:2]]
    expected = common_section(points, found.positions[0].mean(axis=0), found.normal[0])
    assert found.area[0] == pytest.approx(expected, rel=0.05)
    # Of the order of the balls' own circle, R² - (R - d / 2)².
    assert expected > 0.5 * np.pi * 0.2 * (overlap - 0.004)


@pytest.mark.slow
@settings(max_examples=30, derandomize=True, deadline=None)
@given(overlap=st.floats(0.01, 0.03), seed=st.integers(0, 10**6))
# The direction of the least depth changes by 4 degrees in the first step.
@example(overlap=0.014599683589925673, seed=29)
def test_the_area_of_overlapping_round_hulls_is_continuous(overlap, seed):
    """Between any two poses in which the bodies are deepest in each other along the same direction:
    it is the area across this one."""
    generator = np.random.default_rng(seed)
    way, turn = generator.normal(size=3), generator.uniform(-3, 3, 3)
    way /= np.linalg.norm(way)
    shapes, turns = (BALL, BALL if seed % 2 else Box((1.0, 1.0, 0.4))), [(0, 0, 0), turn]
    place = way * (0.4 - overlap) if seed % 2 else np.array([0.0, 0.0, -(0.4 - overlap)])
    if seed % 2 == 0:
        turns = [turn, (0, 0, 0)]
    bodies = [Body("a", shapes[0]), Body("b", shapes[1])]
    poses = [
        placed([(0, 0, 0), place + way * STEP * k], [turns[0], np.array(turns[1]) + STEP * k])
        for k in range(6)
    ]
    found = [ContactTracker(bodies).update(0.0, pose).contacts for pose in poses]
    areas, normals = (
        np.array([each.area[0] for each in found]),
        np.array([each.normal[0] for each in found]),
    )
    same = np.linalg.norm(np.diff(normals, axis=0), axis=1) < 100 * STEP
    assert same.sum() >= 4
    # A circle of area A over a step s of depth changes by 2 pi R s; turned facets by less.
    assert np.abs(np.diff(areas)[same]).max() < 20 * STEP
