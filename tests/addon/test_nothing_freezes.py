"""While a frame takes long to trace, edits, clicks and frames go on: none of them waits for it."""

from __future__ import annotations

import threading
import time

import bpy
import pytest
from haptic_tracing.addon.panels.hints import next_step
from haptic_tracing.addon.registration import handlers
from haptic_tracing.addon.session import session, sessions, worker
from haptic_tracing.core.tracer import Tracer

pytestmark = pytest.mark.usefixtures("as_events")

LONG = 60.0
"""Seconds that the slow trace would take."""


@pytest.fixture
def slow(scene, add_box, monkeypatch):
    """A box that hums and feels; its next trace takes long, those after it are as quick as ever."""
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    scene.frame_set(1)
    assert session.result_of(scene).amplitudes[0, 0] > 0
    monkeypatch.setattr(worker, "is_interactive", lambda: True)
    runs, step = threading.Event(), Tracer.step

    def slow_step(self, frame):
        if runs.is_set():
            return step(self, frame)
        runs.set()
        ends = time.monotonic() + LONG
        while time.monotonic() < ends:
            time.sleep(0.001)
        raise AssertionError("nobody cancelled it")

    monkeypatch.setattr(Tracer, "step", slow_step)
    box.haptics.rho = 0.9
    bpy.context.view_layer.update()
    assert runs.wait(LONG)
    assert sessions.is_behind(scene)
    return box


def test_an_edit_takes_the_place_of_the_one_that_is_traced(slow, scene):
    slow.haptics.rho = 0.25
    slow.haptics.kappa = 0.2
    bpy.context.view_layer.update()
    assert session.result_of(scene).amplitudes[0, 0] == pytest.approx((1 - 0.2) * 0.25, rel=1e-6)
    assert not sessions.is_behind(scene)


def test_another_frame_takes_its_place(slow, scene, monkeypatch):
    monkeypatch.setattr(handlers, "_PATIENCE", 0.01)
    scene.frame_set(7)
    assert session.result_of(scene).number == 7


def test_frames_that_play_go_by_without_it(slow, scene, monkeypatch):
    monkeypatch.setattr(handlers, "_PATIENCE", 0.01)
    monkeypatch.setattr(handlers, "is_playing", lambda: True)
    shown = sessions.shown(scene)
    for frame in range(2, 8):
        scene.frame_set(frame)
    assert sessions.is_behind(scene)
    assert sessions.shown(scene) is shown
    session.cancel()


def test_saving_does_not_wait(slow, scene, tmp_path):
    scene.haptics.kept_impacts = "as it was"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert sessions.is_behind(scene)
    assert scene.haptics.kept_impacts == "as it was"
    session.cancel()


def test_it_is_cancelled_and_what_was_shown_stays(slow, scene):
    shown = sessions.shown(scene)
    assert bpy.ops.haptic.cancel_tracing() == {"FINISHED"}
    assert not sessions.is_behind(scene)
    assert sessions.shown(scene) is shown
    assert not bpy.ops.haptic.cancel_tracing.poll()
    # Where it was the first trace of all, the hint leads to another.
    sessions.known(scene).shown = None
    assert next_step(scene).words == "Nothing traced yet"
    slow.haptics.rho = 0.5
    bpy.context.view_layer.update()
    assert session.result_of(scene).amplitudes[0, 0] == pytest.approx(0.9 * 0.5, rel=1e-6)
