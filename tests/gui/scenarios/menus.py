"""Menus with pictures of samples, materials and signals, and what a letter in them applies."""

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
            if menu == "signals":
                bpy.ops.wm.call_panel(name="HAPTIC_PT_signals")
            else:
                bpy.ops.wm.call_menu(name=f"HAPTIC_MT_{menu}")
        yield 1.0
        window.save_picture(menu)
        yield from window.press("R" if menu == "materials" else "ESC")
        yield 1.0
        window.save_picture(f"{menu}-chosen")
    window.seen["a material by its letter"] = cube.haptics.material.name == "Rubber"
