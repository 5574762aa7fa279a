"""Fit Material in the sidebar: two recordings give the loss of a floor and the gain of a contact;
cancelled by Esc; one step of undo."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

RATE, LENGTH, LOSS, SPEED, DAMPING, GAIN = 4000, 3.0, 0.06, 200.0, 1.7, 0.4


def recordings(window, seconds):
    """Noise at the source, and what the formula of a damped wave makes of it at the listener."""
    write_wav = window.module("core.formats.tracks.wav").write_wav
    listener_tracks = window.module("core.formats.tracks.listener_tracks")
    source = 0.1 * np.random.default_rng(8).normal(size=RATE * seconds)
    alpha = np.pi * np.fft.rfftfreq(len(source), 1 / RATE) * LOSS / SPEED * DAMPING
    heard = np.fft.irfft(np.fft.rfft(source) * np.exp(-alpha * LENGTH) * GAIN, len(source))
    folder = Path(tempfile.mkdtemp())
    for name, samples in (("source", source), ("listener", heard)):
        tracks = listener_tracks.Tracks(
            (listener_tracks.ListenerTrack(name, ""),), RATE, samples[None]
        )
        write_wav(tracks, folder / f"{name}.wav", "float32")
    return [str(folder / f"{name}.wav") for name in ("source", "listener")]


def box(name, location, size):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    bpy.context.object.name, bpy.context.object.scale = name, size
    bpy.context.object.haptics.enabled = True
    return bpy.context.object


def empty(name, parent, at):
    obj = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(obj)
    obj.parent, obj.location = parent, at
    obj.matrix_parent_inverse = parent.matrix_world.inverted()
    return obj


def steps(window):
    bpy.context.preferences.view.ui_scale = 0.8
    scene = bpy.context.scene
    floor, pad = (
        box("Floor", (0, 0, -0.1), (8, 1, 0.2)),
        box("Pad", (LENGTH, 0, 0.1), (0.2, 0.2, 0.2)),
    )
    bpy.context.view_layer.update()
    pad.haptics.function, pad.haptics.constant = "constant", 1.0
    haptics = floor.haptics
    haptics.function, haptics.wave, haptics.loss_factor, haptics.phase_speed = (
        "physical",
        "rod",
        LOSS,
        SPEED,
    )
    haptics.material_k, haptics.kappa, haptics.rho = 0.28, 0.6, 0.7
    motor, hand = empty("Motor", floor, (0, 0, 0)), empty("Hand", pad, (LENGTH, 0, 0))
    motor.haptics.source.enabled = hand.haptics.listener.enabled = True
    fit = scene.haptics.materials.fit
    fit.source, fit.listener, fit.object, fit.first, fit.second = motor, hand, floor, floor, pad
    fit.source_file, fit.listener_file = recordings(window, 200)
    window.open_only(
        "HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_materials", "HAPTIC_PT_fit"
    )
    yield from window.show_sidebar()
    yield from window.show_properties("SCENE")
    bpy.ops.ed.undo_push(message="Asked")
    yield 1.0
    yield from window.screenshot("asked")
    job = window.module("addon.blender.job")
    budget = job.BUDGET
    job.BUDGET = 0.0  # a window of the recordings at a time: long enough to press a key
    yield from window.click_button("haptic.fit_material")
    yield from window.wait_until(
        lambda: job.Job.in_window is not None and job.Job.in_window.done > 0
    )
    yield from window.screenshot("running")
    yield from window.press("ESC")
    yield from window.wait_until(lambda: job.Job.in_window is None)
    window.seen["Esc leaves all as it was"] = (
        abs(floor.haptics.kappa - 0.6) < 1e-6 and not fit.fitted
    )
    job.BUDGET = budget
    yield 0.5
    yield from window.click_button("haptic.fit_material")
    yield from window.wait_until(
        lambda: bool(bpy.context.scene.haptics.materials.fit.fitted) and job.Job.in_window is None
    )
    yield 1.0
    found = bpy.data.objects["Floor"].haptics
    window.seen["the loss comes back"] = (
        abs((1 - found.kappa) * found.rho / 0.28**DAMPING - 1) < 0.05
    )
    window.seen["the contact comes back"] = (
        abs(bpy.context.scene.haptics.transmission_table.items[0].constant / GAIN - 1) < 0.05
    )
    yield from window.scroll_sidebar(30)
    yield from window.screenshot("fitted")
    yield from window.undo()
    yield 0.5
    scene = bpy.context.scene
    window.seen["undo brings all back"] = (
        abs(bpy.data.objects["Floor"].haptics.kappa - 0.6) < 1e-6
        and len(scene.haptics.transmission_table.items) == 0
        and not scene.haptics.materials.fit.fitted
    )
