"""What Blender does next does not wait for a trace: an endless one ends with file load, undo, redo,
render, exit and disabling."""

from __future__ import annotations

import threading
import time

import bpy
import haptic_tracing
import pytest
from haptic_tracing.addon.registration import handlers
from haptic_tracing.addon.session import session, sessions, worker

pytestmark = pytest.mark.usefixtures("as_events")


def load():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def undo():
    bpy.ops.ed.undo()


def redo():
    bpy.ops.ed.redo()


def render():
    bpy.ops.render.render()


def disable():
    haptic_tracing.unregister()
    haptic_tracing.register()


def leave():
    handlers.cancel()  # Blender calls its exit handlers only when it ends


@pytest.fixture
def rattle(scene, add_box, add_empty):
    """A humming box on another, whose listener feels it at frame 1; all of it can be undone, and an
    undone edit be redone."""
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = True
    listener = add_empty("listener", parent=add_box("lid", (0, 0, 0.55), (1, 1, 0.1)))
    listener.haptics.listener.enabled = True
    bpy.ops.ed.undo_push(message="scene")
    box.location.x = 0.1
    bpy.ops.ed.undo_push(message="edit")
    bpy.ops.ed.undo_push(message="another")
    bpy.ops.ed.undo()
    bpy.context.scene.frame_set(1)
    assert session.result_of(bpy.context.scene).amplitudes[0, 0] > 0.0
    return bpy.context.scene


def endless(monkeypatch, scene):
    """Begin a trace that only a cancellation ends, and wait until it runs."""
    runs = threading.Event()

    def step(self, frame):
        while True:
            runs.set()
            time.sleep(0.001)

    with monkeypatch.context() as patch:
        patch.setattr(type(session.of(scene).tracer), "step", step)
        scene.frame_set(2)
        assert runs.wait(60.0)
    return session.of(scene).begun


@pytest.mark.parametrize(
    "event", [load, undo, redo, disable, leave, render], ids=lambda event: event.__name__
)
def test_an_endless_trace_is_cancelled(monkeypatch, rattle, event):
    begun = endless(monkeypatch, rattle)
    event()
    assert isinstance(begun.exception(), worker.Cancelled)
    scene = bpy.context.scene
    if event is not load:
        scene.frame_set(3)
        assert (
            session.result_of(scene).number == 3 and session.result_of(scene).amplitudes[0, 0] > 0.0
        )


def test_a_trace_that_a_render_cancelled_is_made_up_for(monkeypatch, rattle):
    """Whoever asks gets it; who only looks sees it as soon as nothing renders any more."""
    endless(monkeypatch, rattle)
    handlers.render_pre()
    assert sessions.shown(rattle) is None
    assert session.result_of(rattle).number == 2
    endless(monkeypatch, rattle)
    handlers.render_pre()
    worker._redraw_after_jobs()  # Blender calls it by a timer, in its window
    session.of(rattle).begun.result()
    assert sessions.shown(rattle).result.number == 2


def test_who_waits_when_a_render_begins_on_its_thread_waits_no_longer(monkeypatch, rattle):
    """The interrupted tracer is not used again, and the frame is traced for who asks next."""
    endless(monkeypatch, rattle)
    tracer = session.of(rattle).tracer
    render = threading.Timer(0.3, handlers.render_pre)
    render.start()
    assert session.result_of(rattle) is None
    render.join()
    assert session.of(rattle).tracer is not tracer
    assert session.result_of(rattle).number == 2


def test_what_waits_behind_a_cancelled_trace_is_dropped_or_computed_anew(monkeypatch, rattle):
    """A value that a panel wants was queued behind the trace: the next redraw queues it again."""
    from haptic_tracing.addon.session.derived import Background

    background = Background()
    endless(monkeypatch, rattle)
    assert background.latest(1, lambda before: "value") is None
    session.cancel()
    assert background.latest(1, lambda before: "value") is None
    while worker._state.pending:
        time.sleep(0.001)
    assert background.latest(1, lambda before: "value").value == "value"


def test_a_cancellation_between_two_jobs_hits_neither():
    """Thousands of short jobs and cancellations: each job has ended well, was cancelled, or was
    dropped, and none waits for ever."""
    ends = {"value": 0, "cancelled": 0, "dropped": 0}
    for number in range(2000):
        job = worker.submit(sum, range(number % 50 * 20))
        if number % 3:
            time.sleep(number % 7 * 1e-5)
        worker.cancel()
        if job.cancelled():
            ends["dropped"] += 1
        else:
            ends["cancelled" if isinstance(job.exception(60.0), worker.Cancelled) else "value"] += 1
    assert sum(ends.values()) == 2000 and ends["value"] > 0
    worker.shut_down()
