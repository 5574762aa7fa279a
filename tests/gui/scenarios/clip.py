"""A clip for a pad: three seconds with a sound, two listeners, baked, as WAV, .haptic and AHAP, by
clicks alone, which are counted."""

import wave

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

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
    """The window that shows a file browser, None without one."""
    for window in bpy.context.window_manager.windows:
        if any(area.type == "FILE_BROWSER" for area in window.screen.areas):
            return window
    return None


def steps(window):
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, 72
    boxes = []
    for name, place in (("Palm", (1.5, 0, 0)), ("Floor", (0, -1.5, 0))):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        boxes.append(bpy.context.object)
        boxes[-1].name = name
    write(window.folder / "blows.wav")
    bpy.ops.wm.save_as_mainfile(filepath=str(window.folder / "clip.blend"))
    job, storage = (window.module(name) for name in ("addon.blender.job", "addon.bake.storage"))

    def in_browser(picture, *places):
        """Click in the file browser: ``places`` from its left, or where negative its right edge, and
        from its lower or upper edge, and whether Shift is held."""
        yield from window.wait_until(lambda: browser() is not None)
        yield 2.0
        for right, up, shift in places:
            shown = browser()
            at = {"x": right % shown.width, "y": up % shown.height, "shift": shift}
            shown.event_simulate(type="MOUSEMOVE", value="NOTHING", x=at["x"], y=at["y"])
            yield 0.3
            for value in ("PRESS", "RELEASE"):
                shown.event_simulate(type="LEFTMOUSE", value=value, **at)
                yield 0.3
            window.clicks += 1
            window.save_picture(f"{picture}-{window.clicks}")
        yield from window.wait_until(lambda: browser() is None and job.Job.in_window is None)
        yield 1.0

    def select(obj):
        """Click an object, in the middle of its upper side."""
        region = window.region()
        top = obj.matrix_world.translation.copy()
        top.z += obj.dimensions.z / 2
        place = location_3d_to_region_2d(region, window.view.spaces.active.region_3d, top)
        window.point(region.x + place.x, region.y + place.y)
        yield 0.3
        yield from window.press("LEFTMOUSE")
        yield 0.5
        window.seen[f"a click selects {obj.name}"] = bpy.context.object == obj

    yield from window.show_sidebar()
    yield from select(scene.objects["Cube"])
    yield from window.click_button("haptic.import_sound")
    yield from in_browser("sound", (305, -104, False), (-72, 22, False))
    kept = scene.objects["Cube"].haptics.source.sound.kept
    window.seen["the sound is converted"] = bool(kept)
    for box in boxes:
        yield from select(box)
        yield from window.click_button("haptic.add_listener")
    yield from window.screenshot("clip-listeners")
    yield from window.click_button("haptic.bake")
    yield from window.wait_until(lambda: storage.track_of(scene) is not None)
    yield from window.wait_until(lambda: job.Job.in_window is None)
    yield from window.click_button("export_scene.haptic_tracks")
    formats = list(window.module("core.formats.io.catalogue").track_formats())
    wanted = [(-124, -88 - 23 * formats.index(name), True) for name in ("haptic", "ahap")]
    yield from in_browser("export", *wanted, (-72, 22, False))
    names = {path.suffix for path in window.folder.rglob("*clip*")}
    window.seen[f"all three formats, of {sorted(names)}"] = {".wav", ".haptic", ".ahap"} <= names
    window.seen[f"{window.clicks} clicks"] = window.clicks <= MOST
