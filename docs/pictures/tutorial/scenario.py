"""Photographs the tutorial's steps in Blender's own window; `draw_tutorial.py` runs it."""

import bpy
import hammer_nail_by_hand as tutorial


def steps(window):
    area = window.view
    window.seen["viewport"] = (
        area.x,
        window.window.height - area.y - area.height,
        area.x + area.width,
        window.window.height - area.y,
    )
    bpy.context.preferences.view.show_developer_ui = False
    with window.context():
        tutorial.add_objects()
    area.spaces.active.shading.type = "SOLID"
    yield from look(window)
    yield from window.screenshot("objects")

    yield from window.show_sidebar()
    with window.context():
        tutorial.make_haptic()
    yield 2.0  # the curve is computed beside Blender
    window.region("UI").tag_redraw()
    yield 1.0
    yield from window.screenshot("make-haptic")

    with window.context():
        tutorial.swing_the_hammer()
        bpy.context.scene.frame_set(1)
        tutorial.add_physics()
        tutorial.select("Hammer")
    show_physics(window)
    yield 0.5
    yield from window.screenshot("physics")

    with window.context():
        tutorial.add_listener()
    yield 0.5
    yield from window.screenshot("listener")

    with window.context():
        tutorial.play_to(tutorial.STRIKES[0] + 2)
    yield 0.5
    yield from window.screenshot("impact")


def look(window):
    """The table from the front and a little above, with room for the raised hammer."""
    view = window.view.spaces.active.region_3d
    from mathutils import Euler

    view.view_rotation = Euler((1.25, 0.0, 0.35)).to_quaternion()
    view.view_location = (0.1, 0.0, 0.92)
    view.view_distance = 1.9
    yield 0.5


def show_physics(window):
    for area in window.window.screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "PHYSICS"
