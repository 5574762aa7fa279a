"""Files: what can't be carried is said in the file browser, a range is exported with a progress
bar, cancelled without a trace and done; a haptic scene and a signal come in as if they were
dropped."""

from pathlib import Path

import bpy


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    job, registry = window.module("addon.blender.job"), window.module("core.formats.registry")
    folder = Path(window.folder) / "files"
    folder.mkdir()
    window.open_only("HAPTIC_PT_settings", "HAPTIC_PT_export")
    yield from window.show_sidebar()
    scene.frame_set(40)
    yield

    yield from browse(window, "haptic_tracks", folder / "ride.hjif", formats={"hjif"})
    window.save_picture("formats-tracks")
    yield from press_in_browser("RET")
    yield from until(lambda: job.Job.in_window is not None and 0 < job.Job.in_window.factor < 1)
    window.seen["exports a piece at a time"] = True
    window.save_picture("formats-progress")
    window.point_at_view()
    yield from window.press("ESC")
    yield from until(lambda: job.Job.in_window is None)
    window.seen["cancelled without a trace"] = (
        not list(folder.iterdir()) and scene.frame_current == 40
    )

    yield from browse(window, "haptic_tracks", folder / "ride.hjif", formats={"hjif"})
    yield from press_in_browser("RET")
    yield from until((folder / "ride.hjif").is_file)
    yield from until(lambda: job.Job.in_window is None)
    window.seen["written"] = [path.name for path in folder.iterdir()] == [
        "ride.hjif"
    ] and scene.frame_current == 40
    levels = window.module("addon.view.watched").levels_of(scene)
    names = {channel.name for channel in registry.read(folder / "ride.hjif").channels}
    felt = {level.title for level in levels if level.is_felt}
    window.seen[f"read by those who feel something: {sorted(names)}"] = felt and felt <= names < {
        level.title for level in levels
    }

    for _ in range(2):
        yield from browse(window, "haptic_tracks", folder / "poor.tact", formats={"tact"})
        yield from press_in_browser("RET")
        yield from until(lambda: job.Job.in_window is not None)
        yield from until(lambda: job.Job.in_window is None or job.Job.in_window.question)
    before = {path: path.stat().st_mtime_ns for path in folder.glob("*.tact")}
    asked = job.Job.in_window is not None
    yield 1.0
    window.save_picture("formats-replace")
    yield from window.press("ESC")
    yield from until(lambda: job.Job.in_window is None)
    window.seen["asked before a poor file replaces one"] = (
        asked and before == {path: path.stat().st_mtime_ns for path in before} != {}
    )
    yield from window.show_properties("SCENE")
    yield from window.screenshot("formats-losses")
    window.is_in_properties = False

    yield from browse(window, "haptic_scene", folder / "bench.json", frames="RANGE", tracks="wav")
    window.save_picture("formats-scene")
    yield from press_in_browser("RET")
    yield from until((folder / "bench.json").is_file)
    yield from until(lambda: job.Job.in_window is None)
    window.seen["scene and tracks"] = (folder / "bench.tracks.wav").is_file()

    with window.context():
        dropped = bpy.ops.haptic.drop_scene("INVOKE_DEFAULT", filepath=str(folder / "bench.json"))
    window.seen["scene dropped"] = dropped == {"CANCELLED"}
    yield from window.screenshot("formats-drop")

    yield 0.5
    source = next(obj for obj in scene.objects if obj.haptics.source.enabled)
    bpy.context.view_layer.objects.active = source
    window.point_at_view()
    with window.context():
        bpy.ops.haptic.import_signal("INVOKE_DEFAULT", filepath=str(folder / "ride.hjif"))
    yield 1.0
    yield from window.press("RET")
    yield from until(lambda: source.haptics.source.signal == "KEPT")
    window.seen["signal dropped"] = True

    with window.context():
        bpy.ops.export_scene.gltf("INVOKE_DEFAULT", filepath=str(folder / "bench.gltf"))
    yield 3.0
    window.save_picture("formats-gltf")
    yield from press_in_browser("ESC")
    yield 1.0


def browse(window, name, path, **options):
    """The exporter's file browser, with a file chosen."""
    with window.context():
        getattr(bpy.ops.export_scene, name)("INVOKE_DEFAULT", filepath=str(path), **options)
    yield 3.0


def press_in_browser(key):
    """A key in the file browser, which has a window of its own."""
    found = [
        (window, area)
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
        if area.type == "FILE_BROWSER"
    ]
    (window, area), *_ = found
    place = {"x": area.x + area.width // 2, "y": area.y + area.height // 2}
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", **place)
    yield 0.2
    window.event_simulate(type=key, value="PRESS", **place)
    window.event_simulate(type=key, value="RELEASE", **place)
    yield


def until(condition):
    """Wait for something to happen."""
    for _ in range(600):
        if condition():
            return
        yield 0.1
    raise AssertionError("it did not happen within a minute")
