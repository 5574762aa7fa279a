"""The tutorial, as its text says: numbers and labels are read from docs/tutorial.md, and whatever
has another label fails."""

import math
import re
from pathlib import Path

import bpy

BLENDERS = {
    "File > New > General", "Shift A", "Adjust Last Operation", "Ctrl J", "Ctrl P > Object (Keep Transform)", "N", "I", "T > Linear",
    "Properties > Physics", "Rigid Body", "Passive", "Active", "Animated",
}  # fmt: skip
"""Labels and keys that are Blender's own."""


def number(text):
    return float(text.replace("\N{MINUS SIGN}", "-"))


def table(text):
    """Name, mesh, location and the numbers of the last column, of each row."""
    for row in re.findall(r"^\|(.+)\|$", text, re.MULTILINE)[2:]:
        name, mesh, location, size = (cell.strip() for cell in row.split("|"))
        yield (
            name,
            mesh,
            [number(part) for part in location.split(",")],
            [number(part) for part in re.findall(r"[\d.]+", size)],
        )


def labels():
    """Every label of the add-on that a reader may look for."""
    found = {
        getattr(getattr(bpy.types, name), "bl_label", "")
        for name in dir(bpy.types)
        if name.startswith("HAPTIC_")
    }
    haptics, own = bpy.context.scene.haptics, bpy.context.object.haptics
    found |= {
        prop.name
        for group in (haptics, haptics.bake, own, own.listener)
        for prop in group.bl_rna.properties
    }
    found |= {
        getattr(bpy.types, f"HAPTIC_OT_{name}").bl_label
        for name in ("make_objects", "add_listener", "bake", "find_devices")
    }
    found |= {item.identifier for item in haptics.bl_rna.properties["mode"].enum_items}
    return found | {"Haptics", "Play"}


def operator_of(label):
    """The operator of the add-on that has this label."""
    found = [
        name
        for name in dir(bpy.ops.haptic)
        if getattr(bpy.ops.haptic, name).get_rna_type().name == label
    ]
    assert len(found) == 1, f"operators called {label!r}: {found}"
    return f"haptic.{found[0]}"


def select(*names):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name in names)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[0]]


def add(name, mesh, location, size):
    if mesh == "cube":
        bpy.ops.mesh.primitive_cube_add(size=1, location=location, scale=size)
    elif mesh == "cylinder":
        bpy.ops.mesh.primitive_cylinder_add(radius=size[0], depth=size[1], location=location)
    else:
        bpy.ops.mesh.primitive_uv_sphere_add(radius=size[0], location=location)
    bpy.context.object.name = name


def steps(window):
    written = (Path(__file__).parent / "tutorial.md").read_text(encoding="utf-8")
    text = re.sub(
        r"(?<=[^\n|])\n(?=[^\n|])", " ", written
    )  # a paragraph in a line, wherever its lines are broken
    scene = bpy.context.scene
    session, watched = (
        window.module("addon.session.session"),
        window.module("addon.view.watched"),
    )
    bpy.data.objects.remove(bpy.data.objects["Cube"])

    # 1. Four things that touch
    with window.context():
        for row in table(text):
            add(*row)
        select("Hammer", "Handle")
        bpy.ops.object.join()
        wrist = [
            number(part)
            for part in re.search(r"called Wrist at ([^.]+\.[^.]+\.\d+)\.", text)[1].split(",")
        ]
        bpy.ops.object.empty_add(location=wrist)
        bpy.context.object.name = "Wrist"
        select("Wrist", "Hammer", "Hand")
        bpy.ops.object.parent_set(keep_transform=True)

    # 2. Make them haptic
    yield from window.show_sidebar(re.search(r"choose the tab \*(\w+)\*", text)[1])
    unknown = set()
    for emphasised in re.findall(r"\*\*?([A-Z][^*]*?)\*\*?", text):
        if emphasised not in BLENDERS:
            unknown |= {
                part
                for part in re.split(r" > |, ", emphasised)
                if part not in labels() | {"File", "Export", "Properties", "Object", "Scene"}
            }
    samples = {sample.title for sample in window.module("sample_scenes").SAMPLES.values()}
    exports = {
        bpy.ops.export_scene.haptic_tracks.get_rna_type().name,
        bpy.ops.export_scene.haptic_scene.get_rna_type().name,
    }
    written = {part for part in unknown - samples if not any(part in title for title in exports)}
    body_part = re.search(r"choose the body part \*([^*]+)\*", text)[1]
    window.seen[f"every label is there, not {sorted(written - {body_part})}"] = written <= {
        body_part
    }
    select("Table", "Nail", "Hammer", "Hand")
    yield from window.click_button(
        operator_of(re.search(r"and press \*\*(Make [^*]+)\*\*", text)[1])
    )
    yield 0.5
    guessed = {obj.name: obj.haptics.material.name for obj in scene.objects if obj.haptics.enabled}
    window.seen["materials"] = guessed == {
        "Table": "Hardwood",
        "Nail": "Steel",
        "Hammer": "Steel",
        "Hand": "Flesh",
    }

    # 3. Swing
    handle = scene.objects["Wrist"]
    for angle, frames in re.findall(r"(\S+)° at frames? (\d+(?: and \d+)?)", text):
        for frame in re.findall(r"\d+", frames):
            handle.rotation_euler.y = math.radians(number(angle))
            handle.keyframe_insert("rotation_euler", index=1, frame=int(frame))
    curves = window.module("addon.blender.compatibility").fcurves_of(handle)
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    scene.frame_end = int(re.search(r"scene end at frame (\d+)", text)[1])
    scene.frame_set(1)

    # 4. Physics
    with window.context():
        for name, kind in (("Table", "PASSIVE"), ("Nail", "PASSIVE"), ("Hammer", "ACTIVE")):
            select(name)
            bpy.ops.rigidbody.object_add(type=kind)
    body = scene.objects["Hammer"].rigid_body
    body.kinematic, body.mass = True, number(re.search(r"mass of ([\d.]+) kg", text)[1])

    # 5. Something that feels
    select("Hand")
    yield 0.3
    yield from window.click_button(operator_of(re.search(r"press \*\*(Add [^*]+)\*\*", text)[1]))
    listener = scene.objects["Hand"].haptics.listener
    parts = {
        item.name: item.identifier for item in listener.bl_rna.properties["body_part"].enum_items
    }
    yield from window.click_button("haptics.listener.body_part")
    yield 0.5
    yield from window.click_in_popup("", 129, -97)
    window.seen["the body part is chosen"] = listener.body_part == parts[body_part]
    yield from window.screenshot("before")

    # 6. Play
    yield from window.click_button("screen.animation_play")
    yield from window.wait_until(lambda: scene.frame_current > 5)
    window.seen["plays"] = window.window.screen.is_animation_playing
    yield from window.click_button("screen.animation_play")
    window.point_at_view()
    yield from window.press("LEFT_ARROW", shift=True)
    yield 0.5
    window.seen["back at the start"] = scene.frame_current == 1
    strikes = int(re.search(r"strikes at frame (\d+)", text)[1])
    for _ in range(strikes - scene.frame_current):
        window.point_at_view()
        yield from window.press("RIGHT_ARROW")
    yield 0.5
    result = session.result_of(scene)
    window.seen["strikes at the frame"] = (
        scene.frame_current == strikes and len(result.impacts) == 1
    )
    (gain,) = result.amplitudes[-1]
    said = watched.levels_of(scene)[0].margin_text()
    window.seen[f"the label says {said}"] = said == re.search(r"label says (\S+ dB)", text)[1]
    yield from window.screenshot("struck")
    select("Hammer")
    yield from window.scroll_sidebar(-60)
    steel = scene.haptics.materials.items.find("Steel")
    yield from window.point_at(f"haptics.materials.items[{steel}].kappa")
    window.point(window.mouse[0], window.mouse[1] + 15)
    yield 0.3
    yield from window.press("LEFTMOUSE")
    yield 1.0
    window.save_picture("materials")
    yield from window.press("R")  # its letter in the menu
    yield 1.0
    window.seen["of rubber"] = scene.objects["Hammer"].haptics.material.name == "Rubber"
    result = session.result_of(scene)
    window.seen["of rubber: the same blow, weaker"] = len(result.impacts) == 1 and bool(
        0 < result.amplitudes[-1][0] < gain
    )
    yield from window.screenshot("rubber")

    # 7. Bake
    yield from window.scroll_sidebar(60)
    yield from window.click_button("haptic.bake")
    track_of = window.module("addon.bake.storage").track_of
    yield from window.wait_until(lambda: track_of(scene) is not None)
    window.seen["baked"] = track_of(scene).frame_end == scene.frame_end
    yield from window.screenshot("baked")
