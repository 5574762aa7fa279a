"""*Fit Material*: values that synthetic recordings were made with come back in the scene, and what
recordings don't determine is said."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.operators import design
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.design.recordings import read_recordings
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.wav import write_wav

RATE, SECONDS = 4000, 10
LENGTH, LOSS, SPEED, K = 3.0, 0.06, 200.0, 0.28
"""Metres between source and contact; loss factor, speed and K of the floor as its material has
them."""
DAMPING, GAIN = 1.7, 0.4
"""What the recordings are made with: the material's damping times so much, and the contact's
gain."""


@pytest.fixture
def asked(scene, add_box, add_empty, tmp_path):
    """A floor that a motor shakes, a pad on it that carries a listener, recordings of both, and
    what Fit Material is asked."""
    floor, pad = (
        add_box("Floor", (0, 0, -0.1), (8, 1, 0.2)),
        add_box("Pad", (LENGTH, 0, 0.005), (0.01, 0.01, 0.01)),
    )
    pad.haptics.function, pad.haptics.constant = "constant", 1.0
    haptics = floor.haptics
    haptics.function, haptics.wave, haptics.loss_factor, haptics.phase_speed = (
        "physical",
        "rod",
        LOSS,
        SPEED,
    )
    haptics.material_k, haptics.kappa, haptics.rho = K, 0.6, 0.7
    motor, hand = add_empty("Motor", (0, 0, 0), floor), add_empty("Hand", (LENGTH, 0, 0), pad)
    motor.haptics.source.enabled = hand.haptics.listener.enabled = True
    fit = scene.haptics.materials.fit
    fit.source, fit.listener, fit.object, fit.first, fit.second = motor, hand, floor, floor, pad
    fit.source_file, fit.listener_file = recordings(tmp_path)
    bpy.context.view_layer.update()
    return fit


def recordings(folder, length=LENGTH, scale=1.0):
    """Noise at the source, and what the formula of a damped wave makes of it."""
    generator = np.random.default_rng(8)
    source = 0.1 * generator.normal(size=RATE * SECONDS)
    alpha = np.pi * np.fft.rfftfreq(len(source), 1 / RATE) * LOSS / SPEED * DAMPING
    heard = scale * np.fft.irfft(np.fft.rfft(source) * np.exp(-alpha * length) * GAIN, len(source))
    heard += 0.01 * heard.std() * generator.normal(size=len(heard))
    paths = []
    for name, samples in (("source", source), ("listener", heard)):
        paths.append(str(folder / f"{name}.wav"))
        write_wav(Tracks((ListenerTrack(name, ""),), RATE, samples[None]), paths[-1], "float32")
    return paths


def test_the_values_of_the_recordings_come_back(asked):
    assert bpy.ops.haptic.fit_material() == {"FINISHED"}
    floor = bpy.data.objects["Floor"].haptics
    assert (1 - floor.kappa) * floor.rho == pytest.approx(K**DAMPING, rel=0.02)
    rule = bpy.context.scene.haptics.transmission_table.items[0]
    assert ({rule.first, rule.second}, rule.function) == ({"Floor", "Pad"}, "constant")
    assert rule.constant == pytest.approx(GAIN, rel=0.02)
    assert asked.values[4] > 5 > 0.5 > asked.values[5]  # decibels off, before and after
    assert asked.doubts == ""
    table = np.array(asked.bands).reshape(-1, 4)
    assert table[:, 0] == pytest.approx(table[:, 2], abs=0.3)  # the model now, in each band
    assert np.all(table[:, 3] > 0.9)
    bpy.context.view_layer.update()
    found = session.result_of(bpy.context.scene).propagation.band_gain[0, 0]
    assert found[2] == pytest.approx(
        GAIN * np.exp(-np.pi * (80 * 160) ** 0.5 * LOSS / SPEED * DAMPING * LENGTH), rel=0.05
    )


def test_the_rule_of_a_contact_is_used_again(asked):
    bpy.ops.haptic.fit_material()
    bpy.ops.haptic.fit_material()
    assert len(bpy.context.scene.haptics.transmission_table.items) == 1
    assert asked.values[4] == pytest.approx(asked.values[5], abs=0.01)  # nothing is left to fit


def test_a_material_changes_with_all_that_is_made_of_it(asked):
    floor = bpy.data.objects["Floor"]
    bpy.context.view_layer.objects.active = floor
    bpy.ops.haptic.new_material()
    bpy.ops.haptic.fit_material()
    item = bpy.context.scene.haptics.materials.items[floor.haptics.material.name]
    assert (1 - item.kappa) * item.rho == pytest.approx(K**DAMPING, rel=0.02)
    assert floor.haptics.kappa == pytest.approx(item.kappa)


def test_recordings_that_are_not_calibrated_alike_tell_the_loss_alone(asked, tmp_path):
    asked.source_file, asked.listener_file = recordings(tmp_path, scale=7.0)
    asked.is_calibrated = False
    assert bpy.ops.haptic.fit_material() == {"FINISHED"}
    assert asked.values[0] == pytest.approx(DAMPING, rel=0.02)
    assert len(bpy.context.scene.haptics.transmission_table.items) == 0


def test_a_contact_that_would_amplify_is_doubted(asked, tmp_path):
    asked.source_file, asked.listener_file = recordings(tmp_path, scale=7.0)
    bpy.ops.haptic.fit_material()
    assert "not calibrated alike" in asked.doubts


def test_what_is_wrong_is_said(scene, asked, tmp_path):
    asked.object = bpy.data.objects["Pad"]
    with pytest.raises(RuntimeError, match="only objects with the function physical"):
        bpy.ops.haptic.fit_material()
    asked.object = bpy.data.objects["Floor"]
    session.trace(scene, bpy.context.evaluated_depsgraph_get(), live=True)
    steps = design._steps(
        scene,
        sessions.shown(scene).result.graph,
        read_recordings(Path(asked.source_file), Path(asked.listener_file)),
        [],
    )
    next(steps)
    bpy.data.objects.remove(asked.object)
    with pytest.raises(ValueError, match="an object first"):
        list(steps)
    asked.object, asked.source_file = bpy.data.objects["Pad"], str(tmp_path / "none.wav")
    with pytest.raises(RuntimeError, match=r"none\.wav"):
        bpy.ops.haptic.fit_material()
