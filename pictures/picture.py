"""A picture of a scene with its haptic graph over it, seen from the scene's camera, without a
window."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import bpy
import gpu
import numpy as np
from bpy.types import Scene
from gpu.types import GPUOffScreen
from numpy.typing import NDArray

from ..addon.blender import compatibility
from ..addon.scene_reader.settings import read_settings
from ..addon.view import overlay
from ..addon.view.camera import camera_view, picture_scale
from ..addon.view.hud import Hud
from ..addon.view.render_data import Options
from ..addon.view.screen import draw_flat, uploaded
from ..core.render.frame_result import FrameResult
from .cycles_picture import rendered_picture
from .png import write_png
from .shown import SMOOTHING, averaged, meters_above, shown_options


def draw_picture(
    scene: Scene,
    result: FrameResult,
    path: str | Path,
    size: tuple[int, int] = (1280, 720),
    *,
    meters: bool = False,
) -> None:
    """Write a PNG of ``size`` pixels: the viewport with the graph over it where the GPU can draw
    off-screen, else both rendered by Cycles. ``meters``: how much each listener feels, at the upper
    left.

    Raises ValueError if the scene has no camera.
    """
    if scene.camera is None:
        raise ValueError(f"scene {scene.name!r} has no camera to draw a picture from")
    if starts_gpu():
        pixels = viewport_picture(scene, result, size, meters=meters)
    else:
        pixels = rendered_picture(scene, result, size, meters=meters)
    write_png(path, pixels)


def starts_gpu() -> bool:
    """True if off-screen drawing is possible: with a window, and from Blender 5.2 on without one if
    OpenGL or Vulkan is available."""
    if not bpy.app.background:
        return True
    # Blender asks for OpenGL 4.6 first. Mesa's software driver offers 4.5, and each refusal would
    # print EGL_BAD_MATCH.
    os.environ.setdefault("MESA_GL_VERSION_OVERRIDE", "4.6")
    if not compatibility.can_draw_off_screen() or (
        sys.platform == "linux" and not _has_surfaceless_egl()
    ):
        return False
    try:
        gpu.init()
    except (RuntimeError, SystemError):
        return False
    return True


@cache
def _has_surfaceless_egl() -> bool:
    """True if EGL works without a screen. Elsewhere Blender 5.2 crashes."""
    surfaceless = 0x31DD  # EGL_PLATFORM_SURFACELESS_MESA
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        egl.eglGetPlatformDisplay.restype = ctypes.c_void_p
        egl.eglGetPlatformDisplay.argtypes = [ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p]
        egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    except (OSError, AttributeError):
        return False
    display = egl.eglGetPlatformDisplay(surfaceless, None, None)
    return bool(display) and bool(egl.eglInitialize(display, None, None))


def viewport_picture(
    scene: Scene,
    result: FrameResult,
    size: tuple[int, int],
    options: Options | None = None,
    *,
    meters: bool = False,
) -> NDArray[np.uint8]:
    """Pixels (height, width, 3), top row first: the 3D viewport from the scene's camera with the
    graph over it."""
    drawing = overlay.GraphDrawing.of(
        overlay.GraphShapes.of(result, read_settings(scene), options or shown_options(scene))
    )
    width, height = (SMOOTHING * side for side in size)
    scale = SMOOTHING * picture_scale(size)
    view, projection = camera_view(scene, (width, height))
    off_screen = GPUOffScreen(width, height)
    try:
        with _plain_viewport(scene) as (space, region):
            off_screen.draw_view3d(
                scene,
                scene.view_layers[0],
                space,
                region,
                view,
                projection,
                do_color_management=True,
            )
        with off_screen.bind():
            overlay.draw_graph(
                drawing,
                projection,
                view,
                (width, height),
                scale,
                xray=scene.haptics.xray,
                flow=None,
            )
            hud = meters_above(scene, result, (width, height), scale) if meters else None
            perspective, free = (
                np.array(projection @ view, dtype=np.float64),
                (0.0, 0.0, float(width), float(height)),
            )
            overlay.draw_annotations(
                drawing, perspective, (width, height), scale, free, hud.bounds if hud else ()
            )
            if hud is not None:
                draw_hud(hud, (width, height), scale)
            buffer = gpu.state.active_framebuffer_get().read_color(
                0, 0, width, height, 4, 0, "UBYTE"
            )
    finally:
        off_screen.free()
        overlay.forget()
    buffer.dimensions = width * height * 4
    pixels = np.array(buffer, dtype=np.uint8).reshape(height, width, 4)[::-1, :, :3]
    return averaged(pixels)


def draw_hud(items: Hud, size: tuple[float, float], scale: float) -> None:
    """Draw plates, lines, symbols and texts once, without caching."""
    draw_flat(uploaded(items), size, scale)


@contextmanager
def _plain_viewport(scene: Scene) -> Iterator[tuple[Any, Any]]:
    """A 3D viewport and its region, set for a picture: solid shading with shadows and cavities,
    nothing of the user interface."""
    area = next(area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    space = area.spaces.active
    wanted: dict[Any, dict[str, Any]] = {
        space.shading: {
            "type": "SOLID",
            "light": "STUDIO",
            "studio_light": "paint.sl",
            "color_type": "MATERIAL",
            "background_type": "VIEWPORT",
            "background_color": (0.035, 0.036, 0.04),
            "show_shadows": True,
            "shadow_intensity": 0.5,
            "show_cavity": True,
            "cavity_type": "BOTH",
            "show_object_outline": True,
            "object_outline_color": (0.0, 0.0, 0.0),
            "show_xray": False,
        },
        space.overlay: {"show_overlays": False},
        space: {"show_gizmo": False},
    }
    system = bpy.context.preferences.system
    wanted[system] = {"viewport_aa": "OFF"}  # averaging down smooths as well, much faster
    before = {
        owner: {key: _value(getattr(owner, key)) for key in values}
        for owner, values in wanted.items()
    }
    try:
        _set(wanted)
        yield space, region
    finally:
        _set(before)


def _value(value: Any) -> Any:
    return value if isinstance(value, (bool, float, int, str)) else tuple(value)


def _set(values: dict[Any, dict[str, Any]]) -> None:
    for owner, items in values.items():
        for key, value in items.items():
            setattr(owner, key, value)
