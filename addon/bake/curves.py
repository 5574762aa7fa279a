"""Intensity and frequency of a track as F-curves on the listeners."""

from __future__ import annotations

import numpy as np
from bpy.types import Object, Scene
from numpy.typing import NDArray

from ...core.formats.tracks.envelopes import vibration_envelope
from ...core.formats.tracks.listener_tracks import Row
from ..blender import compatibility
from ..blender.arrays import write_keys
from ..blender.full_names import object_named
from ..blender.time import stretching
from .track import HapticTrack

INTENSITY, FREQUENCY = "haptics.felt.intensity", "haptics.felt.frequency"
_GROUP = "Haptics"


def write_curves(scene: Scene, track: HapticTrack, index: int) -> bool:
    """Write the F-curves of listener number ``index``; the key of a frame covers the samples up to
    that frame. Returns False if the listener is missing or linked from a library."""
    obj = _object(scene, track.listeners[index].name)
    if obj is None or not obj.is_editable:
        return False
    frames = np.arange(track.frame_start, track.frame_end + 1, dtype=np.float32)
    for path, values in zip((INTENSITY, FREQUENCY), felt(track, index), strict=True):
        compatibility.remove_fcurves(obj, {path})
        curve = compatibility.ensure_fcurve(obj, path, _GROUP)
        write_keys(curve, frames / stretching(scene), values)
    return True


def remove_curves(scene: Scene) -> None:
    """Remove the F-curves of a bake."""
    for obj in scene.objects:
        if obj.is_editable and obj.animation_data is not None:
            compatibility.remove_fcurves(obj, {INTENSITY, FREQUENCY})


def felt(track: HapticTrack, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Intensity and frequency (hertz) of a listener at every frame; in silence the frequency keeps
    its last value."""
    count = track.frame_count
    intensity = np.zeros(count)
    frequency = np.zeros(count)
    if count > 1 and track.samples.shape[1]:
        found = vibration_envelope(
            Row(track.listener_samples(index), track.sample_rate), track.frame_duration
        )
        filled = min(len(found[0]), count - 1)
        intensity[1 : 1 + filled] = found[0][:filled]
        frequency[1 : 1 + filled] = found[1][:filled]
    felt = intensity > 1e-5
    last = np.maximum.accumulate(np.where(felt, np.arange(count), -1))
    frequency = np.where(last >= 0, frequency[np.maximum(last, 0)], 0.0)
    return intensity.astype(np.float32), frequency.astype(np.float32)


def _object(scene: Scene, full_name: str) -> Object | None:
    obj = object_named(full_name)
    return obj if obj is not None and obj.name in scene.objects else None
