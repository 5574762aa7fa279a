"""A linked object is overridden by the button of its panel, made a listener, and still is one after
saving and loading; so is a linked collection, by Blender's own menu."""

import bpy


def steps(window):
    session = window.module("addon.session.session")
    cube = bpy.context.scene.objects["Cube"]
    library = str(window.folder / "library.blend")
    collection = bpy.data.collections.new("Rig")
    other = cube.copy()
    other.name = "Rig body"
    collection.objects.link(other)
    bpy.data.libraries.write(library, {cube, collection})
    bpy.data.objects.remove(cube)
    bpy.data.collections.remove(collection)
    bpy.data.objects.remove(other)
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.objects, wanted.collections = ["Cube"], ["Rig"]
    scene, linked = bpy.context.scene, wanted.objects[0]
    scene.collection.objects.link(linked)
    instance = bpy.data.objects.new("Rig", None)
    instance.instance_type, instance.instance_collection, instance.location.x = (
        "COLLECTION",
        wanted.collections[0],
        5.0,
    )
    scene.collection.objects.link(instance)
    linked.select_set(True)
    bpy.context.view_layer.objects.active = linked
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_roles")
    yield from window.show_sidebar()
    yield from window.screenshot("linked")
    yield from window.click_button("object.make_override_library")
    yield 0.5
    own = bpy.context.object
    window.seen["overridden by the panel's button"] = (
        own.override_library is not None and not own.override_library.is_system_override
    )
    with window.context():
        bpy.ops.haptic.add_source()
        bpy.ops.haptic.add_listener()
    own.haptics.source.sound.gain = 3.0
    bpy.ops.ed.undo_push(message="Roles")
    yield from window.screenshot("overridden")

    with window.context():
        bpy.ops.object.select_all(action="DESELECT")
        instance.select_set(True)
        bpy.context.view_layer.objects.active = instance
        bpy.ops.object.make_override_library(collection=wanted.collections[0].session_uid)
    yield 0.5
    bodies = [
        obj for obj in scene.objects if obj.override_library and obj.name.startswith("Rig body")
    ]
    window.seen["the instance became objects"] = len(bodies) == 1
    with window.context():
        bpy.ops.object.select_all(action="DESELECT")
        bodies[0].select_set(True)
        bpy.context.view_layer.objects.active = bodies[0]
        if bodies[0].override_library.is_system_override:
            bpy.ops.object.make_override_library()
        bpy.ops.haptic.make_objects()

    path = str(window.folder / "overrides.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 1.0
    scene = bpy.context.scene
    own = next(obj for obj in scene.objects if obj.override_library and obj.name == "Cube")
    haptics = own.haptics
    window.seen["roles and values are kept"] = (
        haptics.source.enabled and haptics.listener.enabled and haptics.source.sound.gain == 3.0
    )
    window.seen["also those of the collection's object"] = any(
        obj.name == "Rig body" and obj.haptics.enabled for obj in scene.objects
    )
    scene.frame_set(2)
    window.seen["felt after reload"] = float(session.result_of(scene).amplitudes.max()) > 0
