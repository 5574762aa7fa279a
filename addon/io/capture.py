"""Capture of a range of frames for export: the frames are stepped, traced and collected."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import closing
from dataclasses import InitVar, dataclass, replace

import bpy
import numpy as np

from ...core.contacts.authored import rows_of
from ...core.contacts.contact_set import ContactSet
from ...core.formats.export import Export
from ...core.formats.scene.recording import Recording, SceneRecorder
from ...core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ...core.formats.tracks.track_recorder import TrackRecorder
from ...core.render.frame_result import FrameResult
from ...core.scene.values import HapticScene
from ..blender.words import TranslatedError
from ..session import session, timeline
from .frame_scene import within, written_export, written_frame
from .written_objects import WrittenObjects


@dataclass
class Capture:
    """The frames ``start`` to ``end`` of ``scene``, traced one after the other, and the one after
    them, with which the last one's samples end.

    Args:
        scene: The scene to capture.
        start: First frame.
        end: Last frame.
        recorded: Whether the changes of the scene are captured, too, and not its first frame alone.
        felt: Whether the samples of the listeners are captured.
        names: Names of the objects, sources and listeners to capture; None for all. All are traced.
        read: Reads a frame of the range from a baked track instead of tracing it; only if the scene
            itself is not captured.
    """

    scene: bpy.types.Scene
    start: int
    end: int
    recorded: InitVar[bool]
    felt: InitVar[bool]
    names: Collection[str] | None = None
    read: Callable[[int], FrameResult | None] | None = None

    def __post_init__(self, recorded: bool, felt: bool) -> None:
        rate = self.scene.render.fps / self.scene.render.fps_base
        self._recorder = SceneRecorder(rate, self.scene.frame_start)
        self._recorded, self._objects = recorded, WrittenObjects()
        self._tracks = TrackRecorder() if felt else None
        self._first: Export | None = None

    @classmethod
    def of(cls, scene: bpy.types.Scene, result: FrameResult) -> Export:
        """The current frame alone, which was traced, without samples."""
        work = cls(scene, result.number, result.number, recorded=False, felt=False)
        work.add(result)
        return work.export("")

    @property
    def frames(self) -> int:
        """Number of frames of the range."""
        return self.end - self.start + 1

    def steps(self) -> Iterator[int]:
        """Trace the frames; each is yielded after its trace. At the end or on closing, the scene's
        frame is restored.

        Raises ValueError, with a message for the user, for a frame that cannot be traced, and for
        an empty range.
        """
        if self.frames < 1:
            raise TranslatedError("The frame range {} to {} is empty", self.start, self.end)
        with closing(self._results()) as results:
            for result in results:
                self.add(result)
                yield result.number

    def export(self, name: str) -> Export:
        """The captured data as an export called ``name``."""
        tracks = self._tracks.tracks() if self._tracks is not None else None
        if tracks is not None and not tracks.listeners:
            tracks = None
        if self._first is None:
            return Export(name, tracks=tracks)
        first = self._first.need_scene()
        scene = replace(
            self._recorder.scene(), settings=first.settings, extras=first.extras, rules=first.rules
        )
        recording = self._recorder.recording() if self._recorded else None
        return replace(self._first, name=name, scene=scene, tracks=tracks, recording=recording)

    def _results(self) -> Generator[FrameResult, None, None]:
        # Of a range from a bake one frame is traced: it says which scene was felt.
        end = self.end + 1 if self.read is None else self.start
        with closing(timeline.steps(self.scene, self.start, end, self._tracks is None)) as steps:
            for step in steps:
                if self.read is None:
                    yield step.result
                else:
                    self._record(step.result)
        if self.read is None:
            return
        for frame in range(self.start, self.end + 2):
            result = self.read(frame)
            assert result is not None  # the track contains the range
            # The samples of the first frame precede its time.
            yield replace(result, block=None) if frame == self.start else result

    def add(self, result: FrameResult) -> None:
        """Add the scene's current frame."""
        if self._tracks is not None:
            self._tracks.add(result if self.names is None else felt_within(result, self.names))
        if self._recorded or self._first is None:
            self._record(result)

    def _record(self, result: FrameResult) -> None:
        reading = session.of(self.scene).reading
        assert reading is not None  # the frame was traced
        objects = self._objects.of(reading)
        frame = written_frame(result, reading, self.scene, objects)
        frame = frame if self.names is None else within(frame, self.names)
        if self._first is None:
            self._first = (
                written_export("", self.scene, frame, self.names)
                if self._recorded
                else Export("", frame)
            )
        contacts = contacts_within(
            result.contacts, result.objects, {item.name for item in frame.objects}
        )
        self._recorder.add(
            result.number,
            frame.objects,
            frame.sources,
            frame.listeners,
            contacts,
            result.objects,
            result.shots,
        )


def felt_within(result: FrameResult, names: Collection[str]) -> FrameResult:
    """A frame with only the listeners of these names."""
    rows = [i for i, item in enumerate(result.listeners) if item.name in names]
    return replace(
        result,
        listeners=tuple(result.listeners[i] for i in rows),
        amplitudes=result.amplitudes[:, rows],
        block=None if result.block is None else result.block[rows],
    )


def contacts_within(
    contacts: ContactSet, objects: Collection[str], names: Collection[str]
) -> ContactSet:
    """The contacts between objects of these names; ``objects`` are the names by the numbers in
    ``contacts``."""
    inside = np.array([name in names for name in objects], dtype=np.bool_)
    if inside.all():
        return contacts
    return rows_of(contacts, np.asarray(inside[contacts.pairs].all(axis=1)))


def expected(scene: bpy.types.Scene, ranged: bool, collection: str = "") -> Export:
    """The export without samples, which suffices to determine the losses of a format."""
    inside = bpy.data.collections.get(collection)
    objects = scene.objects if inside is None else inside.all_objects
    listeners = tuple(
        ListenerTrack(obj.name_full, obj.haptics.listener.part)
        for obj in objects
        if obj.haptics.listener.enabled
    )
    tracks = (
        Tracks(listeners, 8000, np.zeros((len(listeners), 1))) if ranged and listeners else None
    )
    return Export(
        "scene",
        HapticScene(),
        tracks,
        Recording(1.0, 1, ()) if ranged else None,
    )
