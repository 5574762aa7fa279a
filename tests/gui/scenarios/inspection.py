"""The mouse over a connection of the overlay shows what it is; a click selects its object and
unfolds why; the result as a table is copied as text."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    for name, x in (("Left", -1.0), ("Right", 1.0)):
        bpy.ops.mesh.primitive_cube_add(size=2, location=(x, 0, 0))
        bpy.context.object.name = name
        bpy.context.object.haptics.enabled = True
    for name, parent, x in (("Shaker", "Left", -1.8), ("hand.R", "Right", 1.8)):
        bpy.ops.object.empty_add(radius=0.1, location=(x, 0, 0))
        obj = bpy.context.object
        obj.name, obj.parent = name, scene.objects[parent]
        obj.matrix_parent_inverse = scene.objects[parent].matrix_world.inverted()
    scene.objects["Shaker"].haptics.source.enabled = True
    scene.objects["hand.R"].haptics.listener.enabled = True
    sessions = window.module("addon.session.sessions")
    inspection = window.module("plugins.gizmos.inspection")
    yield from window.wait_until(
        lambda: sessions.shown(scene) is not None and sessions.shown(scene).result.gains.size > 0
    )
    yield from window.show_sidebar()
    region, view = window.region(), window.view.spaces.active.region_3d

    def hover(x):
        place = location_3d_to_region_2d(region, view, Vector((x, 0, 0)))
        window.point(region.x + place.x, region.y + place.y)
        yield 0.5
        window.point(region.x + place.x + 1, region.y + place.y)
        yield 1.0

    def under(x):
        with window.context():
            place = location_3d_to_region_2d(region, view, Vector((x, 0, 0)))
            return inspection.under(bpy.context, tuple(place))

    yield from window.wait_until(lambda: under(-1.0) is not None)
    left, right = under(-1.0), under(1.0)
    window.seen["each object's part of the way"] = (left.first, right.first) == ("Left", "Right")
    window.seen["metres"] = abs(left.distance - 1.8) < 0.05
    window.seen["loss and gain add up"] = abs(right.gain - left.gain + right.loss) < 12.1
    yield from hover(-1.0)
    window.save_picture("tooltip")
    yield from window.press("LEFTMOUSE")
    yield 1.0
    window.seen["a click selects the object"] = bpy.context.view_layer.objects.active.name == "Left"
    window.save_picture("clicked")
    yield from window.press("ESC")
    yield from hover(1.8)
    yield from window.press("LEFTMOUSE")
    yield 1.0
    window.seen["a click on a listener selects that"] = (
        bpy.context.view_layer.objects.active.name == "hand.R"
    )
    with window.context():
        bpy.ops.wm.call_panel(name="HAPTIC_PT_table")
    yield 1.0
    window.save_picture("table")
