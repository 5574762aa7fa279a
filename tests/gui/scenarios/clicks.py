"""How many clicks it takes from Blender's own cube to something felt, to a drawn signal, to a
one-shot at a marker, to two takes compared, and to a file for a pad."""

import bpy

KEEP = (0.755,)  # where of the sidebar's width the button is


def steps(window):
    scene = bpy.context.scene
    scene.frame_end = 12
    source = scene.objects["Cube"].haptics.source
    watched, storage = window.module("addon.view.watched"), window.module("addon.bake.storage")
    takes = window.module("addon.bake.takes")
    yield from window.show_sidebar()

    def clicked(count, what, is_done):
        yield from window.wait_until(is_done)
        yield from window.screenshot(what)
        window.seen[f"{window.clicks} clicks, not {count}: {what}"] = (
            is_done() and window.clicks == count
        )
        window.clicks = 0

    for button in ("haptic.make_objects", "haptic.add_source", "haptic.add_default_listeners"):
        yield from window.click_button(button)
    yield from clicked(
        3, "felt", lambda: any(level.is_felt for level in watched.levels_of(bpy.context.scene))
    )

    bpy.ops.object.select_all(action="DESELECT")
    scene.objects["Cube"].select_set(True)
    bpy.context.view_layer.objects.active = scene.objects["Cube"]
    yield 0.5
    yield from window.click_beside("haptics.source.signal", 0.755)
    yield from window.click_in_popup("haptic.use_signal", -197, 237)
    yield from clicked(2, "a drawn signal", lambda: source.signal == "DRAWN")

    scene.timeline_markers.new("Blow", frame=6)
    yield from window.click_beside("haptics.source.enabled", 0.84)
    yield from window.click_in_popup("haptics.source.one_shot", -141, 65)
    yield 1.0
    window.save_picture("triggers")
    yield from window.click_in_popup("haptics.source.trigger_markers", 177, 3)
    yield 1.0
    window.save_picture("markers")
    # A fourth click for a user: Blender's lists do not follow simulated mice.
    yield from window.press("DOWN_ARROW")
    yield 0.5
    yield from window.press("RET")
    yield from clicked(3, "a one-shot at a marker", lambda: source.trigger_markers == "Blow")
    yield from window.press("ESC")

    def baked(count):
        yield from window.wait_until(lambda: storage.track_of(scene) is not None)
        yield from window.wait_until(
            lambda: window.module("addon.blender.job").Job.in_window is None
        )
        yield from window.click_button("haptic.keep_take", columns=KEEP)
        yield from window.wait_until(lambda: len(scene.haptics.bake.takes) == count)

    yield from window.scroll_sidebar(60)
    yield from window.click_button("haptic.bake")
    yield from baked(1)
    source.amplitude = 0.5
    yield from window.click_button("haptic.bake")
    yield 1.0
    yield from baked(2)
    yield from window.click_beside("haptic.keep_take", 0.84, columns=KEEP)
    yield from window.click_in_popup("haptic.play_take", 131, 61)
    yield from clicked(6, "two takes compared", lambda: takes.differences(scene) is not None)

    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "clicks.blend"))  # files go there
    yield from window.click_button("export_scene.haptic_tracks")
    yield 3.0
    browser = bpy.context.window_manager.windows[-1]

    def click(x, y):
        for kind, value in (
            ("MOUSEMOVE", "NOTHING"),
            ("LEFTMOUSE", "PRESS"),
            ("LEFTMOUSE", "RELEASE"),
        ):
            browser.event_simulate(type=kind, value=value, x=x, y=y)
            yield 0.3
        window.clicks += 1

    formats = list(window.module("core.formats.io.catalogue").track_formats())
    yield from click(
        browser.width - 124, browser.height - 88 - 23 * formats.index("hjif")
    )  # its button
    yield 1.0
    window.save_picture("pad")
    yield from click(browser.width - 72, 22)
    yield from clicked(3, "a file for a pad", lambda: any(window.folder.glob("*.hjif")))
