"""Baking with its progress bar, cancelled and done; the scene as it is now where the timeline
stands, the track where it plays; takes in turn; meters; modes by their buttons; undo and redo of a
bake."""

import bpy


def steps(window):
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_bake")
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    job, storage, session = (
        window.module(name)
        for name in ("addon.blender.job", "addon.bake.storage", "addon.session.session")
    )
    playback, sessions, paths = (
        window.module(f"addon.{name}")
        for name in ("bake.playback", "session.sessions", "view.paths")
    )
    yield from window.show_sidebar()
    scene.frame_set(40)
    bpy.ops.ed.undo_push(message="Sample")
    yield

    with window.context():
        bpy.ops.haptic.bake("INVOKE_DEFAULT")
    for _ in range(100):
        yield 0.1
        if job.Job.in_window is not None and 0 < job.Job.in_window.factor < 1:
            window.seen["bakes a piece at a time"] = True
            break
    window.save_picture("bake-progress")
    window.point_at_view()
    yield from window.press("ESC")
    yield 0.5
    window.seen["cancelled"] = (
        job.Job.in_window is None and storage.track_of(scene) is None and scene.frame_current == 40
    )

    with window.context():
        bpy.ops.haptic.bake("INVOKE_DEFAULT")
    while job.Job.in_window is not None:
        yield 0.2
    window.seen["baked"] = storage.track_of(scene).frame_end == 120 and scene.frame_current == 40
    window.seen["fits"] = playback.stale_reasons(scene) == ()
    window.seen["stands: traced"] = not playback.is_from_track(session.result_of(scene))
    yield from window.screenshot("bake")
    window.seen["the path is known"] = bool(paths.path_of(scene).value.fall.hops)

    def shown():
        return sessions.shown(scene).result

    def strongest():
        return float(shown().amplitudes.max())

    bpy.ops.screen.animation_play()
    yield from window.wait_until(lambda: shown().number > 42 and playback.is_from_track(shown()))
    window.seen["plays from the track"] = playback.is_from_track(shown())
    bpy.ops.screen.animation_cancel(restore_frame=False)
    yield from window.wait_until(lambda: not playback.is_from_track(shown()))
    window.seen["stops: traced"] = (
        shown().number == scene.frame_current and not playback.is_from_track(shown())
    )
    before = strongest()
    source = scene.objects["Jackhammer"].haptics.source
    source.amplitude *= 0.05
    yield from window.wait_until(
        lambda: strongest() < 0.06 * before and bool(playback.known_stale_reasons(scene))
    )
    window.seen["a change is shown at once"] = 0.04 * before < strongest() < 0.06 * before
    window.seen["and the card says so"] = bool(playback.known_stale_reasons(scene))
    yield from window.screenshot("bake-out-of-date")
    source.muted = True
    yield from window.wait_until(lambda: strongest() == 0)
    window.seen["a muted source is silent"] = strongest() == 0
    source.amplitude, source.muted = source.amplitude / 0.05, False
    scene.frame_set(1)
    yield from window.wait_until(lambda: shown().number == 1 and strongest() > 0)
    yield from window.screenshot("bake-first-frame")
    scene.frame_set(40)
    yield 1.0
    yield from window.undo()
    window.seen["undone"] = storage.track_of(bpy.context.scene) is None
    yield from window.redo()
    scene = bpy.context.scene
    window.seen["redone"] = storage.track_of(scene).frame_end == 120

    scene.haptics.bake.use_track = False
    for frame in range(20, 41):
        scene.frame_set(frame)
    yield from window.screenshot("meters")
    scene.haptics.mode = "SD"
    yield 0.5
    yield from window.screenshot("mode")
    window.seen["felt"] = any(
        level.is_felt for level in window.module("addon.view.watched").levels_of(scene)
    )
    yield from window.use_scale(2.0)
    yield from window.screenshot("meters-2x")
    yield from window.use_scale(1.0)

    # Two takes, the second with half the amplitude, played in turn by their buttons.
    bake = scene.haptics.bake
    scene.frame_start, scene.frame_end = 30, 50
    scene.haptics.bake.use_track, scene.haptics.mode = True, "HT"
    for amplitude in (1.0, 0.5):
        scene.objects["Jackhammer"].haptics.source.amplitude = amplitude
        with window.context():
            bpy.ops.haptic.bake("EXEC_DEFAULT")
            bpy.ops.haptic.keep_take()
    yield from window.show_properties("SCENE")
    yield from window.click_button("haptic.play_take")
    yield 1.0
    window.seen["the other take plays"] = bake.track == bake.takes[0].track
    window.seen["from the same place"] = scene.frame_current == 40
    difference = window.module("addon.bake.takes").differences(scene)
    window.seen["with the difference"] = difference is not None and all(
        0 < item.here - item.there < 7 for item in difference.value
    )
    yield from window.scroll_sidebar(60)
    yield from window.screenshot("takes")
