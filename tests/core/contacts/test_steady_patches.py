"""Patches move little as bodies do: a real surface is uneven by more than a millimetre. And those of
flat faces are the faces themselves."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.hull import convex_hull
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.narrow.manifold import ROUGHNESS
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.scene.values import (
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
)
from level_properties import changes_of_moved_bodies, decibels, of_measured_materials, traced

GROUND = HapticObject("ground", 0.1, 0.9, shape=Box((40, 40, 1)), pose=Pose((0, 0, -0.5)))


def corners_of(size: tuple[float, float, float]) -> np.ndarray:
    """The corners (8, 3) of a box."""
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2


def leaning(seed: int, count: int = 6) -> HapticScene:
    """Blocks on a ground and a plank on each: an edge of its end is on the ground, and its face
    lies on an upper edge of the block."""
    random = np.random.default_rng(seed)
    objects = [GROUND]
    for k in range(count):
        block, width, slope = (
            random.uniform([0.5, 0.8, 0.4], [1.0, 1.4, 1.0]),
            random.uniform(0.5, 1.2),
            random.uniform(0.15, 0.8),
        )
        place = np.array([0.0, 1.5 * k, block[2] / 2])
        top = place + np.array([block[0] / 2, 0.0, block[2] / 2])
        foot = top + np.array([block[2] / slope, 0.0, -block[2]])
        length = math.dist(top, foot)
        along = (top - foot) / length
        middle = foot + along * (length + 0.4) / 2 + 0.025 * np.array([along[2], 0, -along[0]])
        half = math.atan2(-along[2], along[0]) / 2
        for name, size, pose in (
            (f"block {k}", block, Pose(tuple(place.tolist()))),
            (
                f"plank {k}",
                (length + 0.4, width, 0.05),
                Pose(tuple(middle.tolist()), (math.cos(half), 0.0, math.sin(half), 0.0)),
            ),
        ):
            objects.append(HapticObject(name, 0.1, 0.9, shape=Box(tuple(size)), pose=pose))
    places = {item.name: item.pose.position for item in objects}
    return HapticScene(
        tuple(objects),
        (),
        tuple(Source(f"s{k}", f"block {k}", places[f"block {k}"]) for k in range(count)),
        tuple(
            Listener(f"l{k}", f"plank {k}", places[f"plank {k}"], radius=0.0) for k in range(count)
        ),
    )


def storeys(seed: int) -> HapticScene:
    """Walls and floors of two storeys with crates: patches of metres."""
    random = np.random.default_rng(seed)
    objects = [GROUND]
    for storey in range(2):
        below = 2.75 * storey
        for k, (place, size) in enumerate(
            (
                ((0, 2.9, 1.25), (6, 0.2, 2.5)),
                ((0, -2.9, 1.25), (6, 0.2, 2.5)),
                ((2.9, 0, 1.25), (0.2, 5.6, 2.5)),
                ((0, 0, 2.625), (6, 6, 0.25)),
            )
        ):
            pose = Pose((place[0], place[1], below + place[2]))
            objects.append(HapticObject(f"part {storey} {k}", 0.1, 0.9, shape=Box(size), pose=pose))
        for k in range(3):
            size = random.uniform(0.4, 1.2, 3)
            pose = Pose(
                (*random.uniform(-2, 2, 2), below + 2.75 + size[2] / 2),
                (math.cos(k), 0.0, 0.0, math.sin(k)),
            )
            crate = HapticObject(f"crate {storey} {k}", 0.1, 0.9, shape=Box(tuple(size)), pose=pose)
            objects.append(crate)
    places = {item.name: item.pose.position for item in objects[1:]}
    return HapticScene(
        tuple(objects),
        (),
        tuple(Source(f"s{k}", f"crate 0 {k}", places[f"crate 0 {k}"]) for k in range(3)),
        tuple(Listener(f"l {name}", name, place, radius=0.0) for name, place in places.items()),
    )


@pytest.mark.slow
def test_levels_through_patches_of_metres():
    scene = of_measured_materials(storeys(1))
    assert max(contacts_of_scene(scene).area) > 1
    change = changes_of_moved_bodies(scene, frozenset({"ground"}), seed=2)
    assert len(change) == 20 * 3 * 14
    assert np.percentile(change, 99) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("measured", [False, True])
def test_levels_through_edges_that_tilt_by_a_milliradian(measured):
    """Of planks and blocks that move by 1 mm and turn by 1e-3 rad: 99 % under 0.5 dB, by the
    paper's function and by those of measured materials."""
    scene = leaning(1)
    assert len(contacts_of_scene(scene)) == 18
    change = changes_of_moved_bodies(
        of_measured_materials(scene) if measured else scene, frozenset({"ground"}), seed=2
    )
    assert len(change) == 20 * 36
    assert np.percentile(change, 99) < 0.5


@pytest.mark.parametrize("tilt", [0.0, 1e-4, 1e-3])
def test_the_whole_face_of_a_box_that_rests_or_trembles_is_its_patch(tilt):
    """Of 1 m; its centre and area are those of the face."""
    box = HapticObject(
        "box",
        0.1,
        0.9,
        shape=Box((1.0, 0.8, 0.6)),
        pose=Pose((2.0, 3.0, 0.3), (math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0)),
    )
    contacts = contacts_of_scene(HapticScene((GROUND, box)))
    assert contacts.positions[0].mean(axis=0)[:2] == pytest.approx(
        [2.0, 3.0], abs=0.31 * tilt + 1e-9
    )
    assert contacts.area[0] == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("inner", [Capsule(0.1, 0.5), Cylinder(0.1, 0.5), Cone(0.1, 0.5)])
@pytest.mark.parametrize("about", [0.0, math.pi / 2])
def test_centres_beneath_the_face_of_a_room_do_not_jump(inner, about):
    """Of a round body whose highest point stays 2 cm beneath the upper face, as it tips about
    standing and lying by 4 mrad: the centre moves along it, and never beyond it."""
    angles = about + np.arange(-400, 401) * 1e-5
    turns = rotations(np.array([[0.0], [1.0], [0.0]]) * angles)
    rise, across = np.cos(angles), np.abs(np.sin(angles))
    highest = {
        Capsule: 0.1 + 0.25 * np.abs(rise),
        Cylinder: 0.1 * across + 0.25 * np.abs(rise),
        Cone: np.maximum(0.25 * rise, 0.1 * across - 0.25 * rise),
    }[type(inner)]
    places = np.stack([0 * highest, 0 * highest, 0.98 - highest])
    corners = [[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    room = ConvexHull(np.array(corners), sunk_in=0.05)
    found = NarrowPhase([room, inner]).query(
        np.tile([[0, 1]], (len(angles), 1)), turns, places, np.full(len(angles), 0.01)
    )
    assert found.distance == pytest.approx(0.02 - 0.05, abs=1e-9)
    assert np.abs(np.diff(found.centre)).max() < 0.005
    assert np.abs(found.centre[:2]).max() < 0.26


@pytest.mark.parametrize("slope", [0.0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("sunk", [0.002, -0.001])
def test_a_stone_is_felt_where_it_lies_however_its_corners_are_rounded(slope, sunk):
    """The lower face of a stone with bevelled sides, which no rotation in single precision leaves
    wholly level, on a slab."""
    width, depth, height = 0.28, 0.09, 0.011
    slab = np.array([(x, y, z) for x in (-1.6, 1.6) for y in (-4.0, 4.0) for z in (-0.1, 0.0)])
    stone = np.array(
        [
            (x, y if low else 0.7 * y, -height + slope * x if low else height)
            for x in (-width, width)
            for y in (-depth, depth)
            for low in (True, False)
        ]
    )
    place = np.array([[-0.52], [-1.4], [height - sunk]])
    narrow = NarrowPhase([ConvexHull(slab), ConvexHull(stone)])
    found = narrow.query(np.array([[0, 1]]), np.eye(3)[..., None], place, np.array([0.01]))
    assert found.area[0] == pytest.approx(4 * width * depth, rel=1e-3)
    assert found.centre[:2, 0] == pytest.approx(place[:2, 0], abs=0.01)


@pytest.mark.parametrize("uneven", [1e-7, 1e-6, 1e-5, 1e-4, 3e-4])
@pytest.mark.parametrize("cuts", [1, 2, 5])
@pytest.mark.parametrize("below", [Box((4, 4, 1)), ConvexHull(corners_of((4, 4, 1)))])
def test_the_face_of_an_uneven_mesh_is_its_patch(uneven, cuts, below):
    """Of a crate whose faces are divided and rough, as modelled and scanned ones are, the patch is
    the whole side; what it touches, its lowest point."""
    random = np.random.default_rng(cuts)
    grid = np.linspace(-0.5, 0.5, cuts + 1)
    points = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    points = points[np.abs(points).max(axis=1) == 0.5]
    points += random.uniform(-uneven, uneven, points.shape)
    found = NarrowPhase([below, ConvexHull(points)]).query(
        np.array([[0, 1]]),
        np.eye(3)[..., None],
        np.array([[0.3], [0.2], [1.0]]),
        np.array([0.012]),
    )
    assert found.distance[0] == pytest.approx(points[:, 2].min() + 0.5, abs=1e-7)
    assert found.area[0] == pytest.approx(1.0, rel=0.1)
    np.testing.assert_allclose(found.normal[:, 0], [0, 0, 1], atol=4 * uneven)
    np.testing.assert_allclose(found.centre[:, 0], [0.3, 0.2, 0.5], atol=0.03)


FEET = [np.array([x, y, 0.0]) for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
FLOOR = np.array([[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [3.0, 3.0, 0.0], [-3.0, 3.0, 0.0]])
FLOORS = {
    "box": (Box((6.0, 6.0, 1.0)), -0.5),
    "plane": (ConvexHull(FLOOR), 0.0),
    "mesh": (Mesh(FLOOR, [[0, 1, 2], [0, 2, 3]]), 0.0),
}


def table() -> Mesh:
    """One mesh of a top and four legs of 4 cm by 4 cm that end at 0."""
    boxes = [(foot + np.array([0.0, 0.0, 0.35]), (0.04, 0.04, 0.7)) for foot in FEET]
    boxes.append((np.array([0.0, 0.0, 0.72]), (1.0, 0.8, 0.04)))
    return joined([middle + corners_of(size) for middle, size in boxes])


def joined(parts: list[np.ndarray], sunk_in: float = 0.0) -> Mesh:
    """One mesh of the hulls of points (n, 3)."""
    hulls = [convex_hull(points) for points in parts]
    first = np.cumsum([0] + [len(hull.points) for hull in hulls])
    return Mesh(
        np.concatenate([hull.points for hull in hulls]),
        np.concatenate([hull.triangles + k for k, hull in zip(first, hulls, strict=False)]),
        sunk_in=sunk_in,
    )


BODIES = {
    "balls": (Compound.of(tuple((Sphere(0.02), Pose(tuple(foot))) for foot in FEET)), 0.02, 0.0),
    "capsules": (
        Compound.of(tuple((Capsule(0.02, 0.3), Pose(tuple(foot))) for foot in FEET)),
        0.17,
        0.0,
    ),
    "table": (table(), 0.0, 4 * 0.04**2),
}


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("sunk", [0.0, 0.0005])
@pytest.mark.parametrize("tilt", [0.0, 1e-4, 1e-3, 4e-3])
def test_a_body_stands_on_all_its_feet(floor, body, sunk, tilt):
    """Feet count fully up to half of `ROUGHNESS` above the lowest one, round ones as well: the
    contact is in their middle, and as large as the faces that are on the floor."""
    ground, level = FLOORS[floor]
    shape, height, area = BODIES[body]
    turned = math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0
    raised = height + 0.4 * math.sin(tilt) - sunk
    found = contacts_of_scene(
        HapticScene(
            (
                HapticObject("floor", 0.1, 0.9, shape=ground, pose=Pose((0.0, 0.0, level))),
                HapticObject("body", 0.1, 0.9, shape=shape, pose=Pose((0.0, 0.0, raised), turned)),
            ),
            (),
            (),
            (),
        )
    )
    assert len(found) == 1
    middle = found.positions[0].mean(axis=0)
    assert np.abs(middle[:2]).max() < 0.01
    assert found.area[0] == pytest.approx(area, rel=0.05)


TURN, RISE = 2 * np.pi * np.arange(16) / 16, np.pi * np.arange(9) / 8
FOOT = {
    "ball": 0.02 * np.array([(0, 0, 1)])
    - 0.02
    * np.stack(
        [
            np.outer(np.sin(RISE), np.cos(TURN)),
            np.outer(np.sin(RISE), np.sin(TURN)),
            np.outer(np.cos(RISE), np.ones(16)),
        ],
        axis=-1,
    ).reshape(-1, 3),
    "cone": np.array(
        [(0.0, 0.0, 0.0), *((0.03 * math.cos(turn), 0.03 * math.sin(turn), 0.4) for turn in TURN)]
    ),
}


def tipped(
    foot: str, places: list[np.ndarray], floor: str, tilt: float, sunk: float, sunk_in: float
) -> HapticScene:
    """A mesh with feet at these places, lifted by ``tilt`` on that side where x is negative, with
    a listener in the floor beneath each and a source above."""
    ground, level = FLOORS[floor]
    turned = math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0
    raised = max(place[0] for place in places) * math.sin(tilt) - sunk
    shape = joined([FOOT[foot] + place for place in places], sunk_in)
    return HapticScene(
        (
            HapticObject("floor", 0.1, 0.9, shape=ground, pose=Pose((0.0, 0.0, level))),
            HapticObject("body", 0.1, 0.9, shape=shape, pose=Pose((0.0, 0.0, raised), turned)),
        ),
        (),
        (Source("s", "body", (0.0, 0.0, 0.7)),),
        tuple(
            Listener(f"l{k}", "floor", tuple(place), radius=0.0) for k, place in enumerate(places)
        ),
    )


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("foot", FOOT)
@pytest.mark.parametrize("places", [FEET, FEET[:3]], ids=["four", "three"])
@pytest.mark.parametrize("sunk_in", [0.0, 0.05], ids=["shell", "solid"])
@pytest.mark.parametrize("sunk", [0.0, 0.0005])
def test_one_mesh_stands_on_all_its_round_or_pointed_feet(floor, foot, places, sunk_in, sunk):
    """Each counts as much: fully up to half of `ROUGHNESS` above the lowest, then by the square of
    what is left to `ROUGHNESS`."""
    levels = []
    for tilt in (0.0, 1e-4, 1e-3, 5e-3, 1e-2):
        scene = tipped(foot, places, floor, tilt, sunk, sunk_in)
        found = contacts_of_scene(scene)
        assert len(found) == 1
        height = np.array([0.4 - place[0] for place in places]) * math.sin(tilt)
        weight = np.clip(2 - 2 * height / ROUGHNESS, 0, 1) ** 2
        expected = weight @ np.array(places) / weight.sum()
        assert np.abs(found.positions[0].mean(axis=0) - expected)[:2].max() < 0.002
        touching = dataclasses.replace(scene, contacts=tuple(found.to_contacts(["floor", "body"])))
        levels.append(traced(touching).gain[0])
    assert decibels(levels[0], levels[1]).max() < 0.5


@pytest.mark.parametrize("floor", ["plane", "mesh"])
@pytest.mark.parametrize("thick", [0.01, 0.04, 0.7])
@pytest.mark.parametrize("sunk", [0.0, 1e-4, 5e-4])
def test_solid_feet_leave_a_floor_without_thickness_upwards(floor, thick, sunk):
    """However thin they are, and by the area of one side of the floor."""
    blocks = joined(
        [foot + np.array([0.0, 0.0, thick / 2]) + corners_of((0.04, 0.04, thick)) for foot in FEET],
        0.05,
    )
    body = HapticObject("body", 0.1, 0.9, shape=blocks, pose=Pose((0.0, 0.0, -sunk)))
    found = contacts_of_scene(
        HapticScene((HapticObject("floor", 0.1, 0.9, shape=FLOORS[floor][0]), body))
    )
    assert found.distance[0] == pytest.approx(-sunk, abs=1e-7)
    assert found.area[0] == pytest.approx(4 * 0.04**2, rel=1e-6)
    np.testing.assert_allclose(found.normal[0], [0, 0, 1], atol=1e-6)


@pytest.mark.parametrize("degrees", [1.7, 2.0, 2.5, 3.0, 5.0])
def test_crossing_edges_touch_where_they_cross(degrees):
    """Two bars of 1 m, edge on edge, cross at 0.2 m. Their ends at 0.5 m are up to 1 cm apart, and
    count less than the place where they touch."""
    bar, diagonal = Box((1.0, 0.1, 0.1)), 0.1 * math.sqrt(2.0)
    roll, turn = math.pi / 8, math.radians(degrees) / 2
    along = math.cos(roll), math.sin(roll), 0.0, 0.0
    across = (
        math.cos(turn) * math.cos(roll),
        math.cos(turn) * math.sin(roll),
        math.sin(turn) * math.sin(roll),
        math.sin(turn) * math.cos(roll),
    )
    upper = Pose((0.2, 0.0, diagonal - 5e-4), across)
    found = contacts_of_scene(
        HapticScene(
            (
                HapticObject("lower", 0.1, 0.9, shape=bar, pose=Pose((0.0, 0.0, 0.0), along)),
                HapticObject("upper", 0.1, 0.9, shape=bar, pose=upper),
            ),
            (),
            (),
            (),
        )
    )
    x, y, _ = found.positions[0].mean(axis=0)
    assert 0.19 < x < (0.35 if degrees < 3 else 0.21)
    assert abs(y) < 0.01
