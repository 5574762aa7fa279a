"""The sample scene of the jackhammer and the bench plays in the window, with the overlay; themes
and sizes for the eye."""

import bpy


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    yield from window.show_sidebar()
    window.point_at_view()
    yield
    yield from window.press("SPACE")
    yield 4.0
    window.seen["played"] = scene.frame_current > scene.frame_start
    yield from window.press("SPACE")
    yield 0.5
    result = window.module("addon.session.session").result_of(scene)
    window.seen["traced the frame shown"] = result.number == scene.frame_current
    window.seen["felt"] = bool(result.amplitudes.max() > 0)
    yield from window.screenshot("demo")
    yield from window.use_theme("Blender_Light")
    yield from window.screenshot("demo-light")
    yield from window.use_theme("Blender_Dark")
    yield from window.use_scale(2.0)
    yield from window.screenshot("demo-2x")
