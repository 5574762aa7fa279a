"""Draw callbacks never wait: while a trace is held up, every panel, menu, poll and view handler
returns with the frame before; once the trace has ended, they show the new one."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import recording_layout
from haptic_tracing.addon.registration import classes
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view import layout, meters, overlay
from haptic_tracing.core.tracer import Tracer
from haptic_tracing.pictures import picture
from mathutils import Matrix

pytestmark = pytest.mark.usefixtures("as_events")

SIZE = (900, 600)
PATIENCE = 60.0
"""Seconds after which a test that waits for the worker fails."""


@pytest.fixture
def felt(scene, add_box, add_empty):
    """A shaker on the ground, a foot on it, a hand on a crate that hangs above."""
    ground = add_box("ground", (0, 0, -0.1), (4, 4, 0.2))
    crate = add_box("crate", (1, 0, 0.29), (0.5, 0.5, 0.5))
    add_empty("shaker", (-0.25, 0, 0), ground).haptics.source.enabled = True
    for name, parent, part in (("foot", ground, "foot.L"), ("hand", crate, "hand.R")):
        listener = add_empty(name, (0, 0, 0), parent)
        listener.haptics.listener.enabled = True
        listener.haptics.listener.body_part = part
    bpy.context.view_layer.objects.active = bpy.data.objects["hand"]
    scene.frame_set(1)
    assert session.result_of(scene).number == 1
    return scene


@pytest.fixture
def held_up(monkeypatch):
    """Traces from now on do not begin until the returned event is set, and whoever waits for one on
    the main thread fails."""
    release = threading.Event()
    step, result, exception = Tracer.step, Future.result, Future.exception
    main = threading.main_thread()

    def blocked_step(self, frame):
        assert release.wait(PATIENCE)
        return step(self, frame)

    def checked_result(self, *arguments):
        assert self.done() or release.is_set() or threading.current_thread() is not main, (
            "a draw waits for the worker"
        )
        return result(self, *arguments)

    def checked_exception(self, *arguments):
        assert self.done() or release.is_set() or threading.current_thread() is not main, (
            "a draw waits for the worker"
        )
        return exception(self, *arguments)

    monkeypatch.setattr(Tracer, "step", blocked_step)
    monkeypatch.setattr(Future, "result", checked_result)
    monkeypatch.setattr(Future, "exception", checked_exception)  # `worker.done_within` waits by it
    yield release
    release.set()


def panels():
    """The panels as they are registered, each drawn as Blender would: poll, header, body."""
    return [cls for cls in classes.CLASSES if issubclass(cls, bpy.types.Panel)]


def drawn(panel):
    """What a panel shows."""
    recorder = recording_layout.RecordingLayout()
    if not hasattr(panel, "poll") or panel.poll(bpy.context):
        shown = SimpleNamespace(layout=recorder)
        for part in ("draw_header", "draw"):
            if hasattr(panel, part):
                getattr(panel, part)(shown, bpy.context)
    return recorder


def named(name):
    return next(panel for panel in panels() if panel.__name__ == name)


def test_every_panel_draws_while_a_trace_is_held_up_and_then_shows_it(felt, settle, held_up):
    held_up.set()
    before = {panel.__name__: settle(lambda panel=panel: drawn(panel)).labels for panel in panels()}
    assert "shaker" in before["HAPTIC_PT_result"]
    held_up.clear()
    felt.frame_set(2)
    assert sessions.is_behind(felt)
    time.sleep(1.1)
    meanwhile = {panel.__name__: drawn(panel).labels for panel in panels()}
    assert "shaker" in meanwhile["HAPTIC_PT_result"]
    assert "Tracing for 1 s..." in meanwhile["HAPTIC_PT_scene"]
    assert any("crate" in label for label in meanwhile["HAPTIC_PT_why"]), "the last reasons stay"
    assert sessions.is_behind(felt), "nobody has waited"
    held_up.set()
    after = {panel.__name__: settle(lambda panel=panel: drawn(panel)).labels for panel in panels()}
    assert sessions.shown(felt).result.number == 2
    assert not any(label.startswith("Tracing") for label in after["HAPTIC_PT_scene"])
    assert not sessions.is_behind(felt)


def test_panels_draw_while_the_very_first_trace_is_held_up(felt, settle, held_up):
    session.clear()
    felt.frame_set(2)
    for panel in panels():
        drawn(panel)
    assert sessions.is_behind(felt)
    held_up.set()
    assert "shaker" in settle(lambda: drawn(named("HAPTIC_PT_result"))).labels


def test_no_poll_waits_for_a_trace(felt, held_up):
    felt.frame_set(2)
    for cls in classes.CLASSES:
        if issubclass(cls, bpy.types.Operator) and hasattr(cls, "poll"):
            cls.poll(bpy.context)
    assert sessions.is_behind(felt)


@pytest.fixture
def viewport(felt, monkeypatch):
    """Redraws a 3D viewport as Blender does, into an off-screen buffer; returns its pixels."""
    if not picture.starts_gpu():
        assert bpy.app.version < (5, 2), (
            "Blender 5.2 on can draw off-screen with Mesa: install libegl1 and libgl1-mesa-dri"
        )
        pytest.skip("before Blender 5.2 nothing can be drawn without a window")
    import gpu

    view = Matrix.Translation((0, 0, -8))
    window = Matrix(((2, 0, 0, 0), (0, 3, 0, 0), (0, 0, -1.01, -0.2), (0, 0, -1, 0)))
    region = SimpleNamespace(
        type="WINDOW", x=0, y=0, width=SIZE[0], height=SIZE[1], as_pointer=lambda: 1
    )
    region_data = SimpleNamespace(
        window_matrix=window,
        view_matrix=view,
        perspective_matrix=window @ view,
        view_perspective="PERSP",
    )
    context = SimpleNamespace(
        scene=felt,
        screen=None,
        preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
        view_layer=bpy.context.view_layer,
        space_data=SimpleNamespace(
            overlay=SimpleNamespace(show_overlays=True, show_text=False),
            show_gizmo=False,
            region_quadviews=(),
        ),
        area=SimpleNamespace(regions=(region,)),
        region=region,
        region_data=region_data,
    )
    blender = SimpleNamespace(context=context, data=bpy.data, app=bpy.app)
    for module in (overlay, meters):
        monkeypatch.setattr(module, "bpy", blender)
    buffer = gpu.types.GPUOffScreen(*SIZE)

    def redraw():
        with buffer.bind():
            frame_buffer = gpu.state.active_framebuffer_get()
            frame_buffer.clear(color=(0.0, 0.0, 0.0, 1.0), depth=1.0)
            overlay.draw_view()
            meters.draw_pixels()
            overlay.draw_pixels()
            pixels = frame_buffer.read_color(0, 0, *SIZE, 4, 0, "UBYTE")
        pixels.dimensions = SIZE[0] * SIZE[1] * 4
        return np.array(pixels, dtype=np.uint8).reshape(SIZE[1], SIZE[0], 4)[..., :3].astype(int)

    yield redraw
    buffer.free()
    overlay.forget()
    meters._shown.clear()


def test_the_view_is_drawn_while_a_trace_is_held_up_and_then_shows_it(
    felt, settle, held_up, viewport
):
    held_up.set()
    before = settle(viewport)
    assert (before > 40).any(), "graph, meters and legend"
    held_up.clear()
    bpy.data.objects["foot"].location.x = 0.9
    felt.frame_set(2)
    meanwhile = viewport()
    covered = np.zeros(before.shape[:2], dtype=bool)
    for left, bottom, right, top in meters.occupied(meters.bpy.context):
        covered[int(bottom) : int(top), int(left) : int(right)] = True
    assert covered.any()
    assert np.array_equal(meanwhile[~covered], before[~covered]), (
        "the graph of the frame before; the meters say that one is coming"
    )
    assert sessions.is_behind(felt)
    held_up.set()
    after = settle(viewport)
    assert not sessions.is_behind(felt)
    assert (np.abs(after - before)[~covered].max(axis=1) > 40).sum() > 50, "the foot has moved"


def test_the_layout_keeps_meters_and_legend_apart(felt, settle, viewport):
    settle(viewport)
    shown = meters.occupied(meters.bpy.context)
    assert shown
    assert layout.free_rectangle(meters.bpy.context) == (0.0, 0.0, *map(float, SIZE))
    assert shown[0][2] - shown[0][0] <= 0.45 * SIZE[0]
