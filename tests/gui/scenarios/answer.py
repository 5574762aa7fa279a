"""The sidebar begins with what the chosen listener feels, from where and why not; the hint leads;
meters and labels agree on a still; the path is a table whose row the overlay highlights; the meters
keep to their corner whatever the window."""

import bpy
from bpy_extras.object_utils import world_to_camera_view
from bpy_extras.view3d_utils import region_2d_to_location_3d
from mathutils import Vector


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.render.fps = 24
    session, hints, view = (
        window.module(name)
        for name in ("addon.session.sessions", "addon.panels.hints", "addon.view.watched")
    )

    def hint():
        found = hints.next_step(scene)
        return "" if found is None else found.words

    def traced():
        """The frame shown is complete, and what is drawn of it."""
        return (
            session.shown(scene) is not None
            and session.shown(scene).result.number == scene.frame_current
            and not session.is_behind(scene)
        )

    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_why", "HAPTIC_PT_roles")
    meters, layout = window.module("addon.view.meters"), window.module("addon.view.layout")

    def places():
        with window.context():
            return (
                meters.occupied(bpy.context),
                layout.redo_panels(bpy.context),
                bpy.context.region.width,
            )

    def fits(name):
        occupied, redo, width = places()
        apart = all(
            a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            for a in occupied
            for b in redo
        )
        narrow = len(occupied) == 1 and occupied[0][2] - occupied[0][0] <= width / 4 + 1
        window.seen[f"{name}: a quarter of the width, off the redo panel"] = apart and narrow

    def beside_frame(name):
        """No pixel of the meters is where the camera sees something."""
        (left, bottom, right, top), *_ = places()[0] or [(0, 0, 1, 1)]
        view, camera = window.view.spaces.active.region_3d, bpy.context.scene.camera
        depth = camera.matrix_world @ Vector((0, 0, -1))
        seen = [
            world_to_camera_view(
                bpy.context.scene,
                camera,
                region_2d_to_location_3d(
                    window.region(),
                    view,
                    (left + (right - left) * x / 8, bottom + (top - bottom) * y / 8),
                    depth,
                ),
            )
            for x in range(9)
            for y in range(9)
        ]
        window.seen[f"{name}: beside the camera's frame"] = not any(
            0 < place.x < 1 and 0 < place.y < 1 for place in seen
        )

    yield from window.show_sidebar()
    window.seen["an empty scene leads to Make Haptic"] = "Make Haptic" in hint()
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.5))
    ground = bpy.context.object
    ground.name, ground.scale = "Ground", (6, 6, 1)
    yield from window.screenshot("hint-make-haptic")
    yield from window.click_button("haptic.make_objects")
    yield 0.5
    window.seen["then to Add Source"] = "Add Source" in hint()
    bpy.ops.object.empty_add(location=(-1, 0, 0))
    shaker = bpy.context.object
    shaker.name, shaker.parent = "Shaker", ground
    shaker.location = (-0.2, 0, 0.5)
    yield 0.5
    yield from window.click_button("haptic.add_source")
    (
        shaker.haptics.source.signal,
        shaker.haptics.source.frequency,
        shaker.haptics.source.amplitude,
    ) = "SINE", 60.0, 1.0
    yield 0.5
    window.seen["then to Add Listener"] = "Add Listener" in hint()
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1.2, 0, 0.54))
    crate = bpy.context.object
    crate.name = "Crate of the upper shelf"
    crate.haptics.enabled = True
    bpy.ops.object.empty_add(location=(1.2, 0, 0.5))
    hand = bpy.context.object
    hand.name, hand.parent = "hand.R", crate
    hand.matrix_parent_inverse = crate.matrix_world.inverted()
    yield from window.click_button("haptic.add_listener")
    yield 0.5
    bpy.ops.object.select_all(action="DESELECT")
    ground.select_set(True)
    bpy.context.view_layer.objects.active = ground
    yield 0.5
    with window.context():
        bpy.ops.haptic.make_objects("INVOKE_DEFAULT", True)
    yield 1.5
    fits("redo panel")
    window.seen["the redo panel is there"] = len(places()[1]) == 1
    yield from window.screenshot("meters-redo")
    bpy.context.view_layer.objects.active = hand
    yield 1.0
    window.seen["the reason leads where nothing arrives"] = hint() == ""
    yield from window.screenshot("reason-with-cure")
    crate.location.z = 0.5
    yield 1.0
    yield from window.screenshot("answer")

    # One reading on every still, however the timeline comes to it.
    readings = {}
    for frame in (1, 100, 101, 20):
        scene.frame_set(frame)
        yield 0.6
        readings[frame] = round(view.levels_of(scene)[0].rms, 1)
    window.seen["a steady sine reads the same on every still"] = (
        traced() and len(set(readings.values())) == 1
    )
    yield from window.screenshot("still")

    # The path as a table; its row selects the object, whose part of the path the overlay
    # highlights.
    yield from window.screenshot("path-in-order")
    yield from window.click_button("haptics.meters.sort_path")
    window.seen["sorted by loss"] = scene.haptics.meters.sort_path
    bpy.ops.haptic.select_object(name="Ground")
    yield 1.0
    options = window.module("addon.view.options").options_of(scene, session.shown(scene).result)
    window.seen["the overlay highlights the row"] = options.highlight == ("hand.R", "Ground")
    yield from window.screenshot("path")

    # The meters in every corner, in a quad view and at scale 2.
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    scene.frame_set(scene.frame_start + 10)
    yield 1.0

    for corner in ("BOTTOM_RIGHT", "TOP_LEFT", "TOP_RIGHT", "BOTTOM_LEFT"):
        scene.haptics.meters.corner = corner
        yield 0.5
        beside_frame(corner)
        yield from window.screenshot(f"meters-{corner.lower().replace('_', '-')}")
    with window.context():
        bpy.ops.screen.region_quadview()
    yield 1.0
    yield from window.screenshot("meters-quad")
    with window.context():
        bpy.ops.screen.region_quadview()
    yield 0.5
    yield from window.use_scale(2.0)
    beside_frame("scale 2")
    yield from window.screenshot("meters-2x")
