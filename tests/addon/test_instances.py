"""Instances are objects of their own, against what Blender makes of them when it makes them
real."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.scene_reader import instance_records
from haptic_tracing.addon.scene_reader import instances as reading_of_instances
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import session, sessions
from making_haptic import make_haptic


def traced() -> Any:
    bpy.context.view_layer.update()
    return session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())


def pairs(result: Any) -> set[frozenset[str]]:
    return {frozenset(result.objects[k] for k in pair) for pair in result.contacts.pairs.tolist()}


@pytest.fixture
def crates(scene, add_box, add_empty):
    """Three instances of a collection with a crate and its lid, on a floor; made haptic by their
    instancers."""
    collection = bpy.data.collections.new("crates")
    for name, z, size in (("crate", 0.25, 0.5), ("lid", 0.52, 0.04)):
        box = add_box(name, (0, 0, z), (0.5, 0.5, size), haptic=False)
        scene.collection.objects.unlink(box)
        collection.objects.link(box)
    places = [add_empty(f"place {k}", (k, 0, 0)) for k in range(3)]
    for empty in places:
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    floor = add_box("floor", (0, 0, -0.1), (20, 20, 0.2), haptic=False)
    make_haptic(floor, *places)
    floor.haptics.source.enabled = True
    return floor, places


def scatter(rock: Any, on: Any, as_mesh: bool = False) -> Any:
    """Geometry nodes that put a rock on each vertex, of growing size; ``as_mesh``: a cube without
    an object in its place. Returns the node that instances."""
    nodes = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        nodes.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    begin, end = nodes.nodes.new("NodeGroupInput"), nodes.nodes.new("NodeGroupOutput")
    put = nodes.nodes.new("GeometryNodeInstanceOnPoints")
    join = nodes.nodes.new("GeometryNodeJoinGeometry")
    if as_mesh:
        shown = nodes.nodes.new("GeometryNodeMeshCube").outputs["Mesh"]
    else:
        info = nodes.nodes.new("GeometryNodeObjectInfo")
        info.inputs["Object"].default_value = rock
        info.inputs["As Instance"].default_value = True
        shown = info.outputs["Geometry"]
    nodes.links.new(begin.outputs[0], put.inputs["Points"])
    nodes.links.new(shown, put.inputs["Instance"])
    nodes.links.new(begin.outputs[0], join.inputs[0])
    nodes.links.new(put.outputs[0], join.inputs[0])
    nodes.links.new(join.outputs[0], end.inputs[0])
    on.modifiers.new("scatter", "NODES").node_group = nodes
    return put


def test_instances_of_a_collection_touch_as_the_same_objects_made_real(crates):
    _, places = crates
    places[1].location.z, places[2].scale = 1.0, (1, 1, 2)
    found = traced()
    assert len(found.objects) == 1 + 3 * 2
    names = [item.name for item in sessions.shown(bpy.context.scene).reading.objects]
    assert names == ["floor", *names[1:]] and "place 0: crate 0" in names
    for obj in bpy.context.scene.objects:
        obj.select_set(obj in places)
    bpy.ops.object.duplicates_make_real()
    real = traced()
    assert len(real.objects) == 1 + 3 * 2 and "place 0: crate 0" not in real.objects
    assert len(real.contacts.pairs) == len(found.contacts.pairs) == 5
    for name in ("distance", "area"):
        np.testing.assert_allclose(
            np.sort(getattr(found.contacts, name)), np.sort(getattr(real.contacts, name)), atol=1e-6
        )


def test_instances_in_instances_touch_as_the_same_objects_made_real(crates, add_empty, scene):
    """Two stores of three places each, made haptic by the stores."""
    _, places = crates
    store = bpy.data.collections.new("store")
    for empty in places:
        empty.haptics.enabled = False
        scene.collection.objects.unlink(empty)
        store.objects.link(empty)
    for obj in places[0].instance_collection.objects:
        obj.haptics.enabled = False
    stores = [add_empty(f"store {k}", (0, 4 * k, 0)) for k in range(2)]
    for empty in stores:
        empty.instance_type, empty.instance_collection = "COLLECTION", store
    make_haptic(*stores)
    result = traced()
    names = {
        f"store {s}: {obj} {place}.{k}"
        for s in range(2)
        for place in range(3)
        for k, obj in enumerate(("crate", "lid"))
    }
    assert set(result.objects) == {"floor", *names}
    crate = {frozenset((name, "floor")) for name in names if ": crate" in name}
    assert {pair for pair in pairs(result) if "floor" in pair} == crate and len(crate) == 6


def test_names_stay_while_instancers_move_and_change(crates):
    _, places = crates
    for frame, z in ((1, 0.0), (5, 1.0)):
        places[0].location.z = z
        places[0].keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)
    first = traced()
    assert frozenset(("floor", "place 0: crate 0")) in pairs(first)
    bpy.context.scene.frame_set(5)
    later = traced()
    assert later.objects == first.objects
    assert frozenset(("floor", "place 0: crate 0")) not in pairs(later)
    assert frozenset(("floor", "place 2: crate 0")) in pairs(later)
    places[2].instance_collection.objects["lid"].scale.x = 0.2
    after = traced()
    reading = sessions.shown(bpy.context.scene).reading
    sizes = {b.name: np.ptp(b.shape.local_bounds, axis=0)[0] for b in reading.bodies}
    assert sizes["place 2: lid 1"] == pytest.approx(0.2)
    mesh = places[2].instance_collection.objects["crate"].data
    for vertex in mesh.vertices:
        vertex.co.x *= 2
    mesh.update()
    after = traced()
    reading = sessions.shown(bpy.context.scene).reading
    sizes = {b.name: np.ptp(b.shape.local_bounds, axis=0)[0] for b in reading.bodies}
    assert sizes["place 0: crate 0"] == pytest.approx(1.0)
    bpy.data.objects.remove(places[1])
    assert len(traced().objects) == len(after.objects) - 2


def test_nothing_is_read_while_instancers_stand_still(crates, monkeypatch):
    floor, places = crates
    floor.keyframe_insert("location", frame=1)
    floor.location.z -= 0.05
    floor.keyframe_insert("location", frame=9)
    traced()
    read = []
    moved = reading_of_instances.Instances.moved
    monkeypatch.setattr(
        reading_of_instances.Instances,
        "moved",
        lambda self, depsgraph: read.append(1) or moved(self, depsgraph),
    )
    for frame in range(2, 9):
        bpy.context.scene.frame_set(frame)
    session.result_of(bpy.context.scene)
    assert read == []
    assert sessions.shown(bpy.context.scene).reading.moving_instances is None
    places[0].location.x += 0.1
    bpy.context.view_layer.update()
    session.result_of(bpy.context.scene)
    assert read == [1]
    count, _ = sessions.shown(bpy.context.scene).reading.moving_instances
    assert count == 6


def test_edits_count_for_the_instances_of_an_object_and_read_no_others(crates, monkeypatch):
    floor, _ = crates
    traced()

    def kappas():
        return {o.name: o.kappa for o in sessions.shown(bpy.context.scene).reading.objects}

    before = kappas()
    read = []
    found = reading_of_instances.haptic_instances
    monkeypatch.setattr(
        instance_records,
        "haptic_instances",
        lambda depsgraph: read.append(depsgraph) or found(depsgraph),
    )
    floor.haptics.kappa = 0.75
    traced()
    assert kappas() == {**before, "floor": 0.75} and not read
    bpy.data.objects["crate"].haptics.kappa = 0.25
    traced()
    changed = {name: 0.25 for name in before if ": crate" in name}
    assert kappas() == {**before, "floor": 0.75, **changed} and len(changed) == 3 and read


@pytest.mark.parametrize("as_mesh", [False, True])
def test_what_geometry_nodes_scatter_touches(scene, add_box, as_mesh):
    rock = add_box("rock", (0, 0, -9), (0.2, 0.2, 0.2), haptic=False)
    for vertex in rock.data.vertices:
        vertex.co.z += 0.5
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, size=4)
    field = bpy.context.object
    field.name = "field"
    put = scatter(rock, field, as_mesh)
    make_haptic(field, *([] if as_mesh else [rock]))
    field.haptics.source.enabled = True
    count = len(field.data.vertices)
    result = traced()
    shown = "field" if as_mesh else "rock"
    assert len(result.objects) == count + (1 if as_mesh else 2)
    expected = {frozenset(("field", f"field: {shown} {k}.0")) for k in range(count)}
    assert {frozenset(p) for p in pairs(result) if "field" in p} == expected
    put.inputs["Scale"].default_value = (2, 2, 2)
    traced()
    reading = sessions.shown(scene).reading
    size = {b.name: np.ptp(b.shape.local_bounds, axis=0)[0] for b in reading.bodies}
    assert size[f"field: {shown} 0.0"] == pytest.approx(2.0)  # of a mesh of 1 m, not of its object
    put.inputs["Selection"].default_value = False
    assert len(traced().objects) == (1 if as_mesh else 2)


def test_a_source_with_no_surface_but_its_instances_is_named(scene):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, size=4)
    field = bpy.context.object
    field.name = "field"
    nodes = scatter(None, field, as_mesh=True).id_data
    own = nodes.nodes["Group Input"].outputs[0].links
    nodes.links.remove(next(link for link in own if link.to_node.name == "Join Geometry"))
    make_haptic(field)
    result = traced()
    assert result.objects and session.problems_of(scene) == ()  # they only conduct
    field.haptics.source.enabled = True
    assert traced().sources == ()
    (problem,) = session.problems_of(scene)
    assert problem.object == "field" and "Realize Instances" in problem.message
    realize = nodes.nodes.new("GeometryNodeRealizeInstances")
    end = nodes.nodes["Group Output"].inputs[0]
    nodes.links.new(end.links[0].from_socket, realize.inputs[0])
    nodes.links.new(realize.outputs[0], end)
    assert [source.name for source in traced().sources] == ["field"]
    assert session.problems_of(scene) == ()


def test_an_instance_without_a_surface_names_the_cure(scene, add_empty):
    collection = bpy.data.collections.new("nothing")
    empty = add_empty("here")
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    empty.select_set(True)
    with pytest.raises(RuntimeError, match=r"here.+Make Instances Real"):
        bpy.ops.haptic.make_objects()


@pytest.mark.parametrize(
    "add",
    [
        lambda: bpy.ops.object.text_add(),
        lambda: bpy.ops.object.metaball_add(),
        lambda: bpy.ops.surface.primitive_nurbs_surface_sphere_add(),
        lambda: bpy.ops.curve.primitive_bezier_circle_add(),
    ],
    ids=["text", "metaball", "surface", "curve"],
)
def test_a_curve_or_text_is_one_object_beside_what_it_scatters(scene, add_box, add):
    """Blender lists its mesh as an instance of itself."""
    floor = add_box("floor", (0, 0, -0.1), (20, 20, 0.2), haptic=False)
    add()
    obj = bpy.context.object
    make_haptic(floor, obj)
    floor.haptics.source.enabled = True
    assert set(traced().objects) == {"floor", obj.name}
    if obj.type == "CURVE":
        scatter(None, obj, as_mesh=True)
        points = obj.data.splines[0].bezier_points
        scattered = {f"{obj.name}: {obj.name} {k}.0" for k in range(len(points))}
        assert set(traced().objects) == {"floor", obj.name, *scattered}


@pytest.mark.parametrize("way", ["nodes", "faces", "collection", "modifier shown"])
def test_what_begins_to_show_instances_later_counts(scene, add_box, add_empty, way):
    """Also of an object that is not haptic itself."""
    rock = add_box("rock", (0, 0, 5), (0.2, 0.2, 0.2))
    rock.haptics.surface = "SEEN"
    plane = add_box("plane", (0, 0, 0), (1, 1, 1), haptic=False)
    group = bpy.data.collections.new("rocks")
    group.objects.link(rock)
    if way == "modifier shown":
        scatter(rock, plane)
        plane.modifiers[0].show_viewport = False
    elif way == "faces":
        rock.parent = plane
    empty = add_empty("empty", (0, 0, 3), None)
    bpy.context.view_layer.update()
    before = len(traced().objects)
    if way == "nodes":
        scatter(rock, plane)
    elif way == "faces":
        plane.instance_type = "FACES"
    elif way == "collection":
        empty.instance_collection = group
        empty.instance_type = "COLLECTION"
    else:
        plane.modifiers[0].show_viewport = True
    bpy.context.view_layer.update()
    session.result_of(scene)
    found = sessions.shown(scene).reading
    assert len(found.bodies) > before
    fresh = SceneReader().read(scene, bpy.context.evaluated_depsgraph_get())
    assert found.bodies == fresh.bodies
