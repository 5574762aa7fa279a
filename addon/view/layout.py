"""What the user interface leaves free of a viewport."""

from __future__ import annotations

from bpy.types import Context

from .annotations import Rectangle


def free_rectangle(context: Context) -> Rectangle:
    """What toolbar, sidebar and headers leave free of the viewport, in its pixels: they may lie over it."""
    region = context.region
    left, bottom, right, top = 0.0, 0.0, float(region.width), float(region.height)
    for other in context.area.regions:
        if other == region or other.width <= 1 or other.height <= 1:
            continue
        x, y = other.x - region.x, other.y - region.y
        if x >= region.width or y >= region.height or x + other.width <= 0 or y + other.height <= 0:
            continue  # beside the viewport, not over it
        if other.type in {"TOOLS", "UI"}:
            if 2 * x + other.width < region.width:
                left = max(left, float(x + other.width))
            else:
                right = min(right, float(x))
        elif other.type in {"HEADER", "TOOL_HEADER", "ASSET_SHELF", "ASSET_SHELF_HEADER"}:
            if 2 * y + other.height < region.height:
                bottom = max(bottom, float(y + other.height))
            else:
                top = min(top, float(y))
    return left, bottom, max(right, left), max(top, bottom)
