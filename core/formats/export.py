"""The data of an export."""

from __future__ import annotations

import datetime
from dataclasses import dataclass, field, replace
from functools import cached_property

from ..forms import Form
from ..scene.device_mapping import DeviceMapping
from ..scene.library import LibraryMaterial
from ..scene.values import HapticScene
from .provenance import methods, provenance_of
from .scene.recording import Recording
from .tracks.clips import clips_of
from .tracks.listener_tracks import Tracks


@dataclass(frozen=True, eq=False)
class Export:
    """A scene with its recording and its rendered tracks.

    Files are named after ``name``; ``date`` is in ISO 8601. ``origin``: the provenance of
    tracks that come without their scene.
    """

    name: str
    scene: HapticScene | None = None
    tracks: Tracks | None = None
    recording: Recording | None = None
    devices: tuple[DeviceMapping, ...] = ()
    materials: tuple[LibraryMaterial, ...] = ()
    date: str = field(default_factory=lambda: datetime.date.today().isoformat())
    origin: Form | None = None

    @cached_property
    def provenance(self) -> Form:
        """What files say of their origin: `provenance_of` the scene."""
        return provenance_of(self.scene) if self.origin is None else self.origin

    def as_clips(self) -> tuple[Export, tuple[str, ...]]:
        """The export with its tracks as `Clips`, whose gain is part of the provenance then, and
        what was changed, one sentence each."""
        if self.tracks is None or not self.tracks.listeners:
            return self, ()
        clips = clips_of(self.tracks)
        origin = {**self.provenance, "gain_decibels": clips.gain}
        return replace(self, tracks=clips.tracks, origin=origin), clips.sentences()

    def methods(self) -> str:
        """A paragraph on how the tracks were made. Raises ValueError without a scene."""
        return methods(self.provenance, self.need_scene(), self.tracks)

    def need_tracks(self) -> Tracks:
        """The rendered tracks. Raises ValueError if there are none."""
        if self.tracks is None or not self.tracks.listeners:
            raise ValueError(
                "tracks: this format carries what listeners feel, and there is no listener"
            )
        return self.tracks

    def need_scene(self) -> HapticScene:
        """The scene. Raises ValueError if there is none."""
        if self.scene is None:
            raise ValueError("scene: this format carries the scene, and there is none")
        return self.scene
