"""What differs between Blender 4.2 and 5.2, by feature, in one place."""

from __future__ import annotations

from typing import Any

import bpy


def can_draw_off_screen() -> bool:
    """True where the GPU can be started without a window (Blender 5.2 on)."""
    import gpu

    return hasattr(gpu, "init")


def eevee_engine() -> str:
    """The identifier of EEVEE, which was BLENDER_EEVEE_NEXT for a while."""
    items = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items
    return "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in items else "BLENDER_EEVEE"


def is_animated(datablock: Any) -> bool:
    """True where an action, the NLA or drivers may change the datablock's properties."""
    data = datablock.animation_data
    return data is not None and (data.action is not None or len(data.drivers) > 0 or len(data.nla_tracks) > 0)
