"""Shapes and texts in the pixels of a viewport, on the GPU."""

from __future__ import annotations

from functools import cache
from typing import Any

import gpu

from . import shader
from .text_atlas import TextAtlas, pixels_to_clip


def draw_flat(batch: Any, size: tuple[float, float], scale: float) -> None:
    """One draw call in pixels of a viewport of ``size``; ``batch`` may be None."""
    if batch is None:
        return
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_test_set("NONE")
    shader.draw(batch, pixels_to_clip(size), size, pixels_per_point=scale, texts=shared_atlas().texture)
    gpu.state.blend_set("NONE")


@cache
def shared_atlas() -> TextAtlas:
    """The texture of all texts that are drawn over viewports."""
    return TextAtlas()


def free_texts() -> None:
    """Free the texture of texts."""
    if shared_atlas.cache_info().currsize:
        shared_atlas().free()
