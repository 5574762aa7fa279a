"""A blow is looked at on a still, in every mode and with other settings: it stays the same blow, as
the labels and meters show."""

import math

import bpy

KEYS = {"ctrl": True, "shift": True, "alt": True}


def steps(window):
    scene = window.module("sample_scenes").build_sample("hammer_nail")
    bpy.context.window.scene = scene
    window.view.spaces.active.region_3d.view_perspective = "CAMERA"
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_overlay")
    session = window.module("addon.session.session")
    yield from window.show_sidebar()
    while not session.result_of(scene).impacts:
        window.point_at_view()
        yield from window.press("RIGHT_ARROW")
    for _ in range(2):
        yield from window.press("RIGHT_ARROW")
    yield 0.5

    def blow():
        return [
            (item.name, item.onset, item.amplitude) for item in session.result_of(scene).sources
        ]

    struck, gains = blow(), session.result_of(scene).amplitudes.copy()
    window.seen["there is a blow"] = len(struck) >= 1
    yield from window.screenshot("HT")
    for mode, (x, y) in (("SD", (120, 0)), ("HT", (-120, 0))):
        window.point_at_view()
        yield 0.2
        yield from window.press("M", **KEYS)
        yield 1.0
        window.point(window.mouse[0] + x, window.mouse[1] + y)
        yield 0.3
        yield from window.press("LEFTMOUSE")
        yield 0.5
        window.seen[f"the same blow in {mode}"] = scene.haptics.mode == mode and blow() == struck
        if mode == "SD":
            yield from window.screenshot("SD")
    window.seen["felt as before"] = bool((session.result_of(scene).amplitudes == gains).all())
    yield from window.show_properties("SCENE")
    yield from window.click_button("haptics.show_flow")
    window.seen["with Signal Flow"] = scene.haptics.show_flow and blow() == struck
    yield from window.undo()
    scene = bpy.context.scene
    window.seen["after undo"] = not scene.haptics.show_flow and blow() == struck
    frame = scene.frame_current
    window.point_at_view()
    yield from window.press("LEFT_ARROW")
    yield from window.press("RIGHT_ARROW")
    yield 0.5
    window.seen["after a step back and forth"] = scene.frame_current == frame and blow() == struck
    yield from window.screenshot("back-again")

    # What is too weak is made felt by a click, and undone.
    watched = window.module("addon.view.watched")
    hand = scene.objects["hand.L"]
    hand.haptics.listener.gain = weak_gain = 0.0625
    bpy.ops.ed.undo_push(message="Weaken the Hand")
    bpy.context.view_layer.objects.active = hand
    yield 1.0

    def margin():
        return next(
            level.margin for level in watched.levels_of(scene) if level.listener == "hand.L"
        )

    weak = margin()
    yield from window.show_sidebar()
    yield from window.click_button("haptic.make_felt")
    yield 1.0
    window.seen["a dialog shows the changes first"] = (
        margin() == weak and hand.haptics.listener.gain == weak_gain
    )
    window.save_picture("make-it-felt")
    yield from window.press("RET")
    yield 1.0
    raised = 20 * math.log10(hand.haptics.listener.gain / weak_gain)
    window.seen["made felt"] = blow() == struck and abs(margin() - 6) < 0.5 and raised > 5
    yield from window.screenshot("felt")
    yield from window.undo()
    scene = bpy.context.scene
    window.seen["and undone"] = scene.objects["hand.L"].haptics.listener.gain == weak_gain

    # The file opens as it was left.
    path = str(window.folder / "struck.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=False)
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    sessions = window.module("addon.session.sessions")
    yield from window.wait_until(lambda: sessions.shown(scene) is not None)
    window.seen["opened with its blow"] = scene.frame_current == frame and blow() == struck
    yield from window.screenshot("opened")
