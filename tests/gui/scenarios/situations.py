"""Ten situations of the sidebar and the viewport: a picture of each, and how many buttons and
fields the sidebar shows."""

import importlib.util
from pathlib import Path

import bmesh
import bpy
from mathutils import Matrix, Vector

MOST = {"fresh-cube": 13, "source": 20, "character": 24}

_spec = importlib.util.spec_from_file_location(
    "recording_layout", Path(__file__).with_name("recording_layout.py")
)
recording_layout = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(recording_layout)


def situation(window, name):
    yield 1.0
    yield from window.scroll_sidebar(-60)
    yield from window.screenshot(name)
    with window.context("UI"):
        shown = recording_layout.controls(bpy.context)
    window.seen[f"{name}: {len(shown)} buttons and fields: {shown}"] = len(shown) <= MOST.get(
        name, 99
    )


def floor():
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -1.1))
    ground = bpy.context.object
    ground.name, ground.scale = "Ground", (8, 8, 0.2)
    return ground


def machine(window):
    """A machine of five parts on a desk, beside a phone, through a file of glTF."""
    for name, size, place in (
        ("Schreibtisch.001", (1.6, 0.8, 0.04), (0, 0, 0.72)),
        ("Geh\N{LATIN SMALL LETTER A WITH DIAERESIS}use_unten", (0.4, 0.3, 0.1), (0, 0, 0.79)),
        ("Motor \\ Halter", (0.2, 0.2, 0.2), (0, 0, 0.94)),
        ("Mesh_0012.003", (0.08, 0.08, 0.1), (0, 0, 1.09)),
        ("phone_body_low_LOD0", (0.075, 0.15, 0.01), (0.5, 0, 0.745)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        bpy.context.object.name, bpy.context.object.scale = name, size
    path = str(window.folder / "machine.glb")
    bpy.ops.export_scene.gltf(filepath=path, use_active_scene=True)
    for obj in list(bpy.context.scene.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.import_scene.gltf(filepath=path)
    return {obj.name[:5]: obj for obj in bpy.context.scene.objects}


def narrow(window, by):
    """Drag the edge of the sidebar by pixels."""
    region = window.region("UI")
    window.point(region.x + 1, region.y + region.height // 3)
    yield 0.3
    window.event("LEFTMOUSE", "PRESS")
    for _ in range(4):
        yield 0.2
        window.point(window.mouse[0] + by / 4, window.mouse[1])
    yield 0.2
    window.event("LEFTMOUSE", "RELEASE")
    yield 0.5


def character():
    """A figure of boxes skinned to bones, on a floor."""
    bpy.ops.object.armature_add(location=(0, 0, 0))
    armature = bpy.context.object
    armature.name = "Walker"
    bpy.ops.object.mode_set(mode="EDIT")
    bones = armature.data.edit_bones
    bones.remove(bones[0])
    parts = {"spine": ((0, 0, 0.9), (0, 0, 1.5), 0.3), "head": ((0, 0, 1.5), (0, 0, 1.8), 0.2)}
    for side, x in (("L", 0.15), ("R", -0.15)):
        parts[f"thigh.{side}"] = ((x, 0, 0.9), (x, 0, 0.5), 0.14)
        parts[f"shin.{side}"] = ((x, 0, 0.5), (x, 0, 0.1), 0.12)
        parts[f"foot.{side}"] = ((x, 0.0, 0.05), (x, -0.2, 0.05), 0.1)
        parts[f"upper_arm.{side}"] = ((x * 1.6, 0, 1.45), (x * 1.6, 0, 1.15), 0.1)
        parts[f"forearm.{side}"] = ((x * 1.6, 0, 1.15), (x * 1.6, 0, 0.9), 0.09)
        parts[f"hand.{side}"] = ((x * 1.6, 0, 0.9), (x * 1.6, 0, 0.75), 0.09)
    for name, (head, tail, _) in parts.items():
        bone = bones.new(name)
        bone.head, bone.tail = head, tail
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = bpy.data.meshes.new("Walker")
    body = bpy.data.objects.new("Walker Skin", mesh)
    bpy.context.collection.objects.link(body)
    bm = bmesh.new()
    groups = {}

    for name, (head, tail, width) in parts.items():
        middle = (Vector(head) + Vector(tail)) / 2
        along = [abs(a - b) for a, b in zip(head, tail, strict=True)]
        size = [max(width, d) for d in along]
        made = bmesh.ops.create_cube(
            bm, size=1.0, matrix=Matrix.Translation(middle) @ Matrix.Diagonal((*size, 1))
        )
        bm.verts.index_update()
        groups[name] = [v.index for v in made["verts"]]
    bm.to_mesh(mesh)
    bm.free()
    for name, vertices in groups.items():
        body.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
    body.parent = armature
    body.modifiers.new("Armature", "ARMATURE").object = armature
    return body


def select(*objects):
    bpy.ops.object.select_all(action="DESELECT")
    for item in objects:
        item.select_set(True)
    bpy.context.view_layer.objects.active = objects[-1]


def steps(window):
    scene = bpy.context.scene
    cube = scene.objects["Cube"]
    yield from window.show_sidebar()
    yield from situation(window, "untagged")
    bpy.ops.haptic.make_objects()
    yield from situation(window, "fresh-cube")
    ground = floor()
    select(ground)
    bpy.ops.haptic.make_objects()
    select(cube)
    bpy.ops.haptic.add_source(signal="SINE")
    yield from situation(window, "source")
    select(ground)
    bpy.ops.haptic.add_listener()
    yield from situation(window, "listener")
    yield from window.play_frames(20)
    bpy.ops.screen.animation_play()
    yield 1.5
    yield from window.screenshot("playing")
    bpy.ops.screen.animation_cancel(restore_frame=False)
    yield from window.use_scale(1.5)
    yield from situation(window, "scale-1.5")
    yield from window.use_scale(1.0)
    yield from window.use_theme("Blender_Light")
    yield from situation(window, "light")
    yield from window.use_theme("Blender_Dark")
    view = bpy.context.preferences.view
    view.language = "de_DE"
    view.use_translate_interface = view.use_translate_tooltips = True
    yield from situation(window, "german")
    view.language = "en_US"
    wide = window.region("UI").width
    yield from narrow(window, wide - 280)
    window.seen[f"a sidebar of {window.region('UI').width} pixels, not {wide}"] = (
        abs(window.region("UI").width - 280) <= 8
    )
    yield from situation(window, "280-pixels")
    yield from narrow(window, window.region("UI").width - wide)
    cube.location.z = 4.0
    yield from situation(window, "nothing-felt")
    cube.location.z = 0.0
    bpy.data.objects.remove(cube)
    bpy.context.view_layer.update()
    body = character()
    body.parent.location.z = -1.0
    yield 0.5
    select(body)
    bpy.ops.haptic.make_objects()
    yield from situation(window, "character-made")
    bpy.ops.haptic.add_default_listeners()
    yield from situation(window, "character")
    scene = bpy.data.scenes.new("Machine")
    window.window.scene = scene
    yield 0.5
    parts = machine(window)
    yield 0.5
    select(*parts.values())
    bpy.ops.haptic.make_objects()
    select(parts["Motor"])
    bpy.ops.haptic.add_source(signal="SINE")
    select(parts["phone"])
    bpy.ops.haptic.add_listener()
    with window.context():
        bpy.ops.view3d.view_all()
    yield from situation(window, "imported-machine")
