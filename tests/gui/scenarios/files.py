"""Tracing goes on through saving, reloading, a new file, other scenes and other workspaces."""

import bpy


def steps(window):
    session = window.module("addon.session.session")
    yield from window.show_sidebar()
    yield from window.click_button("haptic.make_objects")
    cube = bpy.context.scene.objects["Cube"]
    cube.haptics.source.enabled = cube.haptics.listener.enabled = True
    window.point_at_view()
    yield
    yield from window.press("RIGHT_ARROW")
    yield 0.5
    window.seen["gain"] = float(session.result_of(bpy.context.scene).amplitudes.max()) > 0

    path = str(window.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 1.0
    window.seen["tagged after reload"] = bpy.context.scene.objects["Cube"].haptics.enabled
    bpy.context.scene.frame_set(2)
    window.seen["traced after reload"] = session.result_of(bpy.context.scene).number == 2

    sessions = window.module("addon.session.sessions")

    def is_shown():
        return sessions.shown(bpy.context.scene) is not None

    extension = sessions.__name__.partition(".addon.")[0]
    bpy.ops.preferences.addon_disable(module=extension)
    yield
    bpy.ops.preferences.addon_enable(module=extension)
    yield from window.wait_until(is_shown)
    window.seen["traced when enabled"] = is_shown()

    first = bpy.context.scene
    second = bpy.data.scenes.new("Other")
    bpy.context.window.scene = second
    yield
    second.frame_set(5)
    window.seen["other scene"] = session.result_of(second) is None
    bpy.context.window.scene = first
    yield
    for workspace in bpy.data.workspaces:
        bpy.context.window.workspace = workspace
        yield 0.3
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        yield
    window.seen["traced in every workspace"] = (
        session.result_of(first).number == first.frame_current
    )
    bpy.context.window.workspace = bpy.data.workspaces["Layout"]
    yield 0.5

    bpy.ops.wm.read_homefile()
    yield 1.0
    bpy.context.scene.frame_set(3)
    window.seen["nothing traced in a new file"] = session.result_of(bpy.context.scene) is None
    handlers = [
        handler for handler in bpy.app.handlers.frame_change_post if "haptic" in handler.__module__
    ]
    window.seen["frame handlers"] = len(handlers)
