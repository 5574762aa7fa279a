"""Objects touch by their surfaces, a rigid body by its hull until its mesh is chosen; the shape that
touches is drawn over the selected object."""

import bpy


def steps(window):
    sessions = window.module("addon.session.sessions")
    window.open_only("HAPTIC_PT_object_settings", "HAPTIC_PT_scene", "HAPTIC_PT_object")
    yield from window.show_sidebar()
    yield from window.show_properties("OBJECT")
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    with window.context():
        bpy.ops.mesh.primitive_torus_add(major_radius=1.0, minor_radius=0.25)
        ring = bpy.context.object
        for name, size, place in (("Hand", 0.5, (0, 0, 0)), ("Table", 1.0, (1, 0, -0.75))):
            bpy.ops.mesh.primitive_cube_add(size=size, location=place)
            bpy.context.object.name = name
    ring.name = "Ring"
    for obj in scene.objects:
        obj.haptics.enabled = True
    ring.haptics.source.enabled = scene.objects["Hand"].haptics.listener.enabled = True

    def touching():
        result = sessions.shown(bpy.context.scene).result
        return {
            frozenset(result.objects[k] for k in pair) for pair in result.contacts.pairs.tolist()
        }

    scene.objects["Table"].haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = ring
    ring.select_set(True)
    for obj in scene.objects:
        obj.select_set(obj == ring)
    yield 1.5
    window.seen["surfaces touch"] = touching() == {frozenset(("Ring", "Table"))}
    yield from window.screenshot("surfaces")
    with window.context():
        bpy.context.view_layer.objects.active = ring = bpy.context.scene.objects["Ring"]
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    ring.rigid_body.collision_shape = "CONVEX_HULL"
    yield 1.0
    yield from window.screenshot("rigid-body")
