"""The mode menu by its shortcut, and the meters in the sidebar: they keep up while the scene
plays."""

import bpy

PRESS = {"ctrl": True, "shift": True, "alt": True}


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    window.open_only("HAPTIC_PT_result", "HAPTIC_PT_meters")
    yield from window.show_sidebar()
    session, pictures = (
        window.module("addon.session.session"),
        window.module("addon.view.meter_pictures"),
    )

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

    scene = bpy.context.scene
    drawn = []
    draw_it = pictures.scope_picture
    pictures.scope_picture = lambda *what: drawn.append(scene.frame_current) or draw_it(*what)
    window.point_at_view()
    yield
    yield from window.press("SPACE")
    yield from window.wait_until(lambda: len(set(drawn)) >= 3)
    yield from window.press("SPACE")
    yield from window.wait_until(lambda: drawn[-1] == scene.frame_current)
    pictures.scope_picture = draw_it
    window.seen["the panel's scope keeps up"] = (
        len(set(drawn)) >= 3 and drawn == sorted(drawn) and drawn[-1] == scene.frame_current
    )
    window.seen["and is drawn once a frame"] = len(drawn) == len(set(drawn))
    window.seen["of the frame shown"] = session.result_of(scene).number == scene.frame_current
    yield from window.screenshot("meters")
    yield from window.use_theme("Blender_Light")
    yield from window.screenshot("meters-light")
    yield from window.use_theme("Blender_Dark")
    yield from window.use_scale(2.0)
    yield from window.screenshot("meters-2x")
