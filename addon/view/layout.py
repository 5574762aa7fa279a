"""Layout over a viewport: the part that the user interface does not cover, and the corner of the
meters."""

from __future__ import annotations

from bpy.types import Context, Region
from bpy_extras.view3d_utils import location_3d_to_region_2d

from ..properties.preferences import preferences
from .hud import Rectangle, overlaps

_TEXT_HEIGHT = 56.0  # points of Blender's own text at the upper left
_GIZMO_WIDTH = 110.0  # points of the navigation gizmo and its buttons at the upper right
_GIZMO_HEIGHT = 270.0
_LEAST_BESIDE = 160.0  # points beside the camera's frame that an element needs
_AXES = {"TOOLS": 0, "UI": 0} | dict.fromkeys(
    ("HEADER", "TOOL_HEADER", "ASSET_SHELF", "ASSET_SHELF_HEADER"), 1
)
"""The axis along which a region over the viewport takes its room."""


def pixels_per_point(context: Context) -> float:
    """Scale of all drawing over viewports: that of the user interface, and the user's."""
    return float(context.preferences.system.ui_scale * preferences().overlay_size)


def _rectangle(context: Context, region: Region) -> Rectangle:
    """A region of the same area, in pixels of the viewport."""
    x, y = float(region.x - context.region.x), float(region.y - context.region.y)
    return x, y, x + region.width, y + region.height


def free_rectangle(context: Context) -> Rectangle:
    """The part of the viewport, in its pixels, that toolbar, sidebar and headers do not cover."""
    size = float(context.region.width), float(context.region.height)
    free = [0.0, 0.0, *size]
    for other in context.area.regions:
        axis, cover = _AXES.get(other.type), _rectangle(context, other)
        is_shown = other.width > 1 and other.height > 1
        if axis is not None and is_shown and overlaps(cover, (0.0, 0.0, *size)):
            start, end = cover[axis::2]
            if start + end < size[axis]:
                free[axis] = max(free[axis], end)
            else:
                free[axis + 2] = min(free[axis + 2], start)
    left, bottom, right, top = free
    return left, bottom, max(right, left), max(top, bottom)


def redo_panels(context: Context) -> tuple[Rectangle, ...]:
    """The panel Adjust Last Operation, in pixels of the viewport; () if it is hidden: it is then a
    pixel wide, or lies at 0, 0."""
    return tuple(
        _rectangle(context, other)
        for other in context.area.regions
        if other.type == "HUD" and other.width > 1 and (other.x or other.y)
    )


def navigation(context: Context) -> tuple[Rectangle, ...]:
    """The navigation gizmo and its buttons, in pixels of the viewport; () if they are hidden."""
    space = context.space_data
    if not (space.show_gizmo and space.show_gizmo_navigate):
        return ()
    _, _, right, top = free_rectangle(context)
    scale = context.preferences.system.ui_scale
    return ((right - _GIZMO_WIDTH * scale, top - _GIZMO_HEIGHT * scale, right, top),)


def is_main_view(context: Context) -> bool:
    """False in the three orthographic views of a quad view, which have neither meters nor
    legend."""
    space = context.space_data
    return not len(space.region_quadviews) or context.region_data == space.region_3d


def camera_frame(context: Context) -> Rectangle | None:
    """The camera's frame in pixels of a viewport that looks through it; None elsewhere."""
    view = context.region_data
    camera = context.space_data.camera if view.view_perspective == "CAMERA" else None
    if camera is None or camera.type != "CAMERA":
        return None
    turned = camera.matrix_world.normalized()
    places = [
        location_3d_to_region_2d(context.region, view, turned @ corner)
        for corner in camera.data.view_frame(scene=context.scene)
    ]
    if None in places:
        return None
    across, up = ([place[axis] for place in places] for axis in (0, 1))
    return min(across), min(up), max(across), max(up)


def corner_room(
    context: Context, corner: str, width: float, scale: float, margin: float
) -> Rectangle:
    """The room for an element in a corner of the viewport: what is not covered by the user
    interface, by Blender's own text, its navigation gizmo and the panel Adjust Last Operation, nor
    by the camera's frame: beside that, or else below or above.

    Args:
        context: Of the viewport.
        corner: "BOTTOM_LEFT", "BOTTOM_RIGHT", "TOP_LEFT" or "TOP_RIGHT".
        width: Of the element [pixels].
        scale: Pixels per point.
        margin: To the edges of the room [pixels].
    """
    is_left = corner.endswith("LEFT")
    space = context.space_data
    free = free_rectangle(context)
    left = free[0] + margin
    bottom = free[1] + margin
    right = free[2] - margin
    top = free[3] - margin
    if corner == "TOP_LEFT" and space.overlay.show_text:
        top -= _TEXT_HEIGHT * scale
    if corner == "TOP_RIGHT" and space.show_gizmo and space.show_gizmo_navigate:
        right -= _GIZMO_WIDTH * scale
    if is_left:
        right = min(right, left + width)
    else:
        left = max(left, right - width)
    for panel in redo_panels(context):
        if overlaps(panel, (left, bottom, right, top)):
            bottom = max(bottom, panel[3] + margin)
    frame = camera_frame(context)
    if frame is not None and overlaps(frame, (left, bottom, right, top)):
        beside = frame[0] - margin - left if is_left else right - frame[2] - margin
        if beside >= _LEAST_BESIDE * scale:
            left, right = (left, left + beside) if is_left else (right - beside, right)
        elif corner.startswith("BOTTOM"):
            top = min(top, frame[1] - margin)
        else:
            bottom = max(bottom, frame[3] + margin)
    return left, bottom, max(right, left), max(top, bottom)
