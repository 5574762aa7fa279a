"""Solo and mute of a listener and a source by the buttons beside them in the list of results."""

import bpy


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    window.open_only("HAPTIC_PT_result")
    session = window.module("addon.session.session")
    yield from window.show_sidebar()
    scene.haptics.meters.show = False
    bpy.ops.haptic.select_object(name="hand.L")
    scene.frame_set(scene.frame_start + 4)
    bpy.ops.ed.undo_push(message="Sample")
    yield 1.0

    def audible():
        return [item.name for item in session.result_of(scene).listeners if item.gain > 0]

    everybody = audible()
    yield from window.screenshot("all")
    yield from window.click_button("haptics.listener.solo")
    yield 0.5
    alone = audible()
    window.seen["one is solo"] = len(alone) == 1 and scene.objects[alone[0]].haptics.listener.solo
    yield from window.screenshot("solo")
    yield from window.undo()
    scene = bpy.context.scene
    yield from window.wait_until(lambda: session.result_of(scene) is not None)
    window.seen["undo brings all back"] = audible() == everybody
    yield from window.click_button("haptics.source.muted")
    yield 0.5
    source = session.result_of(scene).sources[0]
    window.seen["the source is muted"] = (
        source.amplitude == 0 and scene.objects[source.name].haptics.source.muted
    )
    yield from window.screenshot("muted")
    yield from window.click_button("haptics.source.muted")
    yield 0.5
    window.seen["and sounds again"] = session.result_of(scene).sources[0].amplitude > 0
