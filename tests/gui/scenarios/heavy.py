"""Colliders of 100,000 vertices whose meshes are edited take long to trace: Blender is drawn on
meanwhile, the panel shows and cancels it, and another file opens at once."""

import time
from itertools import pairwise

import bpy

LONGEST = 1.0
"""Seconds between two redraws while the scene is traced."""


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.haptics.tracing = False
    sessions = window.module("addon.session.sessions")
    for name, x in (("left", 0.0), ("right", 1.99)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=320, ring_count=320, location=(x, 0, 0))
        obj = bpy.context.object
        obj.name = name
        bpy.ops.rigidbody.object_add(type="PASSIVE")
        obj.rigid_body.collision_shape = "MESH"
        obj.haptics.enabled = True
        obj.display_type = "BOUNDS"  # software OpenGL takes a second to draw such a mesh
    scene.objects["left"].haptics.source.enabled = scene.objects[
        "right"
    ].haptics.listener.enabled = True
    window.open_only("HAPTIC_PT_scene")
    yield from window.show_sidebar()
    waited, drawn = [], []

    def edit():
        """Surfaces of other content are prepared anew."""
        begun = time.monotonic()
        for name in ("left", "right"):
            mesh = scene.objects[name].data
            mesh.vertices[0].co.z += 0.001
            mesh.update()
        bpy.context.view_layer.update()
        waited.append(time.monotonic() - begun)

    def is_cancelled():
        """Whether the last frame that was begun has been given up: it was never shown."""
        session = sessions.known(scene)
        shown = None if session.shown is None else session.shown.reading
        return session.begun is None and shown is not session.reading

    def while_traced(actions):
        """Edits again where the trace has ended before it could be cancelled."""
        for pause in actions:
            if not sessions.is_behind(scene) and not is_cancelled():
                edit()
            yield pause

    scene.haptics.tracing = True
    yield from window.wait_until(lambda: sessions.is_behind(scene))
    edit()
    redrawn = bpy.types.SpaceView3D.draw_handler_add(
        lambda: drawn.append(time.monotonic()), (), "WINDOW", "POST_PIXEL"
    )
    gaps = []
    while len(gaps) < 20:
        if not sessions.is_behind(scene):
            edit()
            drawn.clear()  # the edited mesh itself is drawn up to the first redraw that counts
        window.view.tag_redraw()
        yield
        gaps += [after - before for before, after in pairwise(drawn)]
        del drawn[:-1]
    bpy.types.SpaceView3D.draw_handler_remove(redrawn, "WINDOW")
    window.seen["seconds between redraws"] = [round(gap, 2) for gap in gaps]
    window.seen["the viewport is drawn while it is traced"] = max(gaps) < LONGEST
    for _ in range(3):
        edit()
        yield 0.5
    window.seen["edits go on"] = sessions.is_behind(scene) and max(waited) < 5.0
    print("seconds of edits", [round(seconds, 2) for seconds in waited])
    window.save_picture("tracing")
    for _ in range(5):  # a click that comes as the trace ends cancels nothing
        yield from while_traced(window.click_button("haptic.cancel_tracing", columns=(0.82,)))
        yield from window.wait_until(lambda: is_cancelled() or not sessions.is_behind(scene))
        if is_cancelled():
            break
    window.seen["cancelled"] = is_cancelled() and not sessions.is_behind(scene)
    window.save_picture("cancelled")
    edit()
    window.seen["the next edit is traced"] = sessions.is_behind(scene)
    begun = time.monotonic()
    bpy.ops.wm.read_homefile(use_factory_startup=False)
    window.seen["another file opens at once"] = time.monotonic() - begun < 10.0
    yield 1.0
