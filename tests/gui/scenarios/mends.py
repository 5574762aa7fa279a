"""The card for newcomers and the documentation; mesh edits while tracing is off; problems with
their cures."""

from fnmatch import fnmatchcase
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

import bpy


def steps(window):
    sessions, watched = window.module("addon.session.sessions"), window.module("addon.view.watched")
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_settings")
    yield from window.show_sidebar()
    yield from window.screenshot("card")
    opened = []
    urls = {
        pattern: prefix + url
        for prefix, entries in bpy.utils.manual_map()
        for pattern, url in entries
        if "haptic" in pattern
    }
    for name in (
        "bpy.types.hapticsourceproperties.amplitude",
        "bpy.ops.haptic.bake",
        "bpy.types.hapticmaterial.kappa",
    ):
        url = next(url for pattern, url in urls.items() if fnmatchcase(name, pattern))
        opened.append(Path(url2pathname(urlparse(url).path)))
    window.seen["F1 finds pages that the extension carries"] = all(
        path.is_file() and path.suffix == ".html" for path in opened
    )
    window.seen["of what was asked for"] = [path.stem for path in opened] == [
        "source",
        "bake",
        "materials",
    ]

    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    for name, place in (("Ground", (0, 0, -0.5)), ("Crate", (1, 0, 0.5))):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        bpy.context.object.name = name
        bpy.context.object.haptics.enabled = True
    ground, crate = scene.objects["Ground"], scene.objects["Crate"]
    ground.scale = (4, 4, 1)
    for name, parent, x in (("Shaker", ground, -1), ("hand.R", crate, 1)):
        bpy.ops.object.empty_add(location=(x, 0, 0.0))
        bpy.context.object.name, bpy.context.object.parent = name, parent
        bpy.context.object.matrix_parent_inverse = parent.matrix_world.inverted()
    scene.objects["Shaker"].haptics.source.enabled = scene.objects[
        "hand.R"
    ].haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = crate
    yield 1.0
    yield from window.screenshot("no-material")  # the empty field offers the library

    def level():
        return watched.levels_of(bpy.context.scene)[0].rms

    felt = level()
    scene.haptics.tracing = False
    yield 0.3
    for vertex in crate.data.vertices:
        vertex.co.z += 0.2
    crate.data.update()
    yield 0.3
    scene.haptics.tracing = True
    yield 1.5
    window.seen["a mesh edited while tracing was off is seen"] = felt > -60 and level() == float(
        "-inf"
    )
    yield from window.screenshot("mesh-edited")
    for vertex in crate.data.vertices:
        vertex.co.z -= 0.2
    crate.data.update()
    yield 1.0

    # An instance of what is haptic is haptic; an armature without a body and an object that is too
    # large are each named once.
    collection = bpy.data.collections.new("Barrels")
    barrel = bpy.data.objects.new("Barrel", crate.data.copy())
    barrel.haptics.enabled = True
    collection.objects.link(barrel)
    instance = bpy.data.objects.new("Barrel Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    scene.collection.objects.link(instance)
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    scene.collection.objects.link(armature)
    for name in ("foot.L", "foot.R"):
        listener = bpy.data.objects.new(name, None)
        scene.collection.objects.link(listener)
        listener.parent = armature
        listener.haptics.listener.enabled = True
    huge = bpy.data.objects.new("Huge", crate.data.copy())
    huge.haptics.enabled, huge.scale = True, (1e30, 1e30, 1e30)
    scene.collection.objects.link(huge)
    scene.frame_set(2)
    yield 2.0
    problems = sessions.shown_problems(scene)
    print([(problem.object, problem.message) for problem in problems])
    window.seen["the instance is traced"] = any(
        name.startswith("Barrel Instance") for name in sessions.shown(scene).result.objects
    )
    for name in ("Huge", "Rig"):
        window.seen[f"{name} is named once"] = (
            sum(name in f"{problem.object} {problem.message}" for problem in problems) == 1
        )
    window.seen["and the others are felt"] = abs(level() - felt) < 1
    yield from window.screenshot("problems")
    for obj in (instance, *armature.children, armature, huge):
        bpy.data.objects.remove(obj)
