"""Pictures without a GPU: scene and graph rendered by Cycles, labels and legend painted over
them."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.types import Scene
from numpy.typing import NDArray

from ..addon.changes.suspension import suspended
from ..addon.scene_reader.settings import read_settings
from ..addon.view.annotations import placed_annotations
from ..addon.view.camera import camera_view, picture_scale
from ..addon.view.render_data import render_data
from ..core import plugins
from ..core.arrays import FloatArray
from ..core.render.frame_result import FrameResult
from .raster import paint
from .shown import SMOOTHING, averaged, meters_above, shown_options

SAMPLES = 20
GRAPH_SAMPLES = 12  # enough for smooth edges, as nothing scatters light


def rendered_picture(
    scene: Scene, result: FrameResult, size: tuple[int, int], *, meters: bool = False
) -> NDArray[np.uint8]:
    """Pixels (height, width, 3), top row first. The scene is not changed."""
    data = render_data(result, read_settings(scene), shown_options(scene))
    view, projection = (np.array(matrix, dtype=np.float64) for matrix in camera_view(scene, size))
    points = size[1] / picture_scale(size)
    solids = _geometry("solids")
    unit = solids.seen_unit(data, projection, view, points)
    solid = solids.solid_graph(data, unit, view[:3, :3])
    with suspended():
        if scene.haptics.xray:
            canvas = rendered(scene, size, SAMPLES, denoise=True)[..., :3]
            graph = _rendered_alone(scene, solid, size)
            canvas += graph[..., 3:] * (graph[..., :3] - canvas)
        else:
            canvas = _rendered_among(scene, solid, size)[..., :3]
    canvas = canvas.repeat(SMOOTHING, axis=0).repeat(SMOOTHING, axis=1)
    large = SMOOTHING * size[0], SMOOTHING * size[1]
    scale = SMOOTHING * picture_scale(size)
    hud = meters_above(scene, result, large, scale) if meters else None
    occupied = hud.bounds if hud else ()
    free = 0.0, 0.0, *large
    paint(
        canvas,
        placed_annotations(data, projection @ view, large, scale, free, occupied),
        scale,
    )
    if hud is not None:
        paint(canvas, hud, scale)
    return averaged(np.rint(np.clip(canvas[::-1], 0, 1) * 255).astype(np.uint8))


def _geometry(name: str) -> Any:
    """A module of the plug-in that makes the graph geometry. Raises ValueError without it."""
    plugin = plugins.plugins().get("graph_geometry")
    if plugin is None:
        raise ValueError("a picture without a GPU needs the plug-in graph_geometry")
    return import_module(f"{plugin.__name__}.{name}")


def _rendered_alone(scene: Scene, solid: Any, size: tuple[int, int]) -> FloatArray:
    """The graph alone on a transparent background, in its own scene with a copy of the camera."""
    alone = bpy.data.scenes.new("Haptic Graph picture")
    camera = bpy.data.objects.new("Haptic Graph camera", scene.camera.data)
    camera.matrix_world = scene.camera.evaluated_get(
        scene.view_layers[0].depsgraph
    ).matrix_world.copy()
    graph = _geometry("graph_mesh").add_graph(alone.collection, solid)
    alone.collection.objects.link(camera)
    alone.camera = camera
    alone.render.film_transparent = True
    alone.view_settings.view_transform = "Standard"
    try:
        return rendered(alone, size, GRAPH_SAMPLES, denoise=False)
    finally:
        mesh = graph.data
        bpy.data.scenes.remove(alone)
        for obj in (graph, camera):
            bpy.data.objects.remove(obj)
        bpy.data.meshes.remove(mesh)


def _rendered_among(scene: Scene, solid: Any, size: tuple[int, int]) -> FloatArray:
    """The scene with the graph among its objects, which may hide it."""
    graph = _geometry("graph_mesh").add_graph(scene.collection, solid)
    try:
        return rendered(scene, size, SAMPLES, denoise=True)
    finally:
        mesh = graph.data
        bpy.data.objects.remove(graph)
        bpy.data.meshes.remove(mesh)


def rendered(scene: Scene, size: tuple[int, int], samples: int, *, denoise: bool) -> FloatArray:
    """Display values (height, width, 4), bottom row first, as Cycles renders the scene on the
    CPU."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        with _render_settings(scene, size, path, samples, denoise), _quiet():
            bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(str(path))
        try:
            values = np.empty(4 * size[0] * size[1], dtype=np.float32)
            image.pixels.foreach_get(values)
        finally:
            bpy.data.images.remove(image)
    return values.reshape(size[1], size[0], 4).astype(np.float64)


@contextmanager
def _quiet() -> Iterator[None]:
    """Discard Blender's standard output, a line for every tile that it renders."""
    sys.stdout.flush()
    kept = os.dup(1)
    with Path(os.devnull).open("w") as nothing:
        os.dup2(nothing.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


@contextmanager
def _render_settings(
    scene: Scene, size: tuple[int, int], path: Path, samples: int, denoise: bool
) -> Iterator[None]:
    render = scene.render
    wanted: list[tuple[Any, dict[str, Any]]] = [
        (
            render,
            {
                "engine": "CYCLES",
                "resolution_x": size[0],
                "resolution_y": size[1],
                "resolution_percentage": 100,
                "use_border": False,
                "use_compositing": False,
                "use_sequencer": False,
                "filepath": str(path),
                "use_file_extension": False,
            },
        ),
        (
            scene.cycles,
            {
                "device": "CPU",
                "samples": samples,
                "use_adaptive_sampling": True,
                "use_denoising": denoise,
            },
        ),
    ]
    if hasattr(render.image_settings, "media_type"):
        wanted.append((render.image_settings, {"media_type": "IMAGE"}))
    wanted.append(
        (render.image_settings, {"file_format": "PNG", "color_mode": "RGBA", "color_depth": "8"})
    )
    before = [(owner, {key: getattr(owner, key) for key in values}) for owner, values in wanted]
    try:
        for owner, values in wanted:
            _set(owner, values)
        yield
    finally:
        for owner, values in before:
            _set(owner, values)


def _set(owner: Any, values: dict[str, Any]) -> None:
    for key, value in values.items():
        setattr(owner, key, value)
