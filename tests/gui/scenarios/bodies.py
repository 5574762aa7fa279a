"""A new body on a floor that shakes: measured, felt all over by a click, and back; one step of undo
each. Its feet are on the map."""

import bpy


def steps(window):
    bpy.context.preferences.view.ui_scale = 0.8
    body = bpy.context.scene.objects["Cube"]
    body.name, body.dimensions = "Human", (0.5, 0.3, 1.75)
    body.location.z = 0.874
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.1))
    floor = bpy.context.object
    floor.name, floor.scale = "Concrete Floor", (3, 3, 0.2)
    bpy.ops.haptic.make_objects()
    bpy.ops.haptic.add_source(signal="SINE")
    floor.haptics.source.frequency = 80
    bpy.context.view_layer.objects.active = body
    bpy.ops.haptic.add_default_listeners()
    window.open_only(
        "HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_materials", "HAPTIC_PT_result"
    )
    yield from window.show_sidebar()
    yield from window.show_properties("SCENE")
    bpy.ops.ed.undo_push(message="Body")
    window.seen["a new body is measured"] = not feels_all_over()
    yield 1.0
    yield from window.screenshot("bodies")
    bpy.ops.haptic.set_bodies(body="FELT_ALL_OVER")
    bpy.ops.ed.undo_push(message="Bodies")
    window.seen["felt all over"] = feels_all_over()
    yield from window.undo()
    window.seen["undone"] = not feels_all_over()
    yield from window.redo()
    window.seen["redone"] = feels_all_over()
    yield from window.click_button("haptic.set_bodies")  # the left one of two
    window.seen["measured"] = not feels_all_over()
    yield from window.screenshot("measured")
    yield from window.scroll_sidebar(40)
    yield from window.screenshot("map")


def feels_all_over() -> bool:
    return bpy.context.scene.objects["Human"].haptics.absorption > 0
