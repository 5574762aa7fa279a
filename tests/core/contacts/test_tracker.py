"""The tracker against itself from scratch: what it keeps from frame to frame must be what it would
find anew."""

from __future__ import annotations

import networkx
import numpy as np
import pytest
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.contacts.tracker import ContactTracker, Endpoints
from haptic_tracing.core.message import Cause, Message
from haptic_tracing.core.scene.joint import Joint
from haptic_tracing.core.scene.values import Pose
from hypothesis import given, settings
from hypothesis import strategies as st

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
GROUND = Body("ground", Box((20, 20, 1)), motion="static")


def moved(places, turns=None):
    count = len(places)
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3, 3] = places
    if turns is not None:
        matrices[:, :3, :3] = rotations(np.asarray(turns, dtype=np.float64).T).transpose(2, 0, 1)
    return matrices


def shapes(generator, count):
    made = [
        Box((1, 0.8, 0.6)),
        Box((1, 1, 1), rounding=0.04),
        ConvexHull(CUBE, rounding=0.04),
        ConvexHull(generator.normal(size=(12, 3)) * 0.4),
        Sphere(0.5),
        Capsule(0.3, 0.5),
        Cylinder(0.4, 0.8),
        Compound.of(((Box((1, 0.2, 0.2)), Pose((0, 0, 0.3))), (Sphere(0.3), Pose()))),
        Mesh(CUBE, [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]], margin=0.02),
    ]
    return [made[k] for k in generator.integers(0, len(made), count)]


def crowd(seed, count=14, frames=12, still=0.5):
    """Random bodies that drift and turn, some by next to nothing, some not at all."""
    generator = np.random.default_rng(seed)
    bodies = [GROUND, *(Body(f"b{k}", s, 1.0) for k, s in enumerate(shapes(generator, count)))]
    place, turn = (
        generator.uniform(-1.6, 1.6, (count, 3)) * [1, 1, 0.6] + [0, 0, 1.3],
        generator.normal(size=(count, 3)),
    )
    shares = [still, *((1 - still) * np.array([0.2, 0.4, 0.4]))]
    speed = generator.normal(size=(count, 3)) * generator.choice(
        [0.0, 1e-7, 1e-3, 0.02], size=(count, 1), p=shares
    )
    sequence = []
    for frame in range(frames):
        if frame == frames // 2:
            speed = speed[::-1]
        place, turn = place + speed, turn + speed
        sequence.append(moved([(0, 0, -0.5), *place], [(0, 0, 0), *turn]))
    return bodies, sequence


def pairs_of(contacts):
    return set(map(tuple, contacts.pairs.tolist()))


def rows(contacts):
    """By pair: positions, normal, distance, area and weight."""
    columns = (
        contacts.positions.reshape(-1, 6),
        contacts.normal,
        contacts.distance,
        contacts.area,
        contacts.weight,
    )
    return dict(
        zip(map(tuple, contacts.pairs.tolist()), np.column_stack(columns).tolist(), strict=True)
    )


def assert_among(found, expected, atol):
    """Each of the rows ``found`` as in ``expected``."""
    if found:
        np.testing.assert_allclose(
            list(found.values()), [expected[pair] for pair in found], atol=atol
        )


@pytest.mark.slow
@settings(max_examples=10, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_reused_contacts_equal_fresh_ones(seed):
    bodies, sequence = crowd(seed, frames=8)
    rules = ContactSettings(slack=0.0, least_energy=1e9)
    tracker = ContactTracker(bodies, rules)
    for frame, matrices in enumerate(sequence):
        found = tracker.update(frame / 24, matrices)
        anew = ContactTracker(bodies, rules).update(0.0, matrices)
        one, other = rows(found.contacts), rows(anew.contacts)
        assert one.keys() == other.keys()
        assert_among(one, other, 1e-11)
        assert found.contacts.pairs.tolist() == sorted(found.contacts.pairs.tolist())


def test_no_queries_where_nothing_moves():
    bodies, sequence = crowd(3, still=1.0)
    tracker = ContactTracker(bodies)
    first = tracker.update(0.0, sequence[0])
    assert first.statistics.queries == first.statistics.candidates > 0
    for frame in range(1, 5):
        found = tracker.update(frame / 24, sequence[0].copy())
        assert found.contacts is first.contacts
        assert (
            found.statistics.queries == 0
            and found.statistics.avoided == first.statistics.candidates
        )


def test_bodies_that_move_together_keep_their_contacts():
    """Two crates on a turning platform: their contacts go along without a query."""
    bodies = [
        Body("platform", Box((4, 4, 0.2)), motion="kinematic"),
        Body("a", Box((1, 1, 1))),
        Body("b", ConvexHull(CUBE)),
    ]
    local = moved([(0, 0, 0), (1, 0, 0.6), (-1, 0.5, 0.6)])
    tracker = ContactTracker(bodies)
    queries = 0
    for frame in range(24):
        platform = moved([(0.5 * frame, 0, 0.1 * frame)], [(0, 0, 0.1 * frame)])[0]
        found = tracker.update(frame / 24, platform @ local)
        queries += found.statistics.queries
        for k in (0, 1):
            np.testing.assert_allclose(
                found.contacts.positions[k, 0],
                (platform @ [*local[k + 1, :2, 3], 0.1, 1])[:3],
                atol=1e-4,
            )
            np.testing.assert_allclose(found.contacts.normal[k], platform[:3, 2], atol=1e-6)
    assert queries <= 3


def test_whatever_moves_as_one_keeps_what_would_be_found_anew():
    """Boxes, a hull, a mesh and a compound on each other under any rigid motions: of those that
    touch, none is asked for again."""
    generator = np.random.default_rng(5)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    pieces = Compound.of(((Box((1, 0.2, 0.2)), Pose((0, 0, 0.3))), (Box((1, 1, 0.4)), Pose())))
    stacked = [Box((4, 4, 0.2)), Box((1, 1, 1)), ConvexHull(CUBE), Mesh(CUBE, faces), pieces]
    places = [(0, 0, 0), (1, 0, 0.595), (-1, 0.5, 0.6), (-1, 0.5, 1.59), (1, 0.2, 1.29)]
    local = moved(places, generator.normal(size=(5, 3)) * [0, 0, 0.3])
    bodies = [Body(f"b{k}", shape, motion="kinematic") for k, shape in enumerate(stacked)]
    tracker = ContactTracker(bodies)
    for frame in range(12):
        way = moved(generator.uniform(-5, 5, (1, 3)), generator.normal(size=(1, 3)))[0]
        found = tracker.update(frame / 24, way @ local)
        anew = rows(ContactTracker(bodies).update(0.0, way @ local).contacts)
        kept = rows(found.contacts)
        assert kept.keys() == anew.keys() == {(0, 1), (0, 2), (2, 3), (1, 4)}
        assert_among(kept, anew, 1e-9)
        if frame:
            assert found.statistics.queries <= found.statistics.candidates - len(anew)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_joint_conducts_at_its_pivot_while_it_is_one_point(swapped):
    """Two rods of 20 x 20 cm, which overlap by 1 cm at rest, turn about the middle of the upper
    one's end: the contact keeps the area of 0.04 m2 and the depth, and lies at the pivot."""
    names = ["lower", "upper"]
    places = [(0.0, 0.0, 0.5), (0.0, 0.0, -0.49)]
    if swapped:
        names, places = names[::-1], places[::-1]
    joint = Joint(tuple(names), tuple(places))
    rod = Box((0.2, 0.2, 1))
    bodies = [Body("lower", rod, motion="kinematic"), Body("upper", rod, motion="kinematic")]
    tracker = ContactTracker(bodies, ContactSettings(joints=(joint,)))
    for frame, angle in enumerate((0.0, 0.3, 0.9, 1.4)):
        upper = moved([(0, 0, 0)], [(angle, 0, 0)])[0]
        upper[:3, 3] = [0, 0, 0.5] - upper[:3, :3] @ [0, 0, -0.49]
        way = moved([(frame, 0, 1)], [(0, 0.2 * frame, 0)])[0]
        found = tracker.update(frame / 24, way @ np.array([np.eye(4), upper]))
        assert found.statistics.queries == 0
        np.testing.assert_allclose(found.contacts.area, [0.04], rtol=1e-6)
        np.testing.assert_allclose(found.contacts.depth, [0.01], atol=1e-9)
        middle = way @ [0, 0, 0.5, 1]
        assert np.abs(found.contacts.positions[0] - middle[:3]).max() <= 0.005 + 1e-9
    # Broken, it is as if there were none.
    apart = way @ np.array([np.eye(4), moved([(0.15, 0, 0.99)])[0]])
    found = tracker.update(5 / 24, apart)
    anew = ContactTracker(bodies).update(0.0, apart)
    assert_among(rows(found.contacts), rows(anew.contacts), 1e-9)
    np.testing.assert_allclose(found.contacts.area, [0.2 * 0.05], rtol=1e-6)


def test_contacts_begin_and_end_at_the_tolerance():
    """A contact depends on the poses alone; whether its pair has parted, on the past, see
    `test_dropped_bodies`."""
    tracker = ContactTracker(
        [GROUND, Body("ball", Sphere(0.5))], ContactSettings(tolerance=0.01, slack=0.005)
    )
    gaps = [0.02, 0.012, 0.009, 0.012, 0.0149, 0.016, 0.012, 0.0101, 0.0099]
    touching = [
        len(tracker.update(frame / 24, moved([(0, 0, -0.5), (0, 0, 0.5 + gap)])).contacts)
        for frame, gap in enumerate(gaps)
    ]
    assert touching == [0, 0, 1, 0, 0, 0, 0, 0, 1]


@pytest.mark.slow
@settings(max_examples=15, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), density=st.sampled_from([0.05, 0.2, 0.5]))
def test_contacts_on_the_way_from_sources_to_listeners_are_found(seed, density):
    """Of bodies that contacts join to a source and to a listener, all contacts are the same as when
    everything is resolved."""
    bodies, sequence = crowd(seed, frames=6)
    generator = np.random.default_rng(seed)
    count = len(bodies)
    lazy, eager = (
        ContactTracker(bodies, ContactSettings(slack=0.0)),
        ContactTracker(bodies, ContactSettings(slack=0.0)),
    )
    for frame, matrices in enumerate(sequence):
        ends = Endpoints(*(generator.random((2, count)) < density))
        some, every = lazy.update(frame / 24, matrices, ends), eager.update(frame / 24, matrices)
        found, expected = rows(some.contacts), rows(every.contacts)
        assert found.keys() <= expected.keys()
        joined = networkx.Graph(every.contacts.pairs.tolist())
        for heap in networkx.connected_components(joined):
            if ends.heard[list(heap)].any() and ends.sounding[list(heap)].any():
                assert {pair for pair in expected if pair[0] in heap} <= found.keys()
        assert_among(found, expected, 1e-3)
        assert some.impacts == every.impacts
    assert (
        len(lazy.update(1.0, sequence[-1], Endpoints(*np.zeros((2, count), dtype=bool))).contacts)
        == 0
    )


def hopping(generator, frames, rate):
    """Boxes at rest on the ground that are kicked, one after the other, and hop and slide until
    friction has stopped them; some stand on others or against a wall, and all turn a little while
    they move."""
    count = 12
    bodies = [GROUND, Body("wall", Box((20, 0.2, 3)), motion="static")]
    bodies += [
        Body(f"b{k}", Box((0.5, 0.5, 0.5)), float(10 ** generator.uniform(-1, 3)))
        for k in range(count)
    ]
    start = np.array([(1.0 * (k % 4) - 1.5, 0.8 * (k // 4) - 1.5, 0.25) for k in range(count)])
    start[-1] = start[-2] + [0, 0, 0.5]
    kick = generator.integers(2, frames - 10, count) / rate
    sideways, up = generator.normal(size=(count, 2)) * 1.5, generator.choice([0.0, 1.0, 3.0], count)
    sequence = []
    for frame in range(frames):
        since = np.maximum(frame / rate - kick, 0.0)
        place = start.copy()
        slid = np.minimum(since, 1.0)
        place[:, :2] += sideways * (slid - slid**2 / 2)[:, None]
        for k in range(count):
            left, speed = since[k], up[k]
            while speed > 0.05 and left > 2 * speed / 9.81:
                left, speed = left - 2 * speed / 9.81, 0.4 * speed
            if speed > 0.05:
                place[k, 2] += speed * left - 9.81 / 2 * left**2
        turns = np.zeros((count, 3))
        turns[:, 2] = 0.3 * slid
        sequence.append(
            moved([(0, 0, -0.5), (0, 3, 1.5), *place], [(0, 0, 0), (0, 0, 0), *turns]).astype(
                np.float32
            )
        )
    return bodies, sequence


@pytest.mark.slow
@settings(max_examples=10, derandomize=True, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    rate=st.sampled_from([24.0, 60.0]),
    energy=st.sampled_from(["as_in_the_paper", "effective"]),
)
def test_impacts_do_not_depend_on_what_is_wanted(seed, rate, energy):
    """All impacts are found where nothing sounds, and the contacts through which a listener feels
    them."""
    bodies, sequence = hopping(np.random.default_rng(seed), 40, rate)
    lazy, eager = (
        ContactTracker(bodies, ContactSettings(energy=energy, least_energy=1.0)) for _ in range(2)
    )
    ends = Endpoints(np.ones(len(bodies), dtype=bool), np.zeros(len(bodies), dtype=bool))
    for frame, matrices in enumerate(sequence):
        some, every = (
            lazy.update(frame / rate, matrices, ends),
            eager.update(frame / rate, matrices),
        )
        assert some.impacts == every.impacts
        found, all_pairs = pairs_of(some.contacts), pairs_of(every.contacts)
        assert found <= all_pairs
        if every.impacts:
            assert found == all_pairs


def test_heaps_without_a_source_or_a_listener_are_not_computed():
    """Three stacks apart from each other: with a source and a listener, with a source alone, and
    with a listener alone."""
    places = [(10.0 * k, 0, 0.5 + level) for k in range(3) for level in range(4)]
    bodies = [Body(f"b{k}", Box((1, 1, 1))) for k in range(len(places))]
    heard, sounding = np.zeros((2, len(bodies)), dtype=bool)
    heard[[0, 8]] = sounding[[3, 4]] = True
    tracker = ContactTracker(bodies)
    found = tracker.update(0.0, moved(places), Endpoints(heard, sounding))
    assert (
        found.contacts.pairs.tolist() == [[0, 1], [1, 2], [2, 3]] and found.statistics.queries == 3
    )
    everything = tracker.update(1 / 24, moved(places))
    assert len(everything.contacts) == 9


def test_a_transform_that_is_not_finite():
    bodies = [GROUND, Body("good", Sphere(0.5)), Body("lost", Sphere(0.5), 1e6)]
    tracker = ContactTracker(bodies)
    matrices = moved([(0, 0, -0.5), (0, 0, 0.5), (2, 0, 0.5)])
    assert len(tracker.update(0.0, matrices).contacts) == 2
    broken = matrices.copy()
    broken[2, 0, 3] = np.nan
    for frame in range(1, 6):
        found = tracker.update(frame / 24, broken)
        assert found.warnings == (Message.of(Cause.TRANSFORM_NOT_FINITE, "lost", object="lost"),)
        assert found.contacts.pairs.tolist() == [[0, 1]]
        assert np.isfinite(found.contacts.positions).all()
    found = tracker.update(6 / 24, matrices)
    assert found.contacts.pairs.tolist() == [[0, 1], [0, 2]]
    assert not found.warnings and not found.impacts


def test_wrong_shape_of_transforms():
    with pytest.raises(ValueError, match="transforms: expected 1 matrices"):
        ContactTracker([GROUND]).update(0.0, np.zeros((2, 4, 4)))


def test_no_bodies_and_one_body():
    assert len(ContactTracker([]).update(0.0, np.zeros((0, 4, 4))).contacts) == 0
    tracker = ContactTracker([GROUND])
    for frame in range(4):
        assert len(tracker.update(frame / 24, moved([(frame, 0, 0)])).contacts) == 0


def test_deforming_bodies_keep_their_motion():
    """A balloon that is blown up while it falls: its hull changes in every frame, and it hits
    once."""

    def balloon(frame):
        return Body("balloon", ConvexHull(CUBE * (1 + 0.01 * frame)), 10.0)

    tracker = ContactTracker([GROUND, balloon(0)])
    impacts, contacts = [], 0
    for frame in range(24):
        tracker.replace_bodies([GROUND, balloon(frame)])
        half = 0.5 * (1 + 0.01 * frame)
        z = max(half, 2.0 - 4.9 * (frame / 24) ** 2)
        found = tracker.update(frame / 24, moved([(0, 0, -0.5), (0, 0, z)]))
        impacts += found.impacts
        contacts += len(found.contacts)
    assert len(impacts) == 1 and contacts > 5


@pytest.mark.parametrize("seed", range(8))
def test_bodies_that_come_and_go_leave_the_others_as_they_are(seed):
    """Boxes fall at different times while others, far away, come and go and the list is shuffled:
    contacts and impacts are those without the others."""
    rng = np.random.default_rng(seed)
    boxes = [GROUND, *(Body(f"box {k}", Box((1, 1, 1)), 10.0) for k in range(4))]
    far = [Body(f"far {k}", Sphere(float(rng.uniform(0.1, 3))), 1.0) for k in range(6)]
    alone, tracker = ContactTracker(boxes), ContactTracker(boxes)

    def place(body, time):
        if body is GROUND:
            return (0, 0, -0.5)
        number = int(body.name.split()[1])
        if body in far:
            return (100 + 10 * number, 0, 5 * time)
        return (2 * number - 3, 0, max(0.5, 1 + 0.3 * number - 4.9 * time**2))

    def by_name(found, bodies):
        names = [body.name for body in bodies]
        touching = {
            frozenset(names[k] for k in pair): distance
            for pair, distance in zip(
                found.contacts.pairs.tolist(), found.contacts.distance.tolist(), strict=True
            )
        }
        blows = [
            (frozenset(names[k] for k in blow.objects), blow.time, blow.energy)
            for blow in found.impacts
        ]
        return touching, blows

    count = 0
    for frame in range(30):
        time = frame / 24
        there = [*boxes, *(body for body in far if rng.random() < 0.5)]
        rng.shuffle(there)
        tracker.replace_bodies(there)
        found = tracker.update(time, moved([place(body, time) for body in there]))
        expected = alone.update(time, moved([place(body, time) for body in boxes]))
        (touching, blows), (meant, hits) = by_name(found, there), by_name(expected, boxes)
        assert touching == pytest.approx(meant, abs=1e-12)
        assert [blow[0] for blow in blows] == [hit[0] for hit in hits]
        for blow, hit in zip(blows, hits, strict=True):
            assert blow[1:] == pytest.approx(hit[1:], rel=1e-9)
        count += len(hits)
    assert count == 4


def test_a_body_that_comes_while_others_move_falls_as_it_must():
    """It comes at rest 1 m above the ground and makes no impact with its first step; one that comes
    on the ground makes none at all."""
    ball, egg = (Body(name, Sphere(0.5), 2.0) for name in ("ball", "egg"))
    tracker = ContactTracker([GROUND])
    blows = []
    for frame in range(60):
        if frame == 10:
            tracker.replace_bodies([egg, GROUND, ball])
        z = max(1.5 - 9.81 / 2 * max(frame - 10, 0) ** 2 / 60**2, 0.5)
        places = [(3, 0, 0.5), (0, 0, -0.5), (0, 0, z)] if frame >= 10 else [(0, 0, -0.5)]
        blows += tracker.update(frame / 60, moved(places)).impacts
    (blow,) = blows
    assert blow.objects == (1, 2)
    assert blow.time == pytest.approx(10 / 60 + np.sqrt(2 / 9.81), abs=2e-3)
    assert blow.energy == pytest.approx(2.0 * 9.81, rel=0.03)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"tolerance": -1}, "tolerance"),
        ({"slack": float("nan")}, "slack"),
        ({"full_energy": 0}, "full_energy"),
        ({"time_scale": 0}, "time_scale"),
        ({"gravity": (0, 0)}, "gravity"),
        ({"energy": "loud"}, "loud"),
    ],
)
def test_bad_settings(values, word):
    with pytest.raises(ValueError, match=word):
        ContactSettings(**values)


def test_what_is_known_of_shapes_that_stay_is_kept():
    """Contacts are those of a new tracker after one of two meshes has been replaced; the surface of
    the other is not made again."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    still, before, after = (
        Mesh(points * size, triangles, sunk_in=0.05) for size in (1.0, 0.5, 0.7)
    )
    transforms = np.tile(np.eye(4), (2, 1, 1))
    transforms[1, :3, 3] = 0.3, 0.3, -0.5
    tracker = ContactTracker([Body("still", still), Body("changes", before)])
    tracker.update(0.0, transforms)
    kept = tracker._table.narrow._kept[0]
    tracker.replace_bodies([Body("still", still), Body("changes", after)])
    found = tracker.update(0.1, transforms).contacts
    fresh = (
        ContactTracker([Body("still", still), Body("changes", after)])
        .update(0.1, transforms)
        .contacts
    )
    assert tracker._table.narrow._kept[0] is kept
    for name in ("pairs", "positions", "normal", "distance", "area"):
        np.testing.assert_array_equal(getattr(found, name), getattr(fresh, name))
    assert len(fresh) == 1


def test_parts_that_move_make_the_contacts_of_a_new_tracker():
    """A compound whose parts move while its body stands, beside one that stays: to the bit."""
    generator = np.random.default_rng(3)
    hulls = [ConvexHull(generator.normal(size=(20, 3)) * 0.1) for _ in range(5)]
    flat = ConvexHull([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]], sunk_in=0.05)

    def figure(frame):
        places = generator.normal(size=(5, 3)) * 0.05 + [0.3 * np.arange(5).mean(), 0, 0.06]
        turns = generator.normal(size=(5, 4))
        return Compound.of(
            tuple(
                (hull, Pose((0.3 * k + place[0], *place[1:]), tuple(turn)))
                for k, (hull, place, turn) in enumerate(zip(hulls, places, turns, strict=True))
            )
        )

    others = [GROUND, Body("stays", figure(0)), Body("flat", flat)]
    transforms = moved([(0, 0, -0.5), (0, 1, 0), (0.2, -0.2, 0.05), (0, 0, 0)])
    tracker = ContactTracker([*others, Body("moves", figure(0))])
    touching = 0
    for frame in range(8):
        bodies = [*others, Body("moves", figure(frame))]
        tracker.replace_bodies(bodies)
        found = tracker.update(frame / 24, transforms).contacts
        fresh = ContactTracker(bodies).update(0.0, transforms).contacts
        touching += len(fresh)
        near = found.distance <= tracker.settings.tolerance
        assert near.all()
        for name in ("pairs", "positions", "normal", "distance", "area", "weight"):
            np.testing.assert_array_equal(getattr(found, name), getattr(fresh, name))
    assert touching > 16
