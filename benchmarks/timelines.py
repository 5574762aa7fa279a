"""Two timelines in Blender whose levels are known in closed form: spheres that fall, and a
vibrating sled that passes a listener."""

from __future__ import annotations

import math

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.session import timeline
from haptic_tracing.core.formats.tracks.track_recorder import TrackRecorder
from haptic_tracing.core.scene.functions import Exponential

GRAVITY = 9.81
HEIGHTS = np.linspace(0.3, 2.5, 12)
ENERGIES = np.linspace(8.0, 80.0, len(HEIGHTS))
E_MAX = 100.0
RADIUS = 0.2
FALLING = 1.0
"""Seconds of the drops."""
SPEED, ASIDE, TONE, DECAY = 3.0, 0.5, 100.0, 1.0
PASSING = 2.0
"""Seconds of the sled's way, half of them before it is nearest to the listener."""


def frame_row(
    rate: int, substeps: int
) -> tuple[int, int, int, int, float, float, float, float, float]:
    """The fields of `bench_accuracy.FrameRow`."""
    haptic_tracing.register()
    try:
        missed, invented, energy, late, blender, tracing = drops(rate, substeps)
        return (
            rate,
            substeps,
            missed,
            invented,
            energy,
            late,
            passing_error(rate, substeps),
            blender,
            tracing,
        )
    finally:
        haptic_tracing.unregister()


def _empty_scene(rate: int, substeps: int, seconds: float) -> bpy.types.Scene:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps = rate
    scene.frame_start, scene.frame_end = 1, 1 + math.ceil(seconds * rate)
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.substeps_per_frame = substeps
    world.point_cache.frame_end = scene.frame_end
    return scene


def _body(
    kind: str, place: tuple[float, float, float], size: float, motion: str
) -> bpy.types.Object:
    """A rigid body tagged as haptic, of the paper's function until told otherwise."""
    add = bpy.ops.mesh.primitive_cube_add if kind == "BOX" else bpy.ops.mesh.primitive_uv_sphere_add
    add(location=place, **({"size": size} if kind == "BOX" else {"radius": size / 2}))
    obj = bpy.context.view_layer.objects.active
    assert obj is not None
    bpy.ops.rigidbody.object_add(type=motion)
    obj.rigid_body.collision_shape = kind
    obj.haptics.function = "haptic_tracing"
    obj.haptics.enabled = True
    return obj


def drops(rate: int, substeps: int) -> tuple[int, int, float, float, float, float]:
    """Impacts missed and invented, the largest errors of level [dB] and time [ms], and milliseconds
    of Blender and of tracing for each second."""
    scene = _empty_scene(rate, substeps, FALLING)
    ground = _body("BOX", (0.0, 0.0, -0.5), 1.0, "PASSIVE")
    ground.scale = (40.0, 40.0, 1.0)
    names = []
    for number, (height, energy) in enumerate(
        zip(HEIGHTS.tolist(), ENERGIES.tolist(), strict=True)
    ):
        sphere = _body(
            "SPHERE",
            (1.5 * (number - len(HEIGHTS) / 2), 0.0, RADIUS + height),
            2 * RADIUS,
            "ACTIVE",
        )
        sphere.rigid_body.mass = energy / (GRAVITY * height)
        sphere.rigid_body.linear_damping = 0.0
        names.append(sphere.name)
    bpy.context.view_layer.update()
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    blender = tracing = 0.0
    for step in timeline.steps(scene, scene.frame_start, scene.frame_end):
        blender, tracing = blender + step.blender_milliseconds, tracing + step.tracing_milliseconds
        for impact in step.result.impacts:
            name = next(
                step.result.objects[number]
                for number in impact.objects
                if step.result.objects[number] in found
            )
            found[name].append((impact.amplitude, impact.time))
    first = [found[name][0] if found[name] else None for name in names]
    levels = [
        20 * math.log10(one[0] * E_MAX / energy)
        for one, energy in zip(first, ENERGIES.tolist(), strict=True)
        if one
    ]
    late = [
        1000 * (one[1] - math.sqrt(2 * height / GRAVITY))
        for one, height in zip(first, HEIGHTS.tolist(), strict=True)
        if one
    ]
    invented = sum(len(impacts) > 1 for impacts in found.values())
    energy, delay = (float(np.abs(values).max(initial=0.0)) for values in (levels, late))
    return first.count(None), invented, energy, delay, blender / FALLING, tracing / FALLING


def passing_error(rate: int, substeps: int) -> float:
    """Largest error [dB] of the level of a tone, over its periods, while the sled passes."""
    scene = _empty_scene(rate, substeps, PASSING)
    ground = _body("BOX", (0.0, 0.0, -0.5), 1.0, "PASSIVE")
    ground.scale = (40.0, 40.0, 1.0)
    sled = _body("BOX", (0.0, 0.0, 0.1), 0.2, "PASSIVE")
    sled.rigid_body.kinematic = True
    for obj in (ground, sled):
        obj.haptics.function, obj.haptics.alpha = Exponential.name, DECAY
    for frame, side in ((scene.frame_start, -1.0), (scene.frame_end, 1.0)):
        sled.location.x = side * SPEED * (scene.frame_end - scene.frame_start) / rate / 2
        sled.keyframe_insert("location", frame=frame)
    for curve in _curves(sled):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    sled.haptics.source.enabled, sled.haptics.source.frequency = True, TONE
    bpy.ops.object.empty_add(location=(0.0, ASIDE, 0.0))
    bpy.context.object.parent = ground
    bpy.context.object.matrix_parent_inverse = ground.matrix_world.inverted()
    listener = bpy.context.object.haptics.listener
    listener.enabled, listener.radius, listener.limiter = True, 0.0, False
    bpy.context.view_layer.update()
    recorder = TrackRecorder()
    for step in timeline.steps(scene, scene.frame_start, scene.frame_end):
        recorder.add(step.result)
    tracks = recorder.tracks()
    samples = np.asarray(tracks.samples[0], dtype=np.float64)
    period = round(tracks.sample_rate / TONE)
    count = len(samples) // period
    powers = (samples[: count * period].reshape(count, period) ** 2).mean(axis=1)
    middle = (np.arange(count) + 0.5) / TONE
    along = SPEED * (middle - (scene.frame_end - scene.frame_start) / rate / 2)
    exact = (
        sled.haptics.source.amplitude
        / math.sqrt(2)
        * np.exp(-DECAY * (0.1 + np.hypot(along, ASIDE)))
    )
    felt = (middle > 0.2) & (middle < PASSING - 0.2)
    return float(np.abs(10 * np.log10(powers[felt]) - 20 * np.log10(exact[felt])).max())


def _curves(obj: bpy.types.Object) -> list[bpy.types.FCurve]:
    from haptic_tracing.addon.blender.compatibility import fcurves_of

    return list(fcurves_of(obj))
