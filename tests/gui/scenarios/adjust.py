"""Adjust Last Operation (F9) of operators that depend on where things are or on the result."""

import bpy


def adjusted(window, right, down, letter=None):
    """Click the popup's button so many pixels right and below of where the mouse is, and choose by
    letter."""
    window.point_at_view()
    yield 0.2
    yield from window.press("F9")
    yield 1.0
    x, y = window.mouse
    window.point(x + right, y - down)
    yield 0.5
    yield from window.press("LEFTMOUSE")
    yield 1.0
    if letter:
        yield from window.press(letter)
        yield 1.0
    yield from window.press("ESC")
    yield 0.5


def place(name):
    found = bpy.data.objects.get(name)
    return found and tuple(round(v, 3) for v in found.matrix_world.translation)


def steps(window):
    cube = bpy.data.objects["Cube"]
    cube.location = (3, 2, 1)
    yield 0.3
    with window.context():
        bpy.ops.ed.undo_push(message="Moved")
        bpy.ops.haptic.add_medium("INVOKE_DEFAULT", True)
    yield 0.5
    yield from adjusted(window, 223, 50, "W")
    window.seen["water around the cube"] = place("Water") == (3, 2, 1) and place("Air") is None

    cube = bpy.data.objects["Cube"]
    bpy.data.objects["Water"].select_set(False)
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    bpy.context.scene.cursor.location = (3, 2, 2)
    with window.context():
        bpy.ops.haptic.make_objects("INVOKE_DEFAULT", True)
        bpy.ops.haptic.add_source_object("INVOKE_DEFAULT", True)
    yield 1.0
    yield from adjusted(window, 223, 50, "S")
    window.seen["a shaker at the cursor"] = place("Shaker") == (3, 2, 2)

    with window.context():
        bpy.ops.haptic.graph_to_geometry("INVOKE_DEFAULT", True)
    yield 1.0
    in_front = place("Haptic Graph")
    yield from adjusted(window, 210, 50)
    window.save_picture("graph")
    window.seen["the graph where it is"] = in_front != (0, 0, 0) == place("Haptic Graph")
