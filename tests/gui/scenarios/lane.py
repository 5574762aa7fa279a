"""The lane: readable in the Timeline at its default height, in the dark and the light theme; in the
Dope Sheet a one-shot is dragged by the mouse to an impact and to a marker, one undo takes each back, Escape and clicks elsewhere
change nothing."""

import bpy


def steps(window):
    lane, compatibility = (
        window.module("plugins.timeline.lane"),
        window.module("addon.blender.compatibility"),
    )
    text_width = window.module("addon.blender.text").text_width
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    yield 0.5
    lowest = next(area for area in window.window.screen.areas if area.type == "DOPESHEET_EDITOR")
    window.seen["the Timeline has its default height"] = lowest.height < 110
    region = next(region for region in lowest.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window.window, area=lowest, region=region):
        bpy.ops.action.view_all()
    scene.haptics.show_overlay = scene.haptics.meters.show = False  # frames come sooner
    yield from window.play_frames(30)
    texts = lane._shown[region.as_pointer()].over.texts
    window.seen[f"a source and a listener are named, and how many more: {texts}"] = (
        len(texts) == 2
        and texts[0].words == "Jackhammer"
        and texts[1].words.endswith("and 9 more")
        and texts[0].position[0] + text_width(texts[0].words, texts[0].size) < texts[1].position[0]
    )
    window.save_picture("default-height")
    yield from window.use_theme("Blender_Light")
    window.save_picture("default-height-light")
    yield from window.use_theme("Blender_Dark")

    scene = window.module("sample_scenes").build_sample("hammer_nail")
    bpy.context.window.scene = scene
    scene.haptics.show_overlay = scene.haptics.meters.show = False
    bpy.context.window.workspace = bpy.data.workspaces["Animation"]
    yield 0.5
    bpy.context.window.scene = scene
    yield 0.5
    timeline = next(
        area
        for area in window.window.screen.areas
        if area.type == "DOPESHEET_EDITOR" and area.height > 200
    )
    region = next(region for region in timeline.regions if region.type == "WINDOW")

    def scene_now():
        return window.window.scene

    def shown():
        return lane._shown[region.as_pointer()]

    nail = scene.objects["Nail"]
    with window.context():
        for obj in list(bpy.context.selected_objects):
            obj.select_set(False)
        nail.select_set(True)
        bpy.context.view_layer.objects.active = nail
        scene.frame_set(40)
        bpy.ops.haptic.make_one_shot(kind="GUN")
    scene.timeline_markers.new("here", frame=60)
    with bpy.context.temp_override(window=window.window, area=timeline, region=region):
        bpy.ops.action.view_all()
    scene.frame_set(1)
    bpy.ops.ed.undo_push(message="One-shot")
    scene.frame_set(12)
    yield from window.play_frames(14)
    yield from window.wait_until(lambda: region.as_pointer() in lane._shown)
    yield from window.wait_until(lambda: bool(shown().marks))
    window.seen["rows of the source and of listeners"] = nail.name in {
        mark.source for mark, _ in shown().marks
    }
    window.seen["impacts"] = len(shown().impacts) > 0

    def key():
        (curve,) = (
            curve
            for curve in compatibility.fcurves_of(scene_now().objects["Nail"])
            if curve.data_path == "haptics.source.trigger"
        )
        return curve.keyframe_points[0].co[0]

    def at(frame):
        x, _ = region.view2d.view_to_region(frame, 0, clip=False)
        (_, (_, y)) = next(one for one in shown().marks if one[0].source == "Nail")
        return region.x + x, region.y + y

    def drag(start, end, **keys):
        window.point(*at(start))
        yield 0.2
        window.event("LEFTMOUSE", "PRESS", **keys)
        yield 0.2
        for part in (0.3, 0.7, 1.0):
            window.mouse = tuple(
                round(a + part * (b - a)) for a, b in zip(at(start), at(end), strict=True)
            )
            window.event("MOUSEMOVE", "NOTHING", **keys)
            yield 0.2

    def let_go():
        yield from release("LEFTMOUSE")

    def release(kind):
        window.event(kind, "RELEASE")
        yield 0.4

    yield from window.screenshot("lane-dark")
    impact = min(shown().impacts.tolist(), key=lambda frame: abs(frame - 20))
    yield from drag(40, impact + 0.2)
    window.save_picture("dragging")
    yield from let_go()
    window.seen["it snaps to the impact"] = abs(key() - impact) < 1e-3
    yield from window.undo()
    window.seen["one undo takes it back"] = key() == 40
    yield 1.0
    yield from window.wait_until(lambda: bool(shown().marks))
    yield from drag(40, 60.3)
    yield from let_go()
    window.seen["it snaps to the marker"] = key() == 60
    yield from window.undo()
    yield from window.wait_until(lambda: bool(shown().marks))
    yield from drag(40, 60.3)
    yield from window.press("ESC")
    yield from let_go()
    window.seen["Escape leaves it"] = key() == 40
    yield from drag(52, 70)
    yield from let_go()
    window.seen["clicks beside it are Blender's own"] = key() == 40
    scene_now().haptic_lane = "WAVES"
    yield from window.use_theme("Blender_Light")
    yield from window.screenshot("waves-light")
    scene_now().haptic_lane = "LEVELS"
    yield from window.screenshot("lane-light")
    yield from window.use_scale(1.5)
    yield from window.screenshot("lane-1.5")
