"""Menus with pictures of samples, materials and signals, and what a click in them applies."""

import bpy


def steps(window):
    scene = bpy.context.scene
    cube = scene.objects["Cube"]
    cube.haptics.enabled = cube.haptics.source.enabled = True
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    for menu in ("samples", "materials", "signals"):
        window.point_at_view()
        yield 0.3
        with window.context():
            bpy.ops.wm.call_menu(name=f"HAPTIC_MT_{menu}")
        yield 1.0
        window.save_picture(menu)
        yield from window.press("ESC" if menu == "samples" else "N" if menu == "signals" else "R")
        yield 1.0
        window.save_picture(f"{menu}-chosen")
    window.seen["a material by its letter"] = cube.haptics.material.name == "Rubber"
    window.seen["a signal by its letter"] = cube.haptics.source.signal == "NOISE"
