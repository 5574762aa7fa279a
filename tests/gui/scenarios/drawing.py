"""A signal of the library becomes curves in the panel; they are edited, become F-curves and curves
again, with undo."""

import bpy


def steps(window):
    scene = bpy.context.scene
    cube = scene.objects["Cube"]
    cube.haptics.enabled = cube.haptics.source.enabled = cube.haptics.listener.enabled = True
    cube.haptics.source.frequency = 50.0
    cube.select_set(True)
    bpy.context.view_layer.objects.active = cube
    library, sessions = (
        window.module(name) for name in ("addon.io.signal_library", "addon.session.sessions")
    )
    window.open_only("HAPTIC_PT_object_settings", "HAPTIC_PT_source")
    yield from window.show_sidebar()
    yield from window.show_properties("OBJECT")
    window.point_at_view()
    with window.context():
        bpy.ops.wm.call_panel(name="HAPTIC_PT_signals", keep_open=True)
    yield 1.5
    window.save_picture("library")
    yield from window.press("ESC")
    yield 0.5
    swell = next(path for path in library.files() if path.stem == "Engine Start")
    with window.context():
        bpy.ops.haptic.use_signal(filepath=str(swell))
        bpy.ops.ed.undo_push(message="signal")
    source = lambda: bpy.data.objects["Cube"].haptics.source  # noqa: E731
    yield 1.5
    yield from window.screenshot("curves")
    window.seen["the library's signal is drawn"] = (
        source().signal == "DRAWN" and source().drawing.name.startswith("Engine Start")
    )

    def traced():
        shown = sessions.shown(bpy.context.scene)
        return shown and shown.result.sources and shown.result.sources[0].signal

    yield from window.wait_until(lambda: traced() is not None)
    before = traced()
    mapping = source().drawing.nodes["Amplitude"].mapping
    mapping.curves[0].points[1].location = (0.05, 0.2)
    mapping.update()
    yield from window.wait_until(lambda: traced() != before)
    window.seen["an edited curve is traced"] = True
    bpy.ops.ed.undo_push(message="curve")
    yield from window.open_panel("haptics.source.enabled")
    yield from window.click_button("haptic.edit_emphasis")
    yield 1.0
    yield from window.screenshot("shaped")
    window.seen["an emphasis"] = len(source().drawing.haptics.emphases) == 1
