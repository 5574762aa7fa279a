"""CPU time of a redraw of the 3D viewport with the haptic graph and the meters over it.

    python -m benchmarks.bench_overlay [--nodes 5000] [--listeners 10 100] [--redraws 200]

The add-on's own draw handlers are called as Blender calls them, for a viewport of 1600 x 1000
pixels. `nothing changed`: as while the pointer moves; `view turns`: every redraw from another
place; `next frame`: every redraw of another frame, in which all objects stand still; `all moves`:
in which contacts and gains are others. Milliseconds of CPU time of this thread, median and 95 %,
without the draw calls, which are the GPU's; the worker thread has computed the graph's shapes and
the levels before. `labels` is the part that lays labels and legend out and puts them into a batch.
`in software` is all of it, drawn by Mesa's software rasteriser in place of a GPU, which takes most
of the time.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from types import SimpleNamespace
from typing import Any
from unittest import mock

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.scene_reader.settings import read_settings
from haptic_tracing.addon.session import session, sessions, worker
from haptic_tracing.addon.view import meters, overlay, shader
from haptic_tracing.addon.view.options import options_of
from haptic_tracing.addon.view.render_data import render_data
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.render.frame_result import FrameResult
from haptic_tracing.core.scene.functions import Exponential
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    Listener,
    Settings,
    Source,
    Strategy,
)
from haptic_tracing.core.tracer import Frame, Tracer
from haptic_tracing.pictures import picture
from mathutils import Euler, Matrix

from .report import publish, table

GOAL = 2.0
SIZE = (1600, 1000)
SOURCES = 4
CHANGES = ("nothing changed", "view turns", "next frame", "all moves")


@dataclass(frozen=True, slots=True)
class Row:
    """One way of redrawing. Milliseconds: median and 95 % of the handlers, of laying labels out,
    and of all with drawing in software."""

    nodes: int
    listeners: int
    labels: bool
    change: str
    median: float
    high: float
    layout: float
    software: float


def wall_of_bricks(nodes: int, listeners: int) -> FrameResult:
    """A wall of bricks with about so many nodes: sources at its foot, listeners anywhere, empties
    of their names in the scene."""
    across = round((nodes / 6) ** 0.5)
    place = {
        (x, z): (x + z % 2 / 2 - across / 2, 0.0, z / 2 - across / 4)
        for z in range(across)
        for x in range(across)
    }
    contacts: list[Contact] = []
    for x, z in place:
        for other in ((x + 1, z), (x, z - 1), (x + (1 if z % 2 else -1), z - 1)):
            if other in place and len(contacts) < (nodes - SOURCES - listeners) // 2:
                at = tuple((np.add(place[x, z], place[other]) / 2).tolist())
                contacts.append(
                    Contact((f"brick {x} {z}", f"brick {other[0]} {other[1]}"), (at, at))
                )
    objects = tuple(
        HapticObject(name, 0.0, 1.0, Exponential(alpha=0.4))
        for name in sorted(f"brick {x} {z}" for x, z in place)
    )
    chosen = np.random.default_rng(1).integers(0, across, (listeners, 2)).tolist()
    sources = tuple(
        Source(f"source {k}", f"brick {k * 7} 0", place[k * 7, 0]) for k in range(SOURCES)
    )
    felt = tuple(
        Listener(f"listener {k}", f"brick {x} {z}", place[x, z]) for k, (x, z) in enumerate(chosen)
    )
    for name in (item.name for items in (sources, felt) for item in items):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, None))
    placed = ContactSet.from_contacts(
        tuple(contacts), {item.name: k for k, item in enumerate(objects)}
    )
    settings = Settings(strategy=Strategy.BEST_PATH, max_connections=None)
    return Tracer().step(Frame(1, 0.0, objects, sources, felt, settings, contacts=placed))


@contextmanager
def viewport(scene: bpy.types.Scene) -> Iterator[Callable[[float], None]]:
    """Redraws a 3D viewport, seen from the side by an angle [rad], as the handlers do; into a
    buffer of `SIZE` pixels."""
    from gpu.types import GPUOffScreen

    near, far = 0.1, 500.0
    window = Matrix(
        (
            (2, 0, 0, 0),
            (0, 2 * SIZE[0] / SIZE[1], 0, 0),
            (0, 0, (far + near) / (near - far), 2 * far * near / (near - far)),
            (0, 0, -1, 0),
        )
    )
    region = SimpleNamespace(
        type="WINDOW", x=0, y=0, width=SIZE[0], height=SIZE[1], as_pointer=lambda: 1
    )
    context = SimpleNamespace(
        scene=scene,
        screen=None,
        preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
        view_layer=bpy.context.view_layer,
        space_data=SimpleNamespace(
            overlay=SimpleNamespace(show_overlays=True, show_text=True),
            show_gizmo=True,
            region_quadviews=(),
        ),
        area=SimpleNamespace(regions=(region,)),
        region=region,
    )
    blender = SimpleNamespace(context=context, data=bpy.data, app=bpy.app)

    def redraw(turn: float) -> None:
        view = (
            Matrix.Translation((0, 0, -35))
            @ Euler((-np.pi / 2, 0, 0)).to_matrix().to_4x4()
            @ Euler((0, 0, turn)).to_matrix().to_4x4()
        )
        context.region_data = SimpleNamespace(
            window_matrix=window, view_matrix=view, perspective_matrix=window @ view
        )
        overlay.draw_view()
        meters.draw_pixels()
        overlay.draw_pixels()

    buffer = GPUOffScreen(*SIZE)
    try:
        with (
            mock.patch.object(overlay, "bpy", blender),
            mock.patch.object(meters, "bpy", blender),
            buffer.bind(),
        ):
            yield redraw
    finally:
        overlay.forget()
        meters._shown.clear()
        buffer.free()


def timed(function: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    """The function, wrapped to add its duration [s] to the last of ``spent``."""

    def call(*values: Any, **named: Any) -> Any:
        started = time.thread_time()
        try:
            return function(*values, **named)
        finally:
            spent[-1] += time.thread_time() - started

    return call


def without_drawing(batch: Any, *values: Any, **named: Any) -> None:
    """`shader.draw`, all but the draw call."""
    _draw(SimpleNamespace(draw=lambda program: None), *values, **named)


_draw = shader.draw


def measured(
    scene: bpy.types.Scene, result: FrameResult, change: str, redraws: int, gpu: bool
) -> tuple[list[float], list[float]]:
    """Milliseconds of each redraw, and of the label layout in it."""
    import gpu as graphics

    each, layout = [], []
    show(scene, result)
    drawing = shader.draw if gpu else without_drawing
    spent = [0.0]
    annotations = timed(overlay.draw_annotations, spent)
    with (
        viewport(scene) as redraw,
        mock.patch.object(shader, "draw", drawing),
        mock.patch.object(overlay, "draw_annotations", annotations),
    ):
        for number in range(redraws + 10):
            if change in ("next frame", "all moves"):
                show(
                    scene,
                    replace(
                        result,
                        graph=replace(result.graph) if change == "all moves" else result.graph,
                    ),
                )
            spent[-1] = 0.0
            # Mesa draws in threads of its own.
            clock = time.perf_counter if gpu else time.thread_time
            started = clock()
            redraw(0.01 * number if change == "view turns" else 0.0)
            if gpu:
                graphics.state.active_framebuffer_get().read_color(
                    0, 0, 1, 1, 4, 0, "UBYTE"
                )  # waits until all is drawn
            each.append(1000 * (clock() - started))
            layout.append(1000 * spent[-1])
    return each[10:], layout[10:]


def show(scene: bpy.types.Scene, result: FrameResult) -> None:
    """Make ``result`` the last frame that is complete, and wait until the worker has computed what
    is drawn of it."""
    own = session.of(scene)
    own.result = result
    own.history.feed(result)
    own.shown = sessions.Traced(result, read_settings(scene), own.history.all())
    for derived in tuple(own.derived):
        worker.submit(derived.follow, own).result()


def rows(nodes: int, listeners: int, redraws: int) -> Iterator[Row]:
    """Every change, with and without labels."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    result = wall_of_bricks(nodes, listeners)
    for labels in (False, True):
        scene.haptics.show_labels = labels
        for change in CHANGES:
            each, layout = measured(scene, result, change, redraws, gpu=False)
            software, _ = measured(scene, result, change, max(redraws // 10, 5), gpu=True)
            low, high = (float(np.percentile(each, share)) for share in (50, 95))
            yield Row(
                result.graph.node_count,
                listeners,
                labels,
                change,
                low,
                high,
                float(np.median(layout)),
                float(np.median(software)),
            )


def quads_drawn(nodes: int, listeners: int) -> str:
    """The amount of geometry drawn, as text."""
    from haptic_tracing.addon.view.quads import quads

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    result = wall_of_bricks(nodes, listeners)
    data = render_data(result, read_settings(scene), options_of(scene, result))
    graph = quads(data)
    size = sum(values.nbytes for values in graph.attributes.values()) + graph.triangles.nbytes
    return (
        f"{result.graph.node_count} nodes, {listeners} listeners: the graph is {graph.count} "
        "quads in one draw call "
        f"({4 * graph.count} vertices, {size / 1e6:.1f} MB; two calls where objects may hide "
        "it), sent to the GPU when a frame differs "
        "from the one before. Labels and legend are a second draw call, the meters a third."
    )


def main() -> None:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--nodes", type=int, default=5000)
    parser.add_argument("--listeners", type=int, nargs="+", default=[10, 100])
    parser.add_argument("--redraws", type=int, default=200)
    options = parser.parse_args()
    haptic_tracing.register()
    if not picture.starts_gpu():
        raise SystemExit("this Blender can't draw off-screen: 5.2 or later with EGL is needed")
    found = [
        row
        for listeners in options.listeners
        for row in rows(options.nodes, listeners, options.redraws)
    ]
    text = table(
        ("redraw", "labels", "listeners", "median ms", "95 % ms", "labels ms", "in software ms"),
        [
            (
                r.change,
                "on" if r.labels else "off",
                str(r.listeners),
                f"{r.median:.2f}",
                f"{r.high:.2f}",
                f"{r.layout:.2f}",
                f"{r.software:.1f}",
            )
            for r in found
        ],
    )
    words = [quads_drawn(options.nodes, listeners) for listeners in options.listeners]
    haptic_tracing.unregister()
    goal = f"The goal is {GOAL:g} ms a redraw of {options.nodes} nodes."
    publish(
        "overlay",
        "A redraw of the overlay",
        "\n\n".join([text, *words, goal]),
        [asdict(row) for row in found],
    )


if __name__ == "__main__":
    main()
