"""Ten thousand selected objects get roles and materials in the window: with a progress bar, undone
and redone in one step."""

import bpy

COUNT = 10_000


def steps(window):
    collection, mesh = bpy.context.scene.collection, bpy.data.objects["Cube"].data
    for number in range(COUNT - 1):
        brick = bpy.data.objects.new(f"Brick {number}", mesh)
        brick.location = (number % 100 * 2.5, number // 100 * 2.5, 0)
        collection.objects.link(brick)
    with window.context():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.object.select_by_type(type="MESH")
        bpy.ops.ed.undo_push(message="Bricks")
    yield from window.show_sidebar()

    shown = []
    progress = window.module("addon.blender.progress")
    show = progress.show
    progress.show = lambda part: shown.append(part) or show(part)
    for operator, arguments, done in (
        ("make_objects", {}, lambda obj: obj.haptics.enabled),
        ("apply_material", {"preset": "rubber"}, lambda obj: obj.haptics.material.name == "Rubber"),
        ("add_listener", {}, lambda obj: obj.haptics.listener.enabled),
        ("clear", {}, lambda obj: not obj.haptics.enabled),
    ):
        shown.clear()
        with window.context():
            getattr(bpy.ops.haptic, operator)("EXEC_DEFAULT", True, **arguments)
        yield 0.5
        window.seen[f"{operator} is done for all"] = sum(map(done, bpy.data.objects)) >= COUNT
        window.seen[f"{operator} shows how far it is"] = len(shown) > 10 and max(shown) <= 1
    progress.show = show
    yield from window.undo()
    window.seen["undone"] = sum(obj.haptics.enabled for obj in bpy.data.objects) == COUNT
    yield from window.redo()
    window.seen["redone"] = sum(obj.haptics.enabled for obj in bpy.data.objects) == 0
    yield 0.3
