"""A source that plays once per trigger: the presets, what is wrong said under the property, and
what a played timeline gives."""

import bpy


def steps(window):
    window.module("sample_scenes").build_sample("air_blast")
    scene = window.window.scene
    sessions = window.module("addon.session.sessions")
    barrel = scene.objects["Barrel Bottom"]
    source = barrel.haptics.source
    source.enabled = True
    bpy.data.objects.remove(scene.objects["Blast"])  # the sample's own
    scene.objects["Air"].haptics.function = "exponential"
    window.open_only("HAPTIC_PT_object_settings", "HAPTIC_PT_source")
    yield from window.show_sidebar()
    with window.context():
        bpy.context.view_layer.objects.active = barrel
    yield 0.5
    yield from window.show_properties("OBJECT")
    yield from window.open_panel("haptics.source.enabled")
    scene.frame_set(10)
    yield from window.click_button("haptic.make_one_shot")
    window.seen["a preset makes a blast"] = source.one_shot and source.signal == "BLAST"
    (curve,) = window.module("addon.blender.compatibility").fcurves_of(barrel)
    window.seen["at the current frame"] = (curve.data_path, curve.keyframe_points[0].co[0]) == (
        "haptics.source.trigger",
        10.0,
    )
    yield from window.screenshot("one-shot")
    source.trigger_markers = "Shot"

    def said():
        return {
            problem.rule[0]
            for problem in sessions.shown_problems(scene)
            if problem.object == barrel.name and problem.rule
        }

    yield from window.wait_until(lambda: said() == {"trigger_markers"})
    yield from window.screenshot("one-shot-with-problems")
    source.trigger_markers = ""
    scene.frame_set(1)
    heard = []

    def listen(scene, depsgraph=None):
        traced = sessions.shown(scene)
        heard.append(
            traced is not None
            and bool(traced.result.shots)
            and float(traced.result.amplitudes.max(initial=0.0)) > 0
        )

    bpy.app.handlers.frame_change_post.append(listen)
    with window.context():
        bpy.ops.screen.animation_play()
    yield from window.wait_until(lambda: scene.frame_current > 40)
    with window.context():
        bpy.ops.screen.animation_cancel(restore_frame=False)
    bpy.app.handlers.frame_change_post.remove(listen)
    window.seen["it is heard while the timeline plays, once"] = any(heard) and not heard[-1]
    scene.frame_set(10)
    yield 0.5
    window.seen["a still frame keeps its blow"] = bool(sessions.shown(scene).result.shots)
    yield from window.screenshot("one-shot-at-its-frame")
    with window.context():
        bpy.ops.object.empty_add(location=(0.0, -1.5, 1.0))
    empty = bpy.context.view_layer.objects.active
    empty.parent = scene.objects["Air"]
    yield 0.3
    empty.haptics.source.enabled = True
    yield from window.click_button("haptic.make_one_shot")
    air = scene.objects["Air"].haptics
    window.seen["in a medium it spreads as a front"] = (
        air.function == "physical" and air.extent > 1e5 and air.wave_speed > 300
    )
    yield from window.screenshot("front")
    yield from window.undo()
    window.seen["and undo takes it back"] = (
        window.window.scene.objects["Air"].haptics.function != "physical"
    )
