"""A sound is chosen and converted with the button; both waves show; a long one shows its progress
and is cancelled; a fault is said."""

import tempfile
import wave
from pathlib import Path

import bpy
import numpy as np


def write(path, seconds):
    """Blows twice a second over a hum that swells."""
    t = np.arange(round(seconds * 48000)) / 48000
    blow = 0.7 * np.sin(2 * np.pi * 900 * t) * np.exp(-np.mod(t, 0.5) / 0.03)
    samples = blow + 0.15 * np.sin(2 * np.pi * 80 * t) * np.sin(np.pi * t / seconds)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(48000)
        file.writeframes((samples * 32767).astype("<i2").tobytes())
    return str(path)


def steps(window):
    folder = Path(tempfile.mkdtemp())
    job = window.module("addon.blender.job")
    obj = bpy.context.scene.objects["Cube"]
    window.open_only("HAPTIC_PT_object_settings", "HAPTIC_PT_source", "HAPTIC_PT_sound")
    yield from window.show_sidebar()
    yield from window.show_properties("OBJECT")
    obj.haptics.enabled = obj.haptics.source.enabled = obj.haptics.listener.enabled = True
    obj.haptics.source.signal = "SOUND"
    sound = obj.haptics.source.sound
    sound.filepath = str(folder / "missing.wav")
    yield 0.5
    yield from window.open_panel("haptics.source.enabled")
    window.seen["a missing file is said"] = "missing.wav" in sound.fault
    yield from window.screenshot("missing-sound")
    sound.filepath = write(folder / "short.wav", 4.0)
    sound.carrier = "PITCH"
    yield 0.5
    yield from window.click_button("haptic.convert_sound")
    yield from window.wait_until(lambda: bool(sound.kept))
    yield 1.0
    window.seen["converted"] = sound.fault == "" and len(sound.waves) > 0
    yield from window.screenshot("sound-and-vibration")
    kept = sound.kept
    sound.filepath = write(folder / "long.wav", 600.0)
    yield 0.5
    yield from window.click_button("haptic.convert_sound")
    yield from window.wait_until(
        lambda: job.Job.in_window is not None and job.Job.in_window.done > 2, 60.0
    )
    yield from window.screenshot("sound-progress")
    yield from window.press("ESC")
    yield from window.wait_until(lambda: job.Job.in_window is None)
    window.seen["cancelled, and what was there stays"] = sound.kept == kept
    yield from window.click_button("haptic.convert_sound")
    yield from window.wait_until(lambda: sound.kept != kept, 240.0)
    yield 1.0
    window.seen["ten minutes are converted"] = not sound.is_edited
    yield from window.screenshot("long-sound-and-vibration")
    yield from window.undo()
    sound = bpy.context.scene.objects["Cube"].haptics.source.sound
    window.seen["undone"] = sound.kept == kept
