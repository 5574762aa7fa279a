"""What an export will hold, before it is made."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.types import Scene

from ...core.formats.export import Export
from ...core.formats.scene.recording import Recording
from ...core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ...core.modalities.modality_scene import ModalityScene
from ...core.scene.values import HapticScene
from ..properties.modalities import SHOWN


def expected(scene: Scene, ranged: bool, collection: str = "") -> Export:
    """What would be exported, without a sample: enough to say what a format can't carry."""
    inside = bpy.data.collections.get(collection)
    objects = scene.objects if inside is None else inside.all_objects
    tagged = [obj for obj in objects if obj.haptics.listener.enabled]
    parts = [(obj.name_full, obj.haptics.listener.body_part) for obj in tagged]
    listeners = tuple(ListenerTrack(name, "" if part == "NONE" else part) for name, part in parts)
    tracks = Tracks(listeners, 8000, np.zeros((len(listeners), 1))) if ranged and listeners else None
    modalities = tuple(ModalityScene(item) for item in SHOWN if getattr(scene.haptics.modalities, item.name).enabled)
    return Export("scene", HapticScene(), tracks, Recording(1.0, 1, ()) if ranged else None, modalities=modalities)
