"""What tracing costs in scenes of concave, skinned and many objects.

    python -m benchmarks.bench_real_scenes [NAME ...]

Each scene is made by formulas (`real_scenes`) in a process of its own. *Make Haptic* is pressed
with all objects selected; one of them sounds and one is a listener. Blocks of frames are then
played without and with tracing in turns, the first frame of each left out; `off` and `on` are
medians of the processor's time of a frame, of all threads. `traced` is what of it the extension's
handlers and its thread take, and `worst` the longest of these: Blender's own threads wait actively
after each frame that animates a mesh, as long as nothing else comes. `edit`: as `on`, of a change
of κ of one object, which in `city` and `still` shares its mesh with thousands, all of which Blender
then evaluates. `memory` is what the tracer keeps, `file` the scene with its frames as a haptic
scene (`.json`), of 24 frames.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import tempfile
import threading
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

NAMES = ("kitchen", "robots", "walker", "pile", "rings", "city", "house", "still", "instances")
BLOCK = 10
EDITS = 5


class Row(NamedTuple):
    """A row of the table: seconds and milliseconds of the processor, bytes, and how many."""

    name: str
    objects: int
    contacts: int
    make_haptic: float
    first: float
    off: float
    on: float
    traced: float
    worst: float
    edit: float
    memory: int
    file: int


def measure(name: str) -> Row:
    """Build a scene, press *Make Haptic*, and play it."""
    import bpy
    import haptic_tracing
    from haptic_tracing.addon.session import session

    from . import real_scenes

    haptic_tracing.register()
    scene, objects = real_scenes.build(name)
    scene.haptics.tracing = False
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[-1]
    begun = time.process_time()
    bpy.ops.haptic.make_objects()
    bpy.context.view_layer.update()
    made = time.process_time() - begun
    objects[-1].haptics.source.enabled = objects[0].haptics.listener.enabled = True
    scene.frame_set(1)
    begun = time.process_time()
    result = session.trace(scene, bpy.context.evaluated_depsgraph_get(), live=True)
    first = time.process_time() - begun
    times: dict[bool, list[float]] = {False: [], True: []}
    own = []
    traced = _Traced()
    for begin in range(1, real_scenes.FRAMES + 1, BLOCK):
        tracing = scene.haptics.tracing = begin // BLOCK % 2 == 1
        for frame in range(begin, begin + BLOCK):
            begun, before = time.process_time(), traced.seconds
            scene.frame_set(frame)
            result = traced.call(session.result_of, scene) if tracing else result
            if frame > begin + 1:
                times[tracing].append(1000 * (time.process_time() - begun))
                own += [1000 * (traced.seconds - before)] if tracing else []
    off, on = (sorted(times[tracing]) for tracing in (False, True))
    own.sort()
    scene.haptics.tracing = True
    edits = []
    for _ in range(EDITS):
        begun = time.process_time()
        objects[1].haptics.kappa *= 0.99
        bpy.context.view_layer.update()
        session.result_of(scene)
        edits.append(1000 * (time.process_time() - begun))
    session.clear()
    tracemalloc.start()
    session.trace(scene, bpy.context.evaluated_depsgraph_get())
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return Row(
        name,
        len(objects),
        0 if result is None else len(result.contacts),
        made,
        1000 * first,
        off[len(off) // 2],
        on[len(on) // 2],
        own[len(own) // 2],
        own[-1],
        sorted(edits)[EDITS // 2],
        held,
        _file_size(scene),
    )


class _Traced:
    """Processor time that the extension takes: in its frame handlers, in functions called by
    `call`, and in its own thread."""

    def __init__(self) -> None:
        import bpy

        self._seconds = 0.0
        handlers = bpy.app.handlers.frame_change_post
        handlers[:] = [self._timed(handler) for handler in handlers]

    @property
    def seconds(self) -> float:
        """So far [s]."""
        return self._seconds + sum(
            time.clock_gettime(time.pthread_getcpuclockid(thread.ident))
            for thread in threading.enumerate()
            if thread.name.startswith("haptic-tracing") and thread.ident is not None
        )

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """What a function returns, whose time on this thread counts."""
        begun = time.thread_time()
        try:
            return function(*arguments)
        finally:
            self._seconds += time.thread_time() - begun

    def _timed(self, handler: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(handler)
        def timed(*arguments: Any) -> Any:
            return self.call(handler, *arguments)

        return timed


def _file_size(scene: object) -> int:
    import bpy

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.json"
        bpy.ops.export_scene.haptic_scene(
            filepath=str(path), frames="RANGE", frame_start=1, frame_end=24
        )
        return path.stat().st_size


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=NAMES)
    print(
        "scene    objects contacts | Make Haptic   first |    off      on  traced   worst    edit |"
        " memory   file"
    )
    print(
        "                          |         s      ms |     ms      ms      ms      ms      ms |"
        "     MB     MB"
    )
    for name in parser.parse_args().names:
        with multiprocessing.get_context("spawn").Pool(1) as process:
            row = process.apply(measure, (name,))
        print(
            f"{row.name:<9}{row.objects:7}{row.contacts:9} |{row.make_haptic:12.2f}{row.first:8.0f}"
            f" |{row.off:7.1f}{row.on:8.1f}{row.traced:8.1f}{row.worst:8.1f}{row.edit:8.1f} |"
            f"{row.memory / 1e6:7.1f}{row.file / 1e6:7.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
