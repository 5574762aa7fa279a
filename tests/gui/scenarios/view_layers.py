"""Two windows that show two view layers of a scene: the layer of the window that plays is traced,
and baked; then reversed playback, the local view, and undo from Edit Mode."""

import bpy


def sources_of(session, scene):
    result = session.result_of(scene)
    return [] if result is None else [source.name for source in result.sources]


def is_felt(session, scene):
    return float(session.result_of(scene).amplitudes.max()) > 0


def steps(window):
    session = window.module("addon.session.session")
    storage = window.module("addon.bake.storage")
    scene = bpy.context.scene
    scene.frame_end = 12
    cube = bpy.context.scene.objects["Cube"]
    cube.scale = (4, 4, 0.5)
    with window.context():
        bpy.ops.mesh.primitive_cube_add(location=(0, 0, 1.5))
        motor = bpy.context.object
        motor.name = "Motor"
        bpy.ops.mesh.primitive_cube_add(location=(2.5, 0, 1.5))
        seat = bpy.context.object
        seat.name = "Seat"
    for obj in (cube, motor, seat):
        obj.haptics.enabled = True
    motor.haptics.source.enabled = seat.haptics.listener.enabled = True
    engine = bpy.data.collections.new("Engine")
    scene.collection.children.link(engine)
    for collection in motor.users_collection:
        collection.objects.unlink(motor)
    engine.objects.link(motor)
    whole, bare = scene.view_layers[0], scene.view_layers.new("Bare")
    bare.layer_collection.children["Engine"].exclude = True
    bpy.ops.ed.undo_push(message="Stage")
    yield 0.5
    yield from window.show_sidebar()

    for layer, expected in ((whole, ["Motor"]), (bare, []), (whole, ["Motor"])):
        window.window.view_layer = layer
        yield 0.5
        yield from window.play_frames(4)
        window.seen[f"playing {layer.name}, {len(window.seen)}"] = (
            sources_of(session, scene) == expected
        )
    yield from window.screenshot("whole")
    with window.context():
        bpy.ops.wm.window_new_main()
    yield 1.5
    second = bpy.context.window_manager.windows[-1]
    second.view_layer = bare
    yield 1.0
    yield from window.play_frames(4)
    window.seen["a second window with another layer"] = sources_of(session, scene) == ["Motor"]
    with window.context():
        bpy.ops.haptic.bake("INVOKE_DEFAULT")
    yield from window.wait_until(lambda: storage.track_of(scene) is not None)
    track = storage.track_of(scene)
    window.seen["baked"] = track is not None and [s.name for s in track.result(3).sources] == [
        "Motor"
    ]
    with bpy.context.temp_override(window=second):
        bpy.ops.wm.window_close()
    yield 1.0

    scene.haptics.bake.use_track = False
    yield from window.play_frames(3)
    with window.context():
        bpy.ops.screen.animation_play(reverse=True)
    frames = []
    for _ in range(20):
        yield
        frames.append(scene.frame_current)
    with window.context():
        bpy.ops.screen.animation_cancel(restore_frame=False)
    yield 1.0
    result = session.result_of(scene)
    window.seen["reversed"] = len(set(frames)) > 2 and result.number == scene.frame_current
    window.seen["felt in reverse"] = is_felt(session, scene)

    with window.context():
        bpy.ops.object.select_all(action="DESELECT")
        seat.select_set(True)
        bpy.context.view_layer.objects.active = seat
        bpy.ops.view3d.localview()
    yield 1.0
    scene.frame_set(5)
    yield 0.5
    window.seen["in the local view"] = sources_of(session, scene) == ["Motor"]
    yield from window.screenshot("local")
    with window.context():
        bpy.ops.view3d.localview()
    yield 0.5

    with window.context():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(0, 0, 3))
        bpy.ops.object.mode_set(mode="OBJECT")
    yield 1.0
    window.seen["lifted"] = not is_felt(session, scene)
    for _ in range(4):  # the steps of Edit Mode
        if is_felt(session, bpy.context.scene):
            break
        yield from window.undo()
    window.seen["undone"] = bpy.context.mode == "OBJECT" and is_felt(session, bpy.context.scene)
