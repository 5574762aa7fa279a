"""Contacts in Blender scenes: bad geometry is named and the rest goes on; jumps make no impacts;
simulated falls hit as mechanics says."""

import math

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.session import session
from written_scenes import read_scene


def problems():
    return {problem.object: problem.message for problem in session.problems_of(bpy.context.scene)}


def add_mesh(name, corners, faces=(), edges=(), body=None, location=(0, 0, 0)):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, edges, faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.location = location
    if body is not None:
        with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
            bpy.ops.rigidbody.object_add(type="PASSIVE")
        obj.rigid_body.collision_shape = body
    obj.haptics.enabled = True
    return obj


@pytest.fixture
def bench(add_box):
    """A plank with a source and a box on it that listens: what goes on whatever else is wrong."""
    plank, box = (
        add_box("plank", (0, 0, 0), (4, 1, 0.2)),
        add_box("box", (1.5, 0, 0.35), (0.5, 0.5, 0.5)),
    )
    plank.haptics.source.enabled = box.haptics.listener.enabled = True
    return plank, box


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@pytest.mark.parametrize(
    ("corners", "faces", "body", "word"),
    [
        ([(0, 0, 0)], (), None, "one place"),
        ([(0, 0, 0)], (), "CONVEX_HULL", "one place"),
        ([(0, 0, 0), (1, 0, 0)], (), "MESH", "no faces"),
        ([], (), "MESH", "no vertices"),
        (SQUARE, ((0, 1, 2, 3),), "BOX", "greater than 0"),
        (
            [(0, 0, 0), (1, 0, 0), (1, 1, float("inf")), (0, 1, 0)],
            ((0, 1, 2, 3),),
            "CONVEX_HULL",
            "not finite",
        ),
        (
            [(0, 0, 0), (1, 0, 0), (1, 1, float("nan")), (0, 1, 0)],
            ((0, 1, 2, 3),),
            "MESH",
            "not finite",
        ),
    ],
)
def test_shapes_that_are_none_are_named_and_the_rest_goes_on(
    bench, traced, corners, faces, body, word
):
    add_mesh("broken", corners, faces, body=body)
    bpy.context.view_layer.update()
    result = traced()
    assert result.amplitudes[0, 0] > 0
    assert word in problems()["broken"], problems()["broken"]


@pytest.mark.parametrize("body", [None, "CONVEX_HULL", "MESH"])
def test_flat_and_self_intersecting_meshes_take_part(bench, traced, body):
    flat = add_mesh(
        "flat",
        SQUARE,
        ((0, 1, 2, 3),),
        body=body,
        location=(-1.5, -0.5, 0.105 if body != "MESH" else 0.14),
    )
    crossed = [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0), (0.5, 0.5, 1)]
    add_mesh(
        "knot",
        crossed,
        ((0, 1, 4), (2, 3, 4), (0, 1, 2), (1, 0, 3)),
        body=body,
        location=(-0.5, -0.5, flat.location.z),
    )
    bpy.context.view_layer.update()
    result = traced()
    touching = {
        frozenset(result.objects[k] for k in pair) for pair in result.contacts.pairs.tolist()
    }
    assert {frozenset(("plank", "flat")), frozenset(("plank", "knot"))} <= touching
    assert problems() == {}


@pytest.mark.slow
def test_a_mesh_of_two_million_triangles(bench, traced):
    side = 1001
    x, y = np.meshgrid(np.arange(side) / side, np.arange(side) / side)
    corners = np.stack([x.ravel(), y.ravel(), 0.01 * np.sin(20 * x.ravel())], axis=1)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.stack([first, first + 1, first + side + 1, first + side], axis=1)
    mesh = bpy.data.meshes.new("terrain")
    mesh.vertices.add(len(corners))
    mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new("terrain", mesh)
    bpy.context.scene.collection.objects.link(obj)
    with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    obj.rigid_body.collision_shape = "MESH"
    obj.haptics.enabled = True
    bpy.context.view_layer.update()
    assert traced().amplitudes[0, 0] > 0
    assert "2,000,000" in problems()["terrain"]
    obj.rigid_body.collision_shape = "CONVEX_HULL"
    obj.location = (-1.5, -0.5, 0.115)
    bpy.context.view_layer.update()
    result = traced()
    assert problems() == {}
    assert ["plank", "terrain"] in [
        sorted(result.objects[k] for k in pair) for pair in result.contacts.pairs.tolist()
    ]


@pytest.fixture
def drop(add_box, scene):
    """A box that falls from 2 m onto a floor, simulated by Blender."""
    add_box("floor", (0, 0, -0.5), (20, 20, 1), "PASSIVE")
    box = add_box("box", (0, 0, 2.5), (1, 1, 1), "ACTIVE", mass=10.0)
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    box.rigid_body.linear_damping = 0.0
    scene.rigidbody_world.substeps_per_frame = 40
    return box


def played(scene, frames):
    found = []
    for frame in frames:
        scene.frame_set(frame)
        result = session.result_of(scene)
        found += [(frame, impact) for impact in result.impacts]
    return found


@pytest.mark.parametrize(
    ("rate", "gravity", "scale"),
    [(24, 9.81, 1.0), (60, 9.81, 1.0), (24, 1.62, 1.0), (25, 9.81, 0.5)],
)
def test_a_simulated_fall_hits_with_its_potential_energy(drop, scene, rate, gravity, scale):
    scene.render.fps = rate
    scene.gravity = (0, 0, -gravity)
    scene.rigidbody_world.time_scale = scale
    fall = math.sqrt(2 * 2.0 / gravity) / scale
    found = played(scene, range(1, math.ceil(fall * rate) + 4))
    _, first = found[0]
    assert first.energy == pytest.approx(10 * gravity * 2.0, rel=0.03)
    # Blender's simulation begins in the first interval, by a part of a substep.
    assert first.time == pytest.approx(fall, abs=0.002 + 1 / rate / 40)


@pytest.mark.parametrize("own", [[0], [3], [3, 0]])
def test_bodies_without_a_common_collision_collection_make_no_blow(drop, scene, tmp_path, own):
    """As Blender's simulation has it, in which they fall through each other."""
    drop.rigid_body.collision_collections = [k in own for k in range(20)]
    blows = played(scene, range(1, 26))
    passes = drop.matrix_world.translation.z < -0.5
    assert passes == (0 not in own)
    assert len(blows) == (0 if passes else 1)
    assert passes or len(session.result_of(scene).contacts.pairs)
    path = tmp_path / "scene.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(path))
    of_file = {item.name: item.layers for item in read_scene(path).objects}
    assert of_file == {"box": sum(1 << k for k in own), "floor": 1}


@pytest.mark.parametrize(
    "joint",
    [
        {"disable_collisions": True},
        {"disable_collisions": True, "enabled": False},
        {"disable_collisions": True, "use_breaking": True, "breaking_threshold": 0.01},
        {"disable_collisions": False},
        {"disable_collisions": True, "object1": None},
    ],
)
def test_bodies_of_a_constraint_that_disables_collisions_make_no_blow(
    drop, add_empty, scene, tmp_path, joint
):
    """Blender's simulation lets them pass through each other. A script's edit counts in the next
    frame, and files name the pair."""
    hinge = add_empty("hinge", (0, 0, 2.5), None)
    bpy.context.view_layer.objects.active = hinge
    bpy.ops.rigidbody.constraint_add(type="GENERIC")
    constraint = hinge.rigid_body_constraint
    constraint.object1, constraint.object2 = drop, bpy.data.objects["floor"]
    scene.frame_set(1)
    assert session.result_of(scene) is not None
    for key, value in joint.items():
        setattr(constraint, key, value)
    if "use_breaking" in joint:
        constraint.type = "FIXED"
    blows = played(scene, range(1, 20))
    passes = drop.matrix_world.translation.z < 0
    assert passes == (joint["disable_collisions"] and "object1" not in joint)
    assert len(blows) == (0 if passes else 1)
    assert session.result_of(scene).contacts.pairs.tolist() == [[0, 1]]
    path = tmp_path / "scene.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(path))
    rules = read_scene(path).rules
    assert rules.passing == ((("box", "floor"),) if passes else ())


@pytest.fixture
def animated(add_box, scene):
    """A crate of 5 kg that animation moves, above a floor."""
    add_box("floor", (0, 0, -0.5), (20, 20, 1), "PASSIVE")
    crate = add_box("crate", (0, 0, 6), (1, 1, 1), "ACTIVE", mass=5.0)
    crate.rigid_body.kinematic = True
    crate.haptics.source.enabled = crate.haptics.listener.enabled = True
    return crate


def keyed(owner, path, *keys, interpolation="LINEAR"):
    for frame, value in keys:
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    for curve in compatibility.fcurves_of(owner.id_data):
        for point in curve.keyframe_points:
            point.interpolation = interpolation


def _own(crate, add_empty, interpolation):
    keyed(crate, "location", (9, (0, 0, 6)), (10, (0, 0, 0.5)), interpolation=interpolation)


def _of_its_parent(crate, add_empty, interpolation):
    truck = crate.parent = add_empty("truck", (0, 0, 0), None)
    keyed(truck, "location", (9, (0, 0, 0)), (10, (0, 0, -5.5)), interpolation=interpolation)


def _by_a_constraint(crate, add_empty, interpolation):
    follows = crate.constraints.new("COPY_LOCATION")
    follows.target = add_empty("place", (0, 0, 0.5), None)
    keyed(follows, "influence", (9, 0.0), (10, 1.0), interpolation=interpolation)


def _between_frames(crate, add_empty, interpolation):
    keyed(crate, "location", (9.2, (0, 0, 6)), (9.8, (0, 0, 0.5)), interpolation=interpolation)


@pytest.mark.parametrize("how", [_own, _of_its_parent, _by_a_constraint, _between_frames])
@pytest.mark.parametrize("interpolation", ["CONSTANT", "LINEAR"])
def test_a_body_that_keys_set_elsewhere_without_a_motion_makes_no_blow(
    animated, add_box, add_empty, scene, how, interpolation
):
    how(animated, add_empty, interpolation)
    actor = add_box("actor", (8, 0, 3), (1, 1, 1))  # which comes at the cut
    keyed(actor, "hide_viewport", (1, True), (10, False))
    blows = played(scene, range(1, 14))
    result = session.result_of(scene)
    assert [[result.objects[k] for k in pair] for pair in result.contacts.pairs] == [
        ["crate", "floor"]
    ]
    # Of a constraint no curve tells that it moves the crate there, within a frame, from rest.
    moves = interpolation == "LINEAR" and how is not _by_a_constraint
    assert [frame for frame, _ in blows] == ([10] if moves else [])


@pytest.mark.parametrize(("begin", "end", "frames"), [(3.2, 0.5, [10, 19, 28]), (0.5, 3.2, [])])
def test_a_cycle_strikes_by_its_motion_and_not_where_it_begins_again(
    animated, scene, begin, end, frames
):
    """Down to the floor in 8 frames, and up at once; and the other way round."""
    keyed(animated, "location", *((k, (0, 0, z)) for k, z in ((1, begin), (2, begin), (10, end))))
    for curve in compatibility.fcurves_of(animated):
        curve.modifiers.new("CYCLES")
    blows = played(scene, range(1, 30))
    assert [frame for frame, _ in blows] == frames
    for _, blow in blows:
        assert blow.energy == pytest.approx(5 / 2 * (2.7 * 24 / 8) ** 2, rel=0.01)


def test_a_crate_that_stops_just_above_the_floor_strikes_it(animated, scene):
    """Two millimetres above, at a frame after which nothing moves."""
    keyed(animated, "location", (1, (0, 0, 1.502)), (9, (0, 0, 0.502)))
    ((frame, blow),) = played(scene, range(1, 14))
    assert frame == 10
    assert blow.energy == pytest.approx(5 / 2 * 3.0**2, rel=0.01)


def test_constant_keys_strike_nothing(animated, scene):
    """They move by less than their size at no time, so that no speed is theirs."""
    path = [(frame, (0, 0, max(0.5, 3.1 - 0.1 * frame * 2))) for frame in range(1, 30, 2)]
    keyed(animated, "location", *path, interpolation="CONSTANT")
    assert played(scene, range(1, 28)) == []


def test_jumps_rate_changes_and_subframes_make_no_impacts(drop, scene):
    played(scene, range(1, 12))
    assert played(scene, [40, 41]) == []
    assert played(scene, [1, 2]) == []
    played(scene, range(3, 12))
    scene.render.fps = 60
    assert played(scene, [12, 13]) == []
    scene.render.fps = 24
    scene.frame_set(1)
    played(scene, range(2, 10))
    scene.frame_set(15, subframe=0.5)
    assert session.result_of(scene).impacts == ()


@pytest.mark.parametrize("step", [2, 3, 4, 5])
@pytest.mark.parametrize("damping", [0.0, 0.04])
def test_dropped_frames_of_playback_lose_no_blow(drop, scene, monkeypatch, step, damping):
    """With *Frame Dropping* or *Sync to Audio* the fall ends with the same blow; after more than a
    tenth of a second with one of the mean speed, which is less."""
    drop.rigid_body.linear_damping = damping
    monkeypatch.setattr(session, "is_playing", lambda: True)
    ((_, whole),) = played(scene, range(1, 31))
    for first in range(1, step + 1):
        (frame, blow), *others = played(scene, range(first, 31, step))
        assert all(bounce.energy < 0.05 * whole.energy for _, bounce in others)
        assert frame - step < 1 + 24 * whole.time <= frame
        if step == 2:
            assert blow.time == pytest.approx(whole.time, abs=0.002)
            assert blow.energy == pytest.approx(whole.energy, rel=0.02)
        assert blow.energy <= 1.02 * whole.energy
    scene.frame_set(1)
    assert played(scene, [20]) == []  # too long a gap to say what happened in it


def test_the_same_timeline_twice_gives_the_same_bits(drop, scene):
    runs = []
    for _ in range(2):
        blocks = []
        for frame in range(1, 25):
            scene.frame_set(frame)
            result = session.result_of(scene)
            blocks.append(
                (result.impacts, result.amplitudes.tobytes(), result.contacts.positions.tobytes())
            )
        runs.append(blocks)
    assert runs[0] == runs[1]


def test_statistics_tell_what_blender_took_and_what_was_skipped(drop, scene):
    scene.frame_set(1)
    result = session.result_of(scene)
    assert set(result.milliseconds) >= {"read", "broad", "narrow", "graph", "propagate", "mix"}
    assert result.statistics["blender_milliseconds"] > 0
    assert {"candidate_pairs", "contact_queries", "queries_avoided"} <= set(result.statistics)


def test_energy_of_the_blow_is_the_scenes(drop, scene):
    drop.rigid_body.restitution = bpy.data.objects["floor"].rigid_body.restitution = 1.0
    scene.rigidbody_world.substeps_per_frame = 10
    bounces = played(scene, range(1, 60))
    assert len(bounces) >= 2
    scene.haptics.impact_energy = "as_in_the_paper"
    scene.frame_set(1)
    found = played(scene, range(2, 60))
    assert len(found) == len(bounces)
    # The floor can't be pushed: all of the energy is that of the blow.
    assert found[0][1].energy == pytest.approx(bounces[0][1].energy, rel=0.01)


@pytest.mark.parametrize("way", ["shape key", "armature", "modifier"])
def test_a_deforming_mesh_touches_where_its_hull_is_in_the_frame(add_box, scene, way):
    block, lid = add_box("block", (0, 0, 0), (1, 1, 1)), add_box("lid", (0, 0, 1.3), (1, 1, 1))
    block.haptics.source.enabled = lid.haptics.listener.enabled = True
    if way == "shape key":
        block.shape_key_add(name="Basis")
        key = block.shape_key_add(name="taller")
        for k, vertex in enumerate(block.data.vertices):
            if vertex.co.z > 0:
                key.data[k].co.z += 0.3
        for frame, value in ((1, 0.0), (11, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
    elif way == "armature":
        rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("bone")
        bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
        bpy.ops.object.mode_set(mode="OBJECT")
        group = block.vertex_groups.new(name="bone")
        group.add(
            [k for k, vertex in enumerate(block.data.vertices) if vertex.co.z > 0], 1.0, "REPLACE"
        )
        block.modifiers.new("rig", "ARMATURE").object = rig
        for frame, rise in ((1, 0.0), (11, 0.3)):
            rig.pose.bones["bone"].location = (0, rise, 0)
            rig.pose.bones["bone"].keyframe_insert("location", frame=frame)
    else:
        modifier = block.modifiers.new("thicker", "DISPLACE")
        modifier.direction, modifier.mid_level = "Z", 0.0
        for frame, strength in ((1, 0.0), (11, 0.3)):
            modifier.strength = strength
            modifier.keyframe_insert("strength", frame=frame)
    gaps = {}
    for frame in (1, 5, 11):
        scene.frame_set(frame)
        contacts = session.trace(scene, bpy.context.evaluated_depsgraph_get()).contacts
        gaps[frame] = contacts.distance.tolist()
    assert gaps[1] == gaps[5] == []
    assert gaps[11] == [pytest.approx(0.0, abs=1e-5)]


@pytest.mark.parametrize(("thickness", "speed"), [(0.02, 300.0), (0.01, 100.0), (0.005, 40.0)])
def test_a_simulated_bullet_hits_the_plate_whether_it_passes_it_or_not(
    scene, add_box, thickness, speed
):
    """Bullet with its default margin stops the sphere of 5 mm at some speeds and lets it through at
    others."""
    bpy.ops.rigidbody.world_add()
    scene.gravity, step = (0, 0, 0), speed / 24
    plate = add_box("plate", (0, 0, 0), (2, 2, thickness))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.005)
    bullet = bpy.context.object
    bullet.name, bullet.haptics.enabled = "bullet", True
    for obj, body in ((plate, "PASSIVE"), (bullet, "ACTIVE")):
        with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
            bpy.ops.rigidbody.object_add(type=body)
    plate.rigid_body.collision_shape, bullet.rigid_body.collision_shape = "BOX", "SPHERE"
    bullet.rigid_body.mass, bullet.rigid_body.linear_damping = 0.05, 0.0
    for frame, animated in ((1, True), (4, False)):  # thrown by its animation, then let go
        bullet.location, bullet.rigid_body.kinematic = (0, 0, (frame - 8.5) * step), animated
        bullet.keyframe_insert("location", frame=frame)
        bullet.keyframe_insert("rigid_body.kinematic", frame=frame)
    for curve in compatibility.fcurves_of(bullet):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR" if curve.data_path == "location" else "CONSTANT"
    impacts = []
    for frame in range(1, 16):
        scene.frame_set(frame)
        impacts += session.result_of(scene).impacts
    assert len(impacts) == 1
    assert impacts[0].time == pytest.approx(7.5 / 24, abs=1e-3)
    assert impacts[0].energy == pytest.approx(0.05 * speed**2 / 2, rel=0.03)
