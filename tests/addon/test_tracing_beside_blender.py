"""A frame is traced beside Blender, on a thread of its own: with the same results, and without a
trace of it when it ends."""

from __future__ import annotations

import threading

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session, sessions, timeline, worker

pytestmark = pytest.mark.usefixtures("as_events")

FRAMES = 1, 40


def threads() -> list[str]:
    return [
        thread.name for thread in threading.enumerate() if thread.name.startswith("haptic-tracing")
    ]


@pytest.fixture
def bench(build):
    scene = build("jackhammer_bench")
    scene.haptics.tracing = True
    return scene


@pytest.mark.slow
def test_results_are_those_of_waiting_for_each_frame(bench):
    waited = [step.result for step in timeline.steps(bench, *FRAMES)]
    beside = list(timeline.results(bench, *FRAMES))
    assert (
        [r.number for r in beside]
        == [r.number for r in waited]
        == list(range(FRAMES[0], FRAMES[1] + 1))
    )
    for one, other in zip(waited, beside, strict=True):
        assert one.amplitudes.tobytes() == other.amplitudes.tobytes()
        assert one.contacts.positions.tobytes() == other.contacts.positions.tobytes()
        assert (one.block is None) == (other.block is None)
        assert one.block is None or one.block.tobytes() == other.block.tobytes()


def test_who_asks_waits_for_the_frame_that_the_scene_is_in(bench):
    bench.frame_set(5)
    assert session.of(bench).begun is not None
    assert session.result_of(bench).number == 5
    assert session.of(bench).begun is None
    assert np.isfinite(session.result_of(bench).statistics["waited_milliseconds"])


def test_a_frame_that_cannot_be_traced_is_named_and_the_next_one_is_traced(bench, monkeypatch):
    dust = bpy.data.objects.new("dust", bpy.data.meshes.new("dust"))
    bench.collection.objects.link(dust)
    dust.haptics.enabled = True
    tracer = session.of(bench).tracer
    step = tracer.step

    def fails_at_seven(frame):
        if frame.number == 7:
            raise ValueError("Bench: no gain")
        return step(frame)

    monkeypatch.setattr(type(tracer), "step", lambda self, frame: fails_at_seven(frame))
    with pytest.raises(ValueError, match="Frame 7 can't be traced: Bench: no gain"):
        list(timeline.results(bench, *FRAMES))
    bench.frame_set(7)
    assert session.of(bench).begun.exception() is not None
    assert not sessions.is_behind(bench)
    assert session.result_of(bench) is None
    assert [problem.object for problem in session.problems_of(bench)] == ["", "dust"]
    assert session.problems_of(bench)[0].message == "Bench: no gain"
    bench.frame_set(8)
    assert session.result_of(bench).number == 8
    assert not any("no gain" in problem.message for problem in session.problems_of(bench))


def test_a_fault_of_the_tracer_comes_to_light_once(bench, monkeypatch):
    monkeypatch.setattr(type(session.of(bench).tracer), "step", lambda self, frame: 1 / 0)
    bench.frame_set(3)
    with pytest.raises(ZeroDivisionError):
        session.result_of(bench)
    assert session.result_of(bench) is None


def test_no_thread_is_left_when_scenes_are_forgotten_while_a_frame_is_traced(bench):
    bench.frame_set(6)
    assert threads()
    session.clear()
    assert threads() == []
    bpy.context.scene.frame_set(7)
    assert session.result_of(bench).number == 7


def test_a_long_wait_shows_that_it_goes_on(bench, monkeypatch):
    shown = []
    monkeypatch.setattr(worker, "show", shown.append)
    step = type(session.of(bench).tracer).step

    def slow(self, frame):
        threading.Event().wait(0.5)
        return step(self, frame)

    monkeypatch.setattr(type(session.of(bench).tracer), "step", slow)
    bench.frame_set(4)
    assert session.result_of(bench).number == 4
    assert len(shown) > 1 and all(0 < part < 1 for part in shown)
