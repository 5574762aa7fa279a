"""Colliders of 100,000 vertices whose meshes are edited take long to trace: edits go on, the panel
shows and cancels it, and another file opens at once."""

import time

import bpy


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.haptics.tracing = False
    sessions = window.module("addon.session.sessions")
    for name, x in (("left", 0.0), ("right", 1.99)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=400, ring_count=250, location=(x, 0, 0))
        obj = bpy.context.object
        obj.name = name
        bpy.ops.rigidbody.object_add(type="PASSIVE")
        obj.rigid_body.collision_shape = "MESH"
        obj.haptics.enabled = True
    scene.objects["left"].haptics.source.enabled = scene.objects[
        "right"
    ].haptics.listener.enabled = True
    window.open_only("HAPTIC_PT_scene")
    yield from window.show_sidebar()
    waited = []

    def timed(action):
        begun = time.monotonic()
        action()
        bpy.context.view_layer.update()
        waited.append(time.monotonic() - begun)

    def edit():
        """Surfaces of other content are prepared anew."""
        for name in ("left", "right"):
            mesh = scene.objects[name].data
            mesh.vertices[0].co.z += 0.001
            mesh.update()

    scene.haptics.tracing = True
    yield 2.0
    window.seen["it takes long"] = sessions.is_behind(scene)
    for _ in range(3):
        timed(edit)
        yield 1.5
    window.seen["edits go on"] = sessions.is_behind(scene) and max(waited) < 5.0
    timed(edit)
    yield 0.3
    window.save_picture("tracing")
    yield from window.click_button("haptic.cancel_tracing", columns=(0.82,))
    yield 0.5
    window.seen["cancelled"] = not sessions.is_behind(scene)
    timed(edit)
    yield 1.0
    window.seen["the next edit is traced"] = sessions.is_behind(scene)
    begun = time.monotonic()
    bpy.ops.wm.read_homefile(use_factory_startup=False)
    window.seen["another file opens at once"] = time.monotonic() - begun < 10.0
    yield 1.0
