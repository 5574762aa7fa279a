"""A clip for a pad: three seconds with a sound, two listeners, baked, as WAV, .haptic and AHAP; the
clicks are counted."""

import wave

import bpy
import numpy as np

MOST = 13


def write(path):
    """Blows twice a second."""
    t = np.arange(3 * 48000) / 48000
    samples = 0.7 * np.sin(2 * np.pi * 160 * t) * np.exp(-np.mod(t, 0.5) / 0.1)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(48000)
        file.writeframes((samples * 32767).astype("<i2").tobytes())


def browser():
    """The window, area and region of the file browser."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "FILE_BROWSER":
                region = next(region for region in area.regions if region.type == "WINDOW")
                return {"window": window, "area": area, "region": region}
    return None


def steps(window):
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, 72
    cube = scene.objects["Cube"]
    boxes = []
    for name, x in (("Palm", 1.5), ("Floor", -1.5)):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(x, 0, 0))
        boxes.append(bpy.context.object)
        boxes[-1].name = name
    sound = window.folder / "blows.wav"
    write(sound)
    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "clip.blend"))
    job, storage = (window.module(name) for name in ("addon.blender.job", "addon.bake.storage"))

    def choose(path, clicks):
        """Choose a file in the browser, by ``clicks``."""
        yield from window.wait_until(lambda: browser() is not None)
        yield 1.0
        params = browser()["area"].spaces.active.params
        params.directory, params.filename = f"{path.parent}/".encode(), path.name
        window.save_picture(path.suffix[1:])
        with bpy.context.temp_override(**browser()):
            bpy.ops.file.execute()
        window.clicks += clicks
        yield from window.wait_until(lambda: browser() is None and job.Job.in_window is None)
        yield 1.0

    def select(obj):
        bpy.ops.object.select_all(action="DESELECT")
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        yield 0.5

    yield from window.show_sidebar()
    yield from select(cube)
    yield from window.click_button("haptic.import_sound")
    yield from choose(sound, 2)
    window.seen["the sound is converted"] = bool(cube.haptics.source.sound.kept)
    for box in boxes:
        yield from select(box)
        window.clicks += 1
        yield from window.click_button("haptic.add_listener")
    yield from window.screenshot("clip-listeners")
    yield from window.click_button("haptic.bake")
    yield from window.wait_until(lambda: storage.track_of(scene) is not None)
    yield from window.wait_until(lambda: job.Job.in_window is None)
    yield from window.click_button("export_scene.haptic_tracks")
    yield from window.wait_until(lambda: browser() is not None)
    yield 1.0
    browser()["area"].spaces.active.active_operator.formats = {"wav", "haptic", "ahap"}
    window.clicks += 2
    yield from choose(window.folder / "clip.wav", 1)
    names = {path.suffix for path in window.folder.rglob("*clip*")}
    window.seen[f"all three formats, of {sorted(names)}"] = {".wav", ".haptic", ".ahap"} <= names
    window.seen[f"{window.clicks} clicks"] = window.clicks <= MOST
