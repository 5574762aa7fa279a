"""The mode menu by its shortcut, and the meters in both themes."""

import bpy

PRESS = {"ctrl": True, "shift": True, "alt": True}


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    window.open_only("HAPTIC_PT_result")
    yield from window.show_sidebar()
    scene.frame_set(scene.frame_start + 10)
    yield 0.5
    # Left, right, down, up, as pies are filled.
    for mode, (x, y) in (("SD", (120, 0)), ("MD", (0, -120)), ("MN", (0, 120)), ("HT", (-120, 0))):
        window.point_at_view()
        yield 0.2
        yield from window.press("M", **PRESS)
        yield 1.0
        if mode == "SD":
            window.save_picture("pie")
        window.point(window.mouse[0] + x, window.mouse[1] + y)
        yield 0.3
        yield from window.press("LEFTMOUSE")
        yield 0.5
        window.seen[f"{mode} by the menu"] = scene.haptics.mode == mode
    yield from window.undo()
    window.seen["undo takes the last mode back"] = bpy.context.scene.haptics.mode == "MN"
    yield from window.redo()
    window.seen["redo brings it again"] = bpy.context.scene.haptics.mode == "HT"

    yield from window.screenshot("meters")
    yield from window.use_theme("Blender_Light")
    yield from window.screenshot("meters-light")
    yield from window.use_theme("Blender_Dark")
    yield from window.use_scale(2.0)
    yield from window.screenshot("meters-2x")
