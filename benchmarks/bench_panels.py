"""Duration of a redraw of the panel Result while a lattice of boxes is traced, and of the worker's
computations for it.

    python -m benchmarks.bench_panels [--edges 3 4 5] [--frames 5]

The lattice has 3, 4 or 5 boxes along each edge, a source in one corner, listeners in two others and
one on a box that nothing touches. `redraw` is the longest redraw after a new frame, until all is
shown: what Blender's window waits for. `complete after` is the time from the new frame until the
panel shows it, tracing not included. Milliseconds of wall-clock time, medians over the frames.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import Any

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.panels import result as panels
from haptic_tracing.addon.registration.properties import classes_of
from haptic_tracing.addon.session import derived, session, worker

from .report import publish, table

PANELS: tuple[Any, ...] = classes_of(panels)


@dataclass(frozen=True, slots=True)
class Row:
    """One panel over one lattice. Milliseconds."""

    boxes: int
    panel: str
    redraw: float
    complete: float


class _Layout:
    """Stands in for UILayout: everything it is asked for is a layout again."""

    def __getattr__(self, name: str) -> Any:
        return lambda *_, **__: _Layout()


def lattice(edge: int) -> bpy.types.Scene:
    """Boxes that touch, ``edge`` along each axis."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("box")
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    mesh.from_pydata(
        corners,
        [],
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
    )
    for place in (*np.ndindex(edge, edge, edge), (0, 0, edge + 1)):
        box = _added(scene, "box {} {} {}".format(*place), mesh)
        box.location = place
        box.haptics.function = "haptic_tracing"
        box.haptics.enabled = True
    far = edge - 1
    for name, place, role in (
        ("shaker", (0, 0, 0), "source"),
        ("near", (far, 0, 0), "listener"),
        ("far", (far, far, far), "listener"),
        ("deaf", (0, 0, edge + 1), "listener"),
    ):
        empty = _added(scene, name, None)
        empty.parent = bpy.data.objects["box {} {} {}".format(*place)]
        getattr(empty.haptics, role).enabled = True
    bpy.context.view_layer.objects.active = bpy.data.objects["deaf"]
    return scene


def _added(scene: bpy.types.Scene, name: str, data: bpy.types.Mesh | None) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    return obj


def redraws(panel: Any) -> tuple[float, float]:
    """Milliseconds of the longest redraw until nothing more is computed, and until then."""
    began, longest = time.perf_counter(), 0.0
    while True:
        started = time.perf_counter()
        if panel.poll(bpy.context) if hasattr(panel, "poll") else True:
            panel.draw(SimpleNamespace(layout=_Layout()), bpy.context)
        longest = max(longest, time.perf_counter() - started)
        if not worker._state.pending:
            return 1000 * longest, 1000 * (time.perf_counter() - began)
        while worker._state.pending:
            time.sleep(1e-3)


def rows(edge: int, frames: int) -> list[Row]:
    """Every panel over one lattice."""
    scene = lattice(edge)
    measured: dict[str, list[tuple[float, float]]] = {panel.bl_label: [] for panel in PANELS}
    for _ in range(frames):
        session.trace(scene, bpy.context.evaluated_depsgraph_get())
        for panel in PANELS:
            measured[panel.bl_label].append(redraws(panel))
    medians = {
        label: np.median(np.array(values), axis=0).tolist() for label, values in measured.items()
    }
    return [Row(edge**3, label, redraw, complete) for label, (redraw, complete) in medians.items()]


def main() -> None:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--edges", type=int, nargs="+", default=[3, 4, 5])
    parser.add_argument("--frames", type=int, default=5)
    options = parser.parse_args()
    haptic_tracing.register()
    derived._REST = 0.0  # as if nothing had been edited for a moment
    found = [row for edge in options.edges for row in rows(edge, options.frames)]
    haptic_tracing.unregister()
    text = table(
        ("boxes", "panel", "redraw ms", "complete after ms"),
        [(str(row.boxes), row.panel, f"{row.redraw:.2f}", f"{row.complete:.1f}") for row in found],
    )
    publish("panels", "A redraw of the panel Result", text, [asdict(row) for row in found])


if __name__ == "__main__":
    main()
