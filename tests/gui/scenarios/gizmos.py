"""A source's amplitude and a listener's extent are pulled in the viewport by their gizmos; undo
takes both back."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.5))
    ground = bpy.context.object
    ground.name, ground.scale = "Ground", (4, 4, 1)
    ground.haptics.enabled = True
    for name, x in (("Shaker", -1.0), ("hand.R", 1.0)):
        bpy.ops.object.empty_add(location=(x, 0, 0), radius=0.1)
        bpy.context.object.name = name
        bpy.context.object.parent = ground
        bpy.context.object.matrix_parent_inverse = ground.matrix_world.inverted()
    scene.objects["Shaker"].haptics.source.enabled = True
    scene.objects["Shaker"].haptics.source.amplitude = 0.5
    scene.objects["hand.R"].haptics.listener.enabled = True
    scene.objects["hand.R"].haptics.listener.radius = 0.4
    space = window.view.spaces.active
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = (0.7071, 0.7071, 0.0, 0.0)  # from the front
    space.region_3d.view_distance, space.region_3d.view_location = 6.0, (0, 0, 0)
    yield 1.0

    def pixel(place):
        region = window.region()
        x, y = location_3d_to_region_2d(region, space.region_3d, Vector(place))
        return region.x + x, region.y + y

    def pull(start, end):
        window.point(*pixel(start))
        yield 0.5
        window.event("LEFTMOUSE", "PRESS")
        yield 0.3
        for part in (0.25, 0.5, 0.75, 1.0):
            window.point(*pixel(Vector(start).lerp(Vector(end), part)))
            yield 0.2
        window.save_picture(f"pulled-{bpy.context.object.name}")
        window.event("LEFTMOUSE", "RELEASE")
        yield 0.5

    def value(name):
        haptics = bpy.context.scene.objects[name].haptics
        return haptics.source.amplitude if name == "Shaker" else haptics.listener.radius

    for name, start, end, before, after in (
        ("Shaker", (-1.5, 0, 0), (-1.9, 0, 0), 0.5, 0.9),
        ("hand.R", (1.4, 0, 0), (1.8, 0, 0), 0.4, 0.8),
    ):
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.scene.objects[name].select_set(True)
        bpy.context.view_layer.objects.active = bpy.context.scene.objects[name]
        bpy.ops.ed.undo_push(message=f"{name} is chosen")
        yield 0.5
        yield from pull(start, end)
        print(name, value(name))
        window.seen[f"{name} is pulled"] = abs(value(name) - after) < 0.06
        yield from window.screenshot(name)
        yield from window.undo()
        window.seen[f"{name} is undone"] = abs(value(name) - before) < 1e-4
