"""Files: what can't be carried is said in the file browser, a range is exported with a progress bar, cancelled without a trace and done, a
collection exports itself, and a haptic scene and a signal come in as if they were dropped."""

from pathlib import Path

import bpy


def steps(window):
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    job, registry = window.module("addon.formats.job"), window.module("core.formats.registry")
    folder = Path(window.folder) / "files"
    folder.mkdir()
    yield from window.show_sidebar()
    scene.frame_set(40)
    yield

    yield from browse(window, "haptic_tracks", folder / "ride.hjif", format="hjif")
    yield from picture(window, "formats-tracks")
    yield from accept(window)
    window.seen["exports a piece at a time"] = job.running() is not None and 0 < job.running().factor < 1
    window.seen["holds the rest of the window back"] = scene.frame_current < 120
    yield from picture(window, "formats-progress")
    window.point_at_view()
    yield from window.press("ESC")
    yield 0.5
    window.seen["cancelled without a trace"] = job.running() is None and not list(folder.iterdir()) and scene.frame_current == 40

    yield from browse(window, "haptic_tracks", folder / "ride.hjif", format="hjif")
    yield from accept(window)
    while job.running() is not None:
        yield 0.2
    window.seen["written"] = [path.name for path in folder.iterdir()] == ["ride.hjif"] and scene.frame_current == 40
    window.seen["read"] = len(registry.read(folder / "ride.hjif").channels) == len([o for o in scene.objects if o.haptics.listener.enabled])

    yield from browse(window, "haptic_scene", folder / "bench.json", frames="RANGE", tracks="wav")
    yield from picture(window, "formats-scene")
    yield from accept(window)
    while job.running() is not None:
        yield 0.2
    window.seen["scene and tracks"] = (folder / "bench.json").is_file() and (folder / "bench.tracks.wav").is_file()

    empty = bpy.data.scenes.new("Imported")
    bpy.context.window.scene = empty
    yield
    with window.context():
        bpy.ops.import_scene.haptic_scene("INVOKE_DEFAULT", filepath=str(folder / "bench.json"))
    yield 0.5
    yield from picture(window, "formats-drop")
    yield from window.press("RET")
    yield 1.0
    names = {obj.name.split(".")[0] for obj in scene.objects if obj.haptics.enabled}
    imported = {obj.name.split(".")[0] for obj in empty.objects if obj.haptics.enabled}
    window.seen["scene dropped"] = names == imported
    window.seen["moves"] = any(obj.animation_data is not None for obj in empty.objects) and empty.frame_end == 120
    empty.frame_set(40)
    with window.context():
        bpy.ops.view3d.view_all()
    yield from window.screenshot("formats-imported")
    yield from window.undo()
    window.seen["import undone"] = not any(obj.haptics.enabled for obj in bpy.data.scenes["Imported"].objects)

    scene = bpy.data.scenes[scene.name] if scene.name in bpy.data.scenes else bpy.data.scenes[0]
    bpy.context.window.scene = scene
    yield
    source = next(obj for obj in scene.objects if obj.haptics.source.enabled)
    bpy.context.view_layer.objects.active = source
    with window.context():
        bpy.ops.haptic.import_signal("INVOKE_DEFAULT", filepath=str(folder / "ride.hjif"))
    yield 0.5
    yield from window.press("RET")
    yield 0.5
    window.seen["signal dropped"] = source.haptics.source.signal == "KEPT"

    with window.context():
        bpy.ops.export_scene.gltf("INVOKE_DEFAULT", filepath=str(folder / "bench.gltf"))
    yield 1.0
    yield from picture(window, "formats-gltf")
    browser = next(area for area in window.window.screen.areas if area.type == "FILE_BROWSER")
    with bpy.context.temp_override(window=window.window, area=browser, region=browser.regions[-1]):
        bpy.ops.file.cancel()
    yield 0.5


def browse(window, name, path, **options):
    """The exporter's file browser, with a file chosen."""
    with window.context():
        getattr(bpy.ops.export_scene, name)("INVOKE_DEFAULT", filepath=str(path), **options)
    yield 1.5


def accept(window):
    """The file browser's own button."""
    browser = next(area for area in window.window.screen.areas if area.type == "FILE_BROWSER")
    region = next(region for region in browser.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window.window, area=browser, region=region):
        bpy.ops.file.execute()
    yield 0.6


def picture(window, name):
    window.save_picture(name)
    yield
