"""A scene of bodies that fall and settle, or lie still, and a Blender that plays it with the
add-on."""

from __future__ import annotations

import functools
import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.authoring import materials as library
from haptic_tracing.addon.session import session
from haptic_tracing.core.render.frame_result import FrameResult
from haptic_tracing.core.scene.bands import BAND_CENTRES
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.scene.measured import physical
from mathutils import Euler

SOURCES, LISTENERS = 4, 10
FREQUENCIES = {"plain": (60.0,), "one": (60.0,), "four": (30.0, 60.0, 120.0, 250.0)}
"""Of the sources in turn, in hertz: by what the bodies are made of."""
SIZE = 0.5
SHAPES = ("BOX", "SPHERE", "CONVEX_HULL", "CYLINDER", "CAPSULE", "CONE", "MIXED")


def _mesh(kind: str) -> bpy.types.Mesh:
    half = SIZE / 2
    mesh = bpy.data.meshes.new(kind)
    if kind == "BOX":
        corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
        faces: list[tuple[int, ...]] = [
            (0, 1, 3, 2),
            (4, 6, 7, 5),
            (0, 4, 5, 1),
            (2, 3, 7, 6),
            (0, 2, 6, 4),
            (1, 5, 7, 3),
        ]
    else:
        turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        ring = [(half * np.cos(a), half * np.sin(a)) for a in turns]
        top = 1.6 * half if kind == "CAPSULE" else half
        corners = [(x, y, z) for z in (-top, top) for x, y in ring]
        faces = [
            tuple(range(11, -1, -1)),
            tuple(range(12, 24)),
            *((k, (k + 1) % 12, 12 + (k + 1) % 12, 12 + k) for k in range(12)),
        ]
    mesh.from_pydata(corners, [], faces)
    return mesh


def _add(
    name: str,
    mesh: bpy.types.Mesh | None,
    place: tuple[float, ...],
    turn: tuple[float, ...] = (0, 0, 0),
) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.location, obj.rotation_euler = place, Euler(turn)
    return obj


def _rigid(obj: bpy.types.Object, shape: str, kind: str = "ACTIVE") -> bpy.types.Object:
    bpy.context.scene.rigidbody_world.collection.objects.link(obj)
    body = obj.rigid_body
    body.type, body.collision_shape = kind, shape
    obj.haptics.function = "haptic_tracing"
    obj.haptics.enabled = True
    return obj


def build(
    frames: int,
    bodies: int,
    shape: str,
    settled: bool,
    strategy: str,
    impacts: bool,
    materials: str | None = None,
) -> bpy.types.Scene:
    """A new file with so many bodies above a ground: in layers, turned at random, that fall onto
    each other, or side by side at rest.

    ``materials``: None for the paper's function with the κ and ρ of new objects; ``made`` for what
    *Make Haptic* gives; else stone on soil as they were measured, with contacts by impedance: their
    ``plain`` gain without bands, or in bands with sources of ``one`` band or of ``four``.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.haptics.tracing = False
    scene.haptics.strategy, scene.haptics.impacts = strategy, impacts
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection, world.constraints = (
        bpy.data.collections.new("bodies"),
        bpy.data.collections.new("constraints"),
    )
    world.point_cache.frame_start, world.point_cache.frame_end = 1, frames
    kinds = SHAPES[:-1] if shape == "MIXED" else (shape,)
    meshes = {kind: _mesh(kind) for kind in kinds}
    random = np.random.default_rng(bodies)
    width = int(np.ceil(np.sqrt(bodies))) if settled else max(3, round((bodies / 4) ** (1 / 3) * 2))
    ground = _mesh("BOX")
    ground.name = "ground"
    ground.transform(np.diag([4.0 * width, 4.0 * width, 2.0, 1.0]).tolist())
    lying = _rigid(_add("ground", ground, (0, 0, -SIZE)), "BOX", "PASSIVE")
    made = []
    for k in range(bodies):
        layer, row, column = k // width**2, k // width % width, k % width
        gap = 0.7
        place = np.array([column - width / 2, row - width / 2, 0.0]) * gap + [
            0,
            0,
            SIZE / 2 + (0.0 if settled else 0.5 + gap * layer),
        ]
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
        made[
            (2 * k + 1) if settled else (2 * k + 1) * bodies // (2 * LISTENERS)
        ].haptics.listener.enabled = True
    bpy.context.view_layer.update()
    if materials == "made":
        library.make_haptic(scene, library.guesses([lying, *made]))
    elif materials is not None:
        _make_physical(scene, lying, made, materials)
    return scene


def _make_physical(
    scene: bpy.types.Scene,
    ground: bpy.types.Object,
    bodies: Sequence[bpy.types.Object],
    materials: str,
) -> None:
    """Give the bodies measured materials, contacts the impedances of these, and sources their
    frequencies."""
    for name, objects in (("soil", [ground]), ("stone", bodies)):
        library.apply(objects, library.preset_in(scene, MATERIALS[name]))
    library.make_physical([ground, *bodies], False)
    if materials == "plain":  # the damping of the lowest band at every frequency
        for name, obj in (("soil", ground), *(("stone", body) for body in bodies)):
            obj.haptics.absorption = physical(name, tuple(obj.dimensions)).material_damping(
                BAND_CENTRES[0]
            )
            obj.haptics.loss_factor = 0.0
    rule = scene.haptics.transmission_table.items.add()
    rule.first_kind, rule.second_kind, rule.function = "ANY", "ANY", "impedance"
    emitting = [body for body in bodies if body.haptics.source.enabled]
    for k, body in enumerate(emitting):
        body.haptics.source.frequency = FREQUENCIES[materials][k % len(FREQUENCIES[materials])]
    bpy.context.view_layer.update()


def play_in_turns(connection: Connection, tracing: bool, frames: int, *scene_of: Any) -> None:
    """Build a scene and play the frames that are asked for, with their times as answers; at ``()``
    tell what was traced, and end."""
    haptic_tracing.register()
    scene = build(frames, *scene_of)
    scene.haptics.tracing = tracing
    watch, results = _Watch(), []
    while numbers := connection.recv():
        seconds, worked, traced = _play(scene, numbers)
        results += traced
        connection.send((seconds, worked))
    connection.send(_traced(scene, watch, results) if tracing else None)
    haptic_tracing.unregister()


class _Work(NamedTuple):
    """What is kept of a traced frame. Its result is released, as sessions release it: results that
    all stay alive are traversed by every collection of garbage."""

    milliseconds: Mapping[str, float]
    statistics: Mapping[str, float]
    contacts: int

    @classmethod
    def of(cls, result: FrameResult) -> _Work:
        return cls(result.milliseconds, result.statistics, len(result.contacts))


def _traced(scene: bpy.types.Scene, watch: _Watch, results: Sequence[_Work]) -> dict[str, object]:
    """What `bench_frame.Traced` says; of plain values, so that who receives it need not import
    Blender."""
    return {
        "handler": 1000 * float(np.median(watch.seconds)),
        "stages": {
            stage: float(np.median([r.milliseconds[stage] for r in results]))
            for stage in results[0].milliseconds
        },
        "beyond": float(
            np.median([sum(r.milliseconds.values()) - r.milliseconds["read"] for r in results])
        ),
        "contacts": float(np.median([r.contacts for r in results])),
        "queries": sum(r.statistics["contact_queries"] for r in results) // len(results),
        "avoided": sum(r.statistics["queries_avoided"] for r in results) // len(results),
        "memory": _held(scene),
    }


class _Watch:
    """Times the add-on's frame handlers; a handler of its own would make the add-on read frames
    later, as beside other add-ons."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        handlers = bpy.app.handlers.frame_change_post
        handlers[:] = [self._timed(handler) for handler in handlers]

    def _timed(self, handler: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(handler)
        def timed(*arguments: Any) -> None:
            begun = time.perf_counter()
            handler(*arguments)
            self.seconds.append(time.perf_counter() - begun)

        return timed


def _play(
    scene: bpy.types.Scene, numbers: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, list[_Work]]:
    """Seconds of each frame, of CPU time of all threads in it, and what was traced."""
    seconds, worked, results = np.empty(len(numbers)), np.empty(len(numbers)), []
    for k, number in enumerate(numbers):
        if (own := session.of(scene)) is not None:
            own.is_asked = True  # for samples, as meters ask, which a new scene shows
        begun, working = time.perf_counter(), time.process_time()
        scene.frame_set(number)
        seconds[k], worked[k] = time.perf_counter() - begun, time.process_time() - working
        previous = session.of(scene).previous
        if k > 0 and previous is not None:
            results.append(_Work.of(previous))
    result = session.result_of(scene)
    return seconds, worked, results if result is None else [*results, _Work.of(result)]


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


def idle() -> tuple[float, float]:
    """Microseconds of the handler where there is nothing to do: where tracing is off, and where
    nothing is tagged."""
    haptic_tracing.register()
    medians = []
    for tracing in (False, True):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        scene = bpy.context.scene
        scene.haptics.tracing = tracing
        watch = _Watch()
        for frame in range(200):
            scene.frame_set(frame)
        medians.append(1e6 * float(np.median(watch.seconds)))
    haptic_tracing.unregister()
    return medians[0], medians[1]
