"""What tracing adds to Blender's own frame while rigid bodies fall and settle, or lie still.

    python -m benchmarks.bench_frame [--bodies 100 1000 3000] [--settled 10000] [--frames 200] [--shape BOX] [--strategy auto] [--impacts]

Every frame is simulated by Blender and traced by the add-on, on a thread beside it. The same frames are played without and with tracing,
three times in turns, and the quicker of each frame's times counts: what else a machine does comes and goes. `off` is the median of
Blender's own frame without, `on` that of the frame with tracing, `cost` the median of their ratio frame by frame, less one. `CPU` is the
same of CPU time, of all threads: what tracing costs where there is no second core. `handler` is what the add-on's frame handler takes of
it: reading, and waiting where the last frame is still being traced. 4 sources are on bodies, 10 listeners on others; all contacts that
signals reach are wanted. Impacts are found, and with `--impacts` each makes one more source. Settled bodies lie asleep on the ground with
one source at the edge; beyond reading the transforms, Blender waits for the rest of the handler, and all other stages pass beside it.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
import tracemalloc
from dataclasses import dataclass

os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="haptic-tracing-blender-"))
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon import session
from mathutils import Euler

GOALS = {100: 0.25, 1000: 0.06, 3000: 0.05}
SETTLED_GOAL = 1.0
SOURCES, LISTENERS = 4, 10
PASSES = 3
SIZE = 0.5
SHAPES = ("BOX", "SPHERE", "CONVEX_HULL", "CYLINDER", "CAPSULE", "CONE", "MIXED")


@dataclass(frozen=True, slots=True)
class Row:
    """Medians over the frames of one scene: milliseconds of the frame without and with tracing, and by how much one is above the other;
    the same of CPU time; milliseconds of the handler, and of each stage; narrow-phase queries made and avoided per frame, all told; bytes
    that the tracer holds."""

    bodies: int
    off: float
    on: float
    cost: float
    off_cpu: float
    on_cpu: float
    cost_cpu: float
    handler: float
    stages: dict[str, float]
    beyond: float
    contacts: float
    queries: int
    avoided: int
    memory: int


def _mesh(kind: str) -> bpy.types.Mesh:
    half = SIZE / 2
    mesh = bpy.data.meshes.new(kind)
    if kind == "BOX":
        corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    else:
        turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        ring = [(half * np.cos(a), half * np.sin(a)) for a in turns]
        top = 1.6 * half if kind == "CAPSULE" else half
        corners = [(x, y, z) for z in (-top, top) for x, y in ring]
        faces = [tuple(range(11, -1, -1)), tuple(range(12, 24)), *((k, (k + 1) % 12, 12 + (k + 1) % 12, 12 + k) for k in range(12))]
    mesh.from_pydata(corners, [], faces)
    return mesh


def _add(name: str, mesh: bpy.types.Mesh | None, place: tuple[float, ...], turn: tuple[float, ...] = (0, 0, 0)) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.location, obj.rotation_euler = place, Euler(turn)
    return obj


def _rigid(obj: bpy.types.Object, shape: str, kind: str = "ACTIVE") -> bpy.types.Object:
    bpy.context.scene.rigidbody_world.collection.objects.link(obj)
    body = obj.rigid_body
    body.type, body.collision_shape = kind, shape
    obj.haptics.enabled = True
    return obj


def build(bodies: int, shape: str, frames: int, settled: bool, strategy: str, impacts: bool) -> bpy.types.Scene:
    """A new file with so many bodies above a ground: in layers, turned at random, that fall onto each other, or side by side at rest."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.haptics.tracing = False
    scene.haptics.strategy, scene.haptics.impacts = strategy, impacts
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection, world.constraints = bpy.data.collections.new("bodies"), bpy.data.collections.new("constraints")
    world.point_cache.frame_start, world.point_cache.frame_end = 1, frames
    kinds = SHAPES[:-1] if shape == "MIXED" else (shape,)
    meshes = {kind: _mesh(kind) for kind in kinds}
    random = np.random.default_rng(bodies)
    width = int(np.ceil(np.sqrt(bodies))) if settled else max(3, round((bodies / 4) ** (1 / 3) * 2))
    ground = _mesh("BOX")
    ground.name = "ground"
    ground.transform(np.diag([4.0 * width, 4.0 * width, 2.0, 1.0]).tolist())
    _rigid(_add("ground", ground, (0, 0, -SIZE)), "BOX", "PASSIVE")
    made = []
    for k in range(bodies):
        layer, row, column = k // width**2, k // width % width, k % width
        gap = 0.7
        place = np.array([column - width / 2, row - width / 2, 0.0]) * gap + [0, 0, SIZE / 2 + (0.0 if settled else 0.5 + gap * layer)]
        turn = np.zeros(3)
        if not settled:
            place[:2] += random.uniform(-0.1, 0.1, 2)
            turn = random.uniform(-0.5, 0.5, 3)
        kind = kinds[k % len(kinds)]
        made.append(_rigid(_add(f"body {k:05d}", meshes[kind], tuple(place), tuple(turn)), kind))
        made[-1].rigid_body.use_deactivation = settled
    for k in range(1 if settled else SOURCES):
        made[k * bodies // SOURCES].haptics.source.enabled = True
    for k in range(LISTENERS):
        made[(2 * k + 1) if settled else (2 * k + 1) * bodies // (2 * LISTENERS)].haptics.listener.enabled = True
    bpy.context.view_layer.update()
    return scene


class _Watch:
    """Times the add-on's handler from the handlers before and after it."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        handlers = bpy.app.handlers.frame_change_post
        handlers.insert(0, self._begin)
        handlers.append(self._end)

    def _begin(self, *_: object) -> None:
        self._begun = time.perf_counter()

    def _end(self, *_: object) -> None:
        self.seconds.append(time.perf_counter() - self._begun)


def measure(bodies: int, shape: str, frames: int, settled: bool, strategy: str, impacts: bool) -> Row:
    """Play the scene without tracing and with it, in turns."""
    off, off_cpu, on, on_cpu = np.full((4, frames), np.inf)
    for _ in range(PASSES):
        scene = build(bodies, shape, frames, settled, strategy, impacts)
        seconds, worked, _ = _play(scene, frames)
        off, off_cpu = np.minimum(off, seconds), np.minimum(off_cpu, worked)
        scene = build(bodies, shape, frames, settled, strategy, impacts)
        scene.haptics.tracing = True
        watch = _Watch()
        seconds, worked, results = _play(scene, frames)
        on, on_cpu = np.minimum(on, seconds), np.minimum(on_cpu, worked)
    stages = {stage: float(np.median([r.milliseconds[stage] for r in results])) for stage in results[0].milliseconds}
    return Row(
        bodies=bodies,
        off=1000 * float(np.median(off)),
        on=1000 * float(np.median(on)),
        cost=float(np.median(on / off)) - 1,
        off_cpu=1000 * float(np.median(off_cpu)),
        on_cpu=1000 * float(np.median(on_cpu)),
        cost_cpu=float(np.median(on_cpu / off_cpu)) - 1,
        handler=1000 * float(np.median(watch.seconds)),
        stages=stages,
        beyond=float(np.median([sum(r.milliseconds.values()) - r.milliseconds["read"] for r in results])),
        contacts=float(np.median([len(r.contacts) for r in results])),
        queries=sum(r.statistics["contact_queries"] for r in results) // frames,
        avoided=sum(r.statistics["queries_avoided"] for r in results) // frames,
        memory=_held(scene),
    )


def _play(scene: bpy.types.Scene, frames: int) -> tuple[np.ndarray, np.ndarray, list]:
    """Seconds of each frame, of CPU time of all threads in it, and what was traced."""
    seconds, worked, results = np.empty(frames), np.empty(frames), []
    for k in range(frames):
        begun, working = time.perf_counter(), time.process_time()
        scene.frame_set(k + 1)
        seconds[k], worked[k] = time.perf_counter() - begun, time.process_time() - working
        previous = session.of(scene).previous
        if previous is not None:
            results.append(previous)
    result = session.result_of(scene)
    return seconds, worked, results if result is None else [*results, result]


def _held(scene: bpy.types.Scene) -> int:
    """Bytes that tracing the last frames anew takes and keeps."""
    session.clear()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    tracemalloc.start()
    for _ in range(2):
        session.trace(scene, depsgraph)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return held


def run(
    bodies: tuple[int, ...] = (100, 1000, 3000),
    settled: int = 10_000,
    frames: int = 200,
    shape: str = "BOX",
    strategy: str = "auto",
    impacts: bool = False,
) -> list[Row]:
    """Print the table; its rows."""
    print(f"{frames} frames, {shape.lower()}, {SOURCES} sources, {LISTENERS} listeners, strategy {strategy}; milliseconds a frame")
    print(" bodies      off       on    cost   goal | CPU: off       on    cost | handler | contacts  queries  avoided     MB  stages")
    rows = []
    haptic_tracing.register()
    try:
        for count in bodies:
            row = measure(count, shape, frames, False, strategy, impacts)
            rows.append(row)
            goal = f"{GOALS[count]:.0%}" if count in GOALS else ""
            _show(row, f"{row.cost:7.1%} {goal:>6}")
        if settled:
            row = measure(settled, shape, frames, True, strategy, impacts)
            rows.append(row)
            _show(row, f"{row.cost:7.1%} {'':>6}")
            waits = row.handler - row.stages["read"]
            words = f"Blender waits {waits:.2f} ms a frame beyond reading (goal {SETTLED_GOAL:g} ms), {row.beyond:.2f} ms pass beside it"
            print(f"{settled} settled, one local source: {words}", flush=True)
        print(f"the handler where tracing is off: {_idle(False):.1f} us, where nothing is tagged: {_idle(True):.1f} us (goal 20 us)")
    finally:
        haptic_tracing.unregister()
    return rows


def _idle(tracing: bool) -> float:
    """Microseconds of the handler where there is nothing to do."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.haptics.tracing = tracing
    watch = _Watch()
    for frame in range(200):
        scene.frame_set(frame)
    return 1e6 * float(np.median(watch.seconds))


def _show(row: Row, cost: str) -> None:
    stages = ", ".join(f"{stage} {milliseconds:.2f}" for stage, milliseconds in row.stages.items())
    print(
        f"{row.bodies:7} {row.off:8.2f} {row.on:8.2f} {cost} | {row.off_cpu:8.2f} {row.on_cpu:8.2f} {row.cost_cpu:7.1%} |"
        f" {row.handler:7.2f} | {row.contacts:8.0f} {row.queries:8} {row.avoided:8} {row.memory / 1e6:6.1f}  {stages}",
        flush=True,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, nargs="*", default=[100, 1000, 3000])
    parser.add_argument("--settled", type=int, default=10_000)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--shape", choices=SHAPES, default="BOX")
    parser.add_argument("--strategy", choices=("auto", "best_path", "all_paths", "energy_balance"), default="auto")
    parser.add_argument("--impacts", action="store_true")
    options = parser.parse_args()
    run(tuple(options.bodies), options.settled, options.frames, options.shape, options.strategy, options.impacts)


if __name__ == "__main__":
    main()
