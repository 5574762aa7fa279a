"""After the edit of any property of any object, the session has read what a reader reads that
begins anew, though it reads only the edited object."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.scene_reader import objects
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import session

GROUPS = ("", "source", "listener", "material")


def values_of(group):
    """The properties of a group that a panel or a script can set, with another value for each."""
    for prop in group.bl_rna.properties:
        if prop.is_readonly or prop.is_hidden or prop.identifier in ("name", "rna_type"):
            continue
        now = getattr(group, prop.identifier)
        if prop.type == "BOOLEAN":
            yield prop.identifier, not now
        elif prop.type in ("FLOAT", "INT") and not prop.is_array:
            low = max(prop.hard_min, prop.soft_min)
            yield prop.identifier, type(now)(low + (min(prop.soft_max, low + 9) - low) / 3)
        elif prop.type == "ENUM" and not prop.is_enum_flag and prop.enum_items:
            others = [item.identifier for item in prop.enum_items if item.identifier != now]
            yield prop.identifier, (others or [now])[-1]


@pytest.fixture
def touching(scene, add_box, add_empty):
    """A floor, a crate with a source, and a hand that is a listener on it; rules of materials."""
    scene.frame_start, scene.frame_end = 1, 20
    add_box("floor", (0, 0, -0.5), (4, 4, 1))
    crate = add_box("crate", (0, 0, 0.25), (0.5, 0.5, 0.5))
    crate.haptics.source.enabled = True
    other = add_box("other", (1, 0, 0.25), (0.5, 0.5, 0.5))
    add_empty("hand", (0, 0, 0.5), parent=crate).haptics.listener.enabled = True
    other.haptics.source.enabled = other.haptics.listener.enabled = True
    scene.frame_set(1)
    return scene


def check(scene, what):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    result = session.result_of(scene)
    known, fresh = session.of(scene).reading, SceneReader().read(scene, depsgraph)
    for name in ("objects", "bodies", "sources", "listeners", "settings", "contact_settings"):
        assert getattr(known, name) == getattr(fresh, name), (what, name)
    np.testing.assert_allclose(known.transforms, fresh.transforms, atol=1e-6, err_msg=str(what))
    assert known.problems == fresh.problems, what
    gains = result.amplitudes.copy()
    session.clear()
    again = session.trace(scene, depsgraph)
    np.testing.assert_allclose(gains, again.amplitudes, rtol=1e-9, err_msg=str(what))


@pytest.mark.parametrize("physics", [False, True], ids=["no physics", "rigid bodies"])
@pytest.mark.parametrize("group", GROUPS)
def test_what_is_read_after_an_edit_is_what_is_there(touching, group, physics):
    if physics:
        bpy.ops.rigidbody.world_add()
        for name in ("floor", "crate", "other"):
            bpy.context.view_layer.objects.active = bpy.data.objects[name]
            bpy.ops.rigidbody.object_add(type="PASSIVE")
    crate = bpy.data.objects["crate"]
    edited = getattr(crate.haptics, group) if group else crate.haptics
    for name, value in values_of(edited):
        session.result_of(touching)
        setattr(edited, name, value)
        bpy.context.view_layer.update()
        check(touching, (group, name, value))


def test_materials_rules_and_scene(touching):
    """What more than one object depends on is read everywhere."""
    crate, other = bpy.data.objects["crate"], bpy.data.objects["other"]
    bpy.ops.haptic.add_rule(table="transmission_table")
    row = touching.haptics.transmission_table.items[0]
    row.first_kind, row.first = "MATERIAL", "steel"
    for frame, frequency in ((1, 50), (20, 90)):
        other.haptics.source.frequency = frequency
        other.haptics.source.keyframe_insert("frequency", frame=frame)
    edits = [
        (crate.haptics.material, "name", "steel"),
        (crate.haptics.material, "name", "pine"),
        (other, "name", "renamed"),
        (touching.render, "fps", 60),
        (touching.render, "frame_map_new", 200),
        (touching, "gravity", (0, 0, -3)),
        (touching, "frame_start", 3),
        (other.haptics.source, "solo", True),
        (other, "parent", crate),
        (crate, "scale", (1, 1, 2)),
        (other, "hide_viewport", True),
    ]
    haptics = touching.haptics
    edits += [
        (haptics, "contact_tolerance", 0.3),
        (haptics, "threshold", 0.2),
        (row, "second_kind", "MATERIAL"),
        (row, "second", "pine"),
        (row, "function", "constant"),
    ]
    for group, name, value in edits:
        setattr(group, name, value)
        bpy.context.view_layer.update()
        check(touching, (name, value))


@pytest.mark.parametrize("physics", [False, True], ids=["no physics", "rigid bodies"])
def test_one_edit_reads_one_object(touching, monkeypatch, physics):
    """Also where all objects have one mesh: Blender then names all of them as edited."""
    every = [bpy.data.objects[name] for name in ("crate", "other", "floor")]
    for obj in every:
        obj.data = every[0].data
        if physics:
            bpy.context.view_layer.objects.active = obj
            bpy.ops.rigidbody.object_add()
    bpy.context.view_layer.update()
    session.result_of(touching)
    read = []
    read_object = objects.read_object
    monkeypatch.setattr(
        "haptic_tracing.addon.scene_reader.authored.read_object",
        lambda obj, scene: read.append(obj.name) or read_object(obj, scene),
    )
    read_all = SceneReader._read_whole
    monkeypatch.setattr(
        SceneReader, "_read_whole", lambda *args: read.append("everything") or read_all(*args)
    )
    every[0].haptics.kappa = 0.3
    bpy.context.view_layer.update()
    assert session.result_of(touching) is not None
    every[1].location.z += 0.1
    bpy.context.view_layer.update()
    touching.haptics.minimum_energy = 0.2
    bpy.ops.haptic.add_rule(table="textures")
    bpy.context.view_layer.update()
    bpy.ops.object.select_all(action="SELECT")
    bpy.context.view_layer.update()
    session.result_of(touching)
    if physics and bpy.app.version < (5, 0, 0):  # which names edits of bodies as moves
        assert set(read) <= {"crate", "other", "floor"}
    else:
        assert read == ["crate"]


@pytest.mark.parametrize("beside", ["move", "vertex", "kappa", "body", "frame"])
def test_a_new_name_counts_beside_other_edits_of_a_script(touching, beside):
    crate = bpy.data.objects["crate"]
    session.result_of(touching)
    crate.name = "box"
    if beside == "move":
        crate.location.z += 0.001
    elif beside == "vertex":
        crate.data.vertices[0].co.z += 0.001
        crate.data.update()
    elif beside == "kappa":
        crate.haptics.kappa = 0.4
    elif beside == "frame":
        touching.frame_set(2)
    else:
        bpy.context.view_layer.objects.active = crate
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    bpy.context.view_layer.update()
    check(touching, beside)
