"""Plays the ride in Blender once and renders it in all four modes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
from bpy.types import Scene

from ..addon.changes.suspension import suspended
from ..addon.session import session, timeline
from ..addon.view.render_data import Options
from ..core.arrays import FloatArray
from ..core.formats.tracks.track_recorder import TrackRecorder
from ..core.perception import sensation_level
from ..core.propagation import propagate
from ..core.render.arrival import arriving
from ..core.render.frame_result import FrameResult, Sounding
from ..core.render.mixdown import Mixdown
from ..core.scene.values import Mode, Settings, Source
from ..pictures.picture import viewport_picture
from ..pictures.png import write_png
from ..sample_scenes.mine_ride import SECTIONS
from .measures import WINDOW, felt_shares, loudness
from .rendition import MODES, ActiveSource, Rendition, Ride
from .sensitivity import Variation, VariedGraph, VariedSources

RUN_UP = 8
"""Frames traced before one that is drawn."""


class ModeRendering:
    """Renders the consecutive frames of a tracer in another mode, as the tracer itself would in
    that mode.

    Contacts, impacts and sources are the same in all modes, so they are found only once.
    """

    def __init__(self, mode: Mode) -> None:
        self.mode = mode
        self._mixdown = Mixdown()
        self._time: float | None = None

    def of(self, result: FrameResult, settings: Settings) -> FrameResult:
        """The frame in this mode, with the other ``settings`` unchanged. A reset of the tracer also
        resets this rendering."""
        if result.block is None:
            self._mixdown.reset()
            self._time = None
        propagation = propagate(result.graph, replace(settings, mode=self.mode), sounding_only=True)
        end = Sounding(result.time, result.sources, result.listeners, propagation)
        block = self._mixdown.render(self._time, end)
        self._time = result.time
        return replace(
            result,
            propagation=propagation,
            amplitudes=arriving(result.sources, propagation),
            block=block,
            warnings=propagation.warnings,
        )


class _Varied:
    """The ride under a variation: in HT, and in the other modes as well where sources vary."""

    def __init__(self, variation: Variation) -> None:
        self.variation = variation
        self._graphs = VariedGraph(variation)
        self._sources = VariedSources(variation)
        modes = MODES if variation.sources_vary else MODES[:1]
        self._renderings = {mode: ModeRendering(mode) for mode in modes}
        self._levels = {mode: _FrameLevels() for mode in modes}
        self._soundings: list[ActiveSource] = []

    def add(self, results: dict[Mode, FrameResult], settings: Settings) -> None:
        """Add a frame, given its results in all modes."""
        traced = self._sources.of(results[Mode.HT])
        traced = replace(traced, graph=self._graphs.of(traced.graph))
        settings = self.variation.settings(settings)
        varied = {
            mode: rendering.of(traced, settings) for mode, rendering in self._renderings.items()
        }
        for mode, result in varied.items():
            self._levels[mode].add(result)
        self._soundings += _soundings({**results, **varied})

    def ride(self, own: Ride) -> Ride:
        """``own`` with the levels and amplitudes of this rendering; its tracks stay those of the
        ride itself."""
        renditions = dict(own.renditions)
        for mode, levels in self._levels.items():
            rms, peak, margin = levels.arrays()
            renditions[mode] = replace(renditions[mode], rms=rms, peak=peak, margin=margin)
        return replace(own, renditions=renditions, soundings=tuple(self._soundings))


def bake_ride(
    scene: Scene,
    first: int,
    last: int,
    progress: Callable[[int], None] = lambda frame: None,
    variations: Sequence[Variation] = (),
) -> tuple[Ride, tuple[tuple[Variation, Ride], ...]]:
    """Trace frames of the mine ride and render each in `MODES`, and under each variation. Raises
    ValueError if a frame cannot be traced.

    Args:
        scene: the ride.
        first: first frame.
        last: last frame.
        progress: is called with the number of every frame.
        variations: of the ride.

    Returns:
        The ride, and the ride under each variation.
    """
    scene.haptics.mode = "HT"
    if scene.rigidbody_world is not None:
        scene.rigidbody_world.enabled = False  # all motion is keyframed
    renderings = {mode: ModeRendering(mode) for mode in MODES[1:]}
    recorders = {mode: _ModeRecorder() for mode in MODES}
    varied = [_Varied(variation) for variation in variations]
    soundings: list[ActiveSource] = []
    frames: list[int] = []
    positions = np.zeros((0, 3))
    listeners: tuple[str, ...] = ()
    with closing(timeline.steps(scene, first, last)) as steps:
        for step in steps:
            traced = step.result
            reading = session.of(scene).reading
            assert reading is not None
            results = {Mode.HT: traced} | {
                mode: rendering.of(traced, reading.settings)
                for mode, rendering in renderings.items()
            }
            for mode, result in results.items():
                recorders[mode].add(result)
            soundings += _soundings(results)
            for one in varied:
                one.add(results, reading.settings)
            if not frames:
                listeners = tuple(item.body_part or item.name for item in traced.listeners)
                positions = np.array(
                    [item.position for item in traced.listeners], dtype=np.float64
                ).reshape(-1, 3)
            frames.append(traced.number)
            progress(traced.number)
    ride = Ride(
        frames=np.array(frames, dtype=np.int64),
        frame_rate=scene.render.fps / scene.render.fps_base,
        listeners=listeners,
        positions=positions,
        renditions={mode: recorder.rendition(mode) for mode, recorder in recorders.items()},
        soundings=tuple(soundings),
        sections=tuple(
            (section.name, section.title, max(section.first, first), min(section.last, last))
            for section in SECTIONS
            if section.first <= last and section.last >= first
        ),
        largest_difference={
            mode: recorder.levels.largest_difference for mode, recorder in recorders.items()
        },
    )
    return ride, tuple((one.variation, one.ride(ride)) for one in varied)


def frames_to_draw(ride: Ride, count: int) -> list[int]:
    """At most ``count`` frames of every section: that with the highest levels in each of as many
    equal parts, silent parts left out."""
    felt = ride.renditions[Mode.HT].peak.sum(axis=1)
    chosen = []
    for _, _, first, last in ride.sections:
        rows = ride.rows(first, last)
        parts = np.array_split(np.arange(rows.start, rows.stop), count)
        chosen += [
            int(ride.frames[part[felt[part].argmax()]]) for part in parts if felt[part].any()
        ]
    return chosen


def draw_frames(
    scene: Scene, frames: Sequence[int], size: tuple[int, int] = (480, 300)
) -> dict[int, bytes]:
    """PNG by frame: the ride as its camera sees it, with the best paths over it. Needs a GPU
    (`picture.starts_gpu`)."""
    pictures = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        for frame in frames:
            # Impacts of earlier frames are still active.
            for step in timeline.steps(scene, max(frame - RUN_UP, scene.frame_start), frame):
                if step.result.number == frame:
                    with suspended():
                        write_png(
                            path,
                            viewport_picture(
                                scene,
                                step.result,
                                size,
                                Options(show_intra=False, labelled=""),
                            ),
                        )
            pictures[frame] = path.read_bytes()
    return pictures


class _FrameLevels:
    """Collects the levels of frames. ``largest_difference``: between two listeners' samples at any
    time."""

    def __init__(self) -> None:
        self._rms: list[FloatArray] = []
        self._peak: list[FloatArray] = []
        self._margin: list[FloatArray] = []
        self._recent: FloatArray | None = None
        self.largest_difference = 0.0

    def add(self, result: FrameResult) -> None:
        block = result.block if result.block is not None else np.zeros((len(result.listeners), 0))
        if self._recent is None or result.block is None:
            self._recent = block
        width = round(WINDOW * result.sample_rate)
        self._recent = np.concatenate([self._recent, block], axis=1)[:, -width:]
        self._margin.append(sensation_level(self._recent, result.sample_rate))
        if block.shape[1]:
            self._rms.append(np.sqrt((block**2).mean(axis=1)))
            self._peak.append(np.abs(block).max(axis=1))
            self.largest_difference = max(
                self.largest_difference, float(np.ptp(block, axis=0).max())
            )
        else:
            self._rms.append(np.zeros(len(block)))
            self._peak.append(np.zeros(len(block)))

    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """RMS, peak and margin (f, l)."""
        return np.array(self._rms), np.array(self._peak), np.array(self._margin)


class _ModeRecorder:
    """Collects the levels and samples of one mode."""

    def __init__(self) -> None:
        self._tracks = TrackRecorder()
        self.levels = _FrameLevels()

    def add(self, result: FrameResult) -> None:
        self._tracks.add(result)
        self.levels.add(result)

    def rendition(self, mode: Mode) -> Rendition:
        return Rendition(mode, *self.levels.arrays(), self._tracks.tracks())


def _soundings(results: dict[Mode, FrameResult]) -> list[ActiveSource]:
    traced = results[Mode.HT]
    places = np.array([item.position for item in traced.listeners], dtype=np.float64).reshape(-1, 3)
    new = len(traced.sources) - len(traced.impacts)
    found = []
    for row, source in enumerate(traced.sources):
        if source.amplitude <= 0:
            continue
        began = row >= new
        margin, hertz = loudness(source.emitted)
        found.append(
            ActiveSource(
                frame=traced.number,
                name=source.name,
                objects=(source.object,)
                if source.second_object is None
                else (source.object, source.second_object),
                began=began,
                amplitude=source.amplitude,
                distance=np.min(
                    [np.linalg.norm(places - side, axis=1) for side in _sides(source)], axis=0
                ),
                amplitudes=np.array([_felt_amplitudes(results[mode], row) for mode in MODES]),
                paths=tuple(traced.path_objects(row, k) for k in range(len(traced.listeners)))
                if began
                else (),
                loudness=margin,
                hertz=hertz,
            )
        )
    return found


def _felt_amplitudes(result: FrameResult, row: int) -> FloatArray:
    """The amplitudes (l,) with which a source arrives; those of frequency bands weighted by the
    felt share of its signal in each."""
    bands = result.propagation.band_gain
    if bands is None:
        return np.asarray(result.amplitudes[row])
    source = result.sources[row]
    assert source.signal is not None
    return np.asarray(source.amplitude * np.sqrt(bands[row] ** 2 @ felt_shares(source.signal)))


def _sides(source: Source) -> tuple[FloatArray, ...]:
    """Positions of a source: on its object, or on both objects of an impact."""
    return tuple(
        np.array(place) for place in (source.position, source.second_position) if place is not None
    )
