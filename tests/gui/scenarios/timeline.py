"""The timeline of touch: rows fill while the scene plays, come from the track where it is baked,
and show the samples when zoomed in."""

import bpy


def steps(window):
    lane, waves, storage = (
        window.module(name)
        for name in ("plugins.timeline.lane", "plugins.timeline.baked", "addon.bake.storage")
    )

    def dope_sheet():
        return next(
            area
            for area in window.window.screen.areas
            if area.type == "DOPESHEET_EDITOR" and area.height > 200
        )

    def whole_range():
        area = dope_sheet()
        region = next(region for region in area.regions if region.type == "WINDOW")
        with bpy.context.temp_override(window=window.window, area=area, region=region):
            bpy.ops.anim.previewrange_clear()
            bpy.ops.action.view_all()

    bpy.context.window.workspace = bpy.data.workspaces["Animation"]
    yield 0.5
    scene = window.module("sample_scenes").build_sample("hammer_nail")
    bpy.context.window.scene = scene
    yield 0.5
    whole_range()
    window.seen["nothing before anything is traced"] = not lane._played
    # Three blows: a frame is not kept where the lane was last drawn more than a second before it.
    yield from window.play_frames(72)
    recorded = lane._played[scene.session_uid][1]
    window.seen["filled while playing"] = recorded.filled.sum() >= 30
    window.seen["its impacts are marked"] = len(recorded.impacts[0]) > 0
    yield from window.screenshot("played")

    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    scene.frame_start, scene.frame_end = 1, 60
    with window.context():
        bpy.ops.haptic.bake("EXEC_DEFAULT")
    scene.frame_end = 120
    scene.frame_set(60)
    yield 0.5
    whole_range()
    yield from window.wait_until(lambda: waves.waves_of(scene) is not None)
    baked = waves.waves_of(scene)
    window.seen["baked frames come from the track"] = baked.filled.all() and len(
        baked.listeners
    ) == len(storage.track_of(scene).listeners)
    yield from window.play_frames(45)
    window.seen["the others are filled"] = (
        lane._played[scene.session_uid][1].filled[60:].sum() >= 30
    )
    yield from window.screenshot("baked-and-played")
    area = dope_sheet()
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window.window, area=area, region=region):
        for _ in range(4):
            bpy.ops.view2d.zoom_in(zoomfacx=0.3)
    yield from window.screenshot("zoomed-in")
    scene.haptic_lane = "OFF"
    yield from window.screenshot("off")
