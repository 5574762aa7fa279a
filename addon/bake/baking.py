"""One bake in small steps, so that Blender stays responsive: frame after frame, then the track, F-curves and sound strip."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import closing

from bpy.types import Scene

from ..changes.suspension import suspended
from ..scene_reader.digest import digest_of
from ..session import timeline
from . import curves, sound, storage
from .playback import play, wanted_range
from .track import TrackRecorder, check_size

_TRACING, _WRITING = 0.9, 0.98  # parts of the progress bar


class Baking:
    """One bake. ``part``: progress, 0 to 1; ``words``: the current step; ``warnings``: what could not be done."""

    def __init__(self, scene: Scene) -> None:
        """Raises ValueError, with a message for the user, where there is nothing to bake, or too much."""
        first, last = wanted_range(scene)
        if last < first:
            raise ValueError(f"The frame range {first} to {last} is empty")
        self.part = 0.0
        self.words = "Baking haptics"
        self.frame_count = last - first + 1
        self.warnings: list[str] = []
        self._work = self._pieces(scene, first, last)

    def advance(self, seconds: float) -> bool:
        """Work for about this many seconds. Returns True when everything is done. Raises ValueError where a frame can't be traced."""
        end = time.perf_counter() + seconds
        return all(time.perf_counter() < end for _ in self._work)

    def finish(self) -> None:
        """Do all remaining work."""
        for _ in self._work:
            pass

    def close(self) -> None:
        """Stop and restore the scene's frame. Until the last frame is traced the scene is unchanged."""
        self._work.close()

    def _pieces(self, scene: Scene, first: int, last: int) -> Generator[None, None, None]:
        recorder = TrackRecorder()
        digest = digest_of(scene)
        frame_duration = scene.render.fps_base / scene.render.fps
        with closing(timeline.results(scene, first, last)) as results:
            for number, result in enumerate(results, 1):
                if number == 1:
                    if not result.listeners:
                        raise ValueError("There is no listener: add one to feel something")
                    check_size(len(result.listeners), self.frame_count, frame_duration, result.sample_rate)
                recorder.add(result)
                self.part = _TRACING * number / self.frame_count
                self.words = f"Baking haptics: frame {result.number}, {number} of {self.frame_count}"
                yield
        self.words = "Baking haptics: keeping the track"
        yield
        track = recorder.track(digest, frame_duration)
        del recorder
        storage.keep(scene, track)
        bake = scene.haptics.bake
        if bake.write_curves:
            self.words = "Baking haptics: writing F-curves"
            left_out = []
            for index, listener in enumerate(track.listeners):
                yield
                with suspended():
                    if not curves.write_curves(scene, track, index):
                        left_out.append(listener.name)
                self.part = _TRACING + (_WRITING - _TRACING) * (index + 1) / len(track.listeners)
            if left_out:
                names = ", ".join(left_out[:3]) + (", ..." if len(left_out) > 3 else "")
                self.warnings.append(f"no F-curves on what can't be edited: {names}")
        if bake.write_sound:
            self.words = "Baking haptics: adding the sound strip"
            yield
            try:
                with suspended():
                    sound.add_strip(scene, track)
            except (OSError, ValueError) as error:
                self.warnings.append(f"no sound strip: {error}")
        self.part = 1.0
        play(scene)
