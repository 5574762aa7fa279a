"""A scene in centimetres: graph, circle of a listener and shape stand on the objects; the panel
offers to mend gravity; unknown materials are asked for in a list, and the answer counts."""

import bpy


def steps(window):
    sessions = window.module("addon.session.sessions")
    hints = window.module("addon.panels.hints")
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_object")
    yield from window.show_sidebar()
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.unit_settings.scale_length = 0.01
    unknown = bpy.data.materials.new("MAT_0817")
    with window.context():
        for k in range(6):
            bpy.ops.mesh.primitive_cube_add(size=100, location=(100 * k, 0, 0))
            bpy.context.object.name = f"Part {k}"
            bpy.context.object.data.materials.append(unknown)
        bpy.ops.object.select_all(action="SELECT")
    yield 1.0
    with window.context():
        bpy.ops.haptic.make_objects("INVOKE_DEFAULT", True)
    yield 2.0
    yield from window.screenshot("asked")
    rows = scene.haptics.materials.names
    window.seen["the list asks for the material"] = [row.name for row in rows] == ["MAT_0817"]
    rows[0].preset = "glass"
    yield from window.press("RET")
    yield 2.0
    parts = [obj for obj in scene.objects if obj.type == "MESH"]
    window.seen["the answer counts for all"] = {o.haptics.material.name for o in parts} == {"Glass"}
    scene.objects["Part 0"].haptics.source.enabled = True
    listener = scene.objects["Part 5"]
    listener.haptics.listener.enabled = True
    listener.haptics.listener.radius = 0.7
    with window.context():
        bpy.ops.object.select_all(action="DESELECT")
        listener.select_set(True)
        bpy.context.view_layer.objects.active = listener
        bpy.context.space_data.clip_end = 1e5
        bpy.ops.view3d.view_all()
    yield 4.0
    yield from window.screenshot("graph")
    traced = sessions.shown(scene)
    window.seen["a metre is 100 units"] = (
        abs(traced.reading.transforms[5, 0, 3] - 5.0) < 1e-6 and len(traced.result.contacts) == 5
    )
    with window.context():
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    yield 4.0
    window.seen["gravity is doubted"] = hints.of_units(scene) is not None
    yield from window.screenshot("gravity")
    scene.gravity.z = -981
    window.seen["gravity is mended"] = hints.of_units(scene) is None
    yield 4.0
    yield from window.screenshot("mended")
