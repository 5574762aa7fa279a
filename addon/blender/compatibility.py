"""Differences between Blender 4.2 and 5.2, by feature."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from itertools import chain
from typing import Any

import bpy

THREADS_ENDANGER_SCRIPTS = sys.version_info < (3, 12)
"""Whether a script's operators can crash Blender while another thread runs Python (up to Blender
5.0).

An operator that a script calls runs without the GIL, but looks up the members of an overridden
context in a Python dictionary. It asks for the GIL only if no thread has it: up to Python 3.11
Blender can't tell its own thread from others.
"""


def can_draw_off_screen() -> bool:
    """True if the GPU can be initialised without a window (Blender 5.2 on)."""
    import gpu

    return hasattr(gpu, "init")


def eevee_engine() -> str:
    """The identifier of EEVEE, which was BLENDER_EEVEE_NEXT in some versions."""
    items = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items
    return "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in items else "BLENDER_EEVEE"


_TRANSFORMS = ("location", "rotation_", "scale", "delta_", "hide_")
"""Prefixes of data paths of transforms, whose animation is visible in the matrix."""


def animated_paths(datablock: Any) -> tuple[str, ...] | None:
    """The data paths, other than of its transform and visibility, that an action or drivers may
    animate; None if the NLA may animate any."""
    data = datablock.animation_data
    if data is None:
        return ()
    if len(data.nla_tracks) > 0:
        return None
    paths = {curve.data_path for curve in (*fcurves_of(datablock), *data.drivers)}
    return tuple(sorted(path for path in paths if not path.startswith(_TRANSFORMS)))


def is_animated(datablock: Any, paths: Collection[str]) -> bool:
    """Whether an action, drivers or strips of the NLA may animate one of the data paths."""
    curves = chain(fcurves_of(datablock), driving_curves(datablock))
    return any(curve.data_path in paths for curve in curves)


def driving_curves(datablock: Any) -> list[Any]:
    """The F-curves that animate the datablock through drivers and strips of the NLA."""
    data = datablock.animation_data
    if data is None:
        return []
    strips = chain.from_iterable(nla_strips(track) for track in data.nla_tracks)
    of_strips = (fcurves_in(strip.action) for strip in strips if strip.action)
    return [*data.drivers, *chain.from_iterable(of_strips)]


def nla_strips(owner: Any) -> Iterator[Any]:
    """The strips of a track of the NLA, each followed by those inside it, as meta strips have."""
    for strip in owner.strips:
        yield strip
        yield from nla_strips(strip)


def fcurves_of(datablock: Any) -> list[Any]:
    """The F-curves that animate the datablock through its action."""
    return [curve for owner in _fcurve_owners(datablock) for curve in owner.fcurves]


def fcurves_in(action: Any) -> list[Any]:
    """All F-curves of an action, whatever they animate."""
    return [curve for owner in _owners_in(action) for curve in owner.fcurves]


def _fcurve_owners(datablock: Any) -> list[Any]:
    """The owners of a datablock's F-curves: its action, or the channelbags of its slot where
    actions have slots (Blender 4.4 on)."""
    data = datablock.animation_data
    if data is None or data.action is None:
        return []
    owners = _owners_in(data.action)
    if not hasattr(data.action, "layers"):
        return owners
    slot = data.action_slot
    return [bag for bag in owners if slot is not None and bag.slot_handle == slot.handle]


def _owners_in(action: Any) -> list[Any]:
    """The owners of all F-curves of an action: itself, or the channelbags of its slots."""
    if not hasattr(action, "layers"):
        return [action]
    return [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]


def ensure_fcurve(datablock: Any, data_path: str, index: int = 0) -> Any:
    """The F-curve of a property in the datablock's action; both are created if missing."""
    data = datablock.animation_data or datablock.animation_data_create()
    if data.action is None:
        data.action = bpy.data.actions.new(f"{datablock.name}Action")
    ensure = data.action.bl_rna.functions.get("fcurve_ensure_for_datablock")
    if ensure is not None:
        return data.action.fcurve_ensure_for_datablock(datablock, data_path, index=index)
    return data.action.fcurves.find(data_path, index=index) or data.action.fcurves.new(
        data_path, index=index
    )


STRIPS = "strips" if "strips" in bpy.types.SequenceEditor.bl_rna.properties else "sequences"


def strips_of(editor: Any) -> Any:
    """All strips of the sequencer; called sequences before Blender 5."""
    return getattr(editor, STRIPS)


def strip_ends(strip: Any) -> tuple[float, float]:
    """The frames at which a strip begins and ends."""
    if hasattr(strip, "left_handle"):
        return strip.left_handle, strip.right_handle
    return strip.frame_final_start, strip.frame_final_end


def strip_content_start(strip: Any) -> float:
    """The frame at which the content of a strip begins, which may be before the strip does."""
    return float(strip.content_start if hasattr(strip, "content_start") else strip.frame_start)
