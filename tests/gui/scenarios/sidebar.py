"""The sidebar tab "Haptics" opens on the default scene, and its first button works, with undo and redo."""

import bpy


def steps(window):
    yield from window.show_sidebar()
    yield from window.screenshot("sidebar")
    cube = bpy.context.scene.objects["Cube"]
    yield from window.click_button("haptic.make_objects")
    window.seen["haptic"] = cube.haptics.enabled
    yield from window.screenshot("object")
    yield from window.undo()
    window.seen["haptic after undo"] = bpy.context.scene.objects["Cube"].haptics.enabled
    yield from window.redo()
    window.seen["haptic after redo"] = bpy.context.scene.objects["Cube"].haptics.enabled
