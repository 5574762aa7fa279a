"""Baked packs: what listeners feel without a server, as samples that a player adds up.

A pack has the tracks of the sources that play through a range of frames, and, as it is felt, each
blow and each one-shot of the range. A player plays the tracks, and a blow of the table whenever two
objects hit each other. Its sum is that of the bake where listeners mix by adding up.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..render.frame_result import FrameResult
from ..render.levels import LEVEL_SECONDS, vibration_rms
from ..render.mixdown import listener_mixes, primed, source_voices
from ..render.renderer import ListenerMix, Renderer, sample_index
from ..render.voices import Voice
from ..scene.values import HapticScene, SourceKind, Vector

FORMAT, VERSION = "haptic-pack", "1.0"
LIMITS = (
    "Objects pass on what they passed on in the bake: new contacts and moved furniture, sources "
    "and listeners change nothing.",
    "Two objects that hit each other are felt by the blow of these objects, or else of their "
    "materials, that was baked nearest; without one, nothing is felt.",
    "What arrives is added up and clipped at s_max; limiters, ducking and other ways of mixing are "
    "not in it.",
)
"""What a pack cannot do, as it is said in the file."""
MOST_SAMPLES = 1 << 25
"""Samples of a pack, of 4 bytes each."""
_SILENT = 1e-6
"""Amplitude below which a listener does not feel a blow."""
_UNLIMITED = 1e30
_QUIET = 10 ** (-90 / 20)
"""RMS up to which levels are not compared."""
_TAIL = 0.05
"""Seconds that limiter and filters add to a signal, at most."""


@dataclass(slots=True)
class _RecordedEvent:
    """A blow or a one-shot while it is recorded.

    Attributes:
        about: its row in the pack.
        voice: in the last frame.
        renderer: of this event alone.
        first: number of the first sample in ``blocks``, that of the frame in which it begins.
        blocks: samples (l, n) by frame.
        is_over: whether it has ended.
    """

    about: Mapping[str, Any]
    voice: Voice
    renderer: Renderer
    first: int
    blocks: list[FloatArray] = field(default_factory=list)
    is_over: bool = False

    def follow(self, start: float, end: float, voice: Voice | None) -> None:
        """Render the frame from ``start`` to ``end`` [s]; ``voice``: None where it has ended."""
        if not self.is_over:
            self.blocks.append(
                self.renderer.render_frame(start, end, () if voice is None else (voice,))
            )
            self.voice = voice or self.voice
            self.is_over = voice is None


class PackRecorder:
    """Records traced frames that follow each other as a pack. Samples are floats at the rate of
    the frames."""

    def __init__(self) -> None:
        self._renderer: Renderer | None = None
        self._mixes: tuple[ListenerMix, ...] = ()
        self._first: FrameResult | None = None
        self._events: dict[str, _RecordedEvent] = {}
        self._tracks: list[FloatArray] = []
        self._felt: list[FloatArray] = []
        self._time = 0.0
        self._count = 0

    def add(self, result: FrameResult) -> None:
        """Add a frame. Raises ValueError if the pack would be too large."""
        if self._first is None:
            self._first, self._time = result, result.time
            self._mixes = tuple(
                replace(
                    mix,
                    s_max=_UNLIMITED,
                    method=mix.method if mix.method == "weighted" else "cumulative",
                )
                for mix in listener_mixes(result.listeners)
            )
            return
        if result.block is None:
            return
        start = self._time
        voices = source_voices(result)
        sounding = {voice.key: voice for voice in voices}
        self._time = result.time
        self._begin(result, start, sounding)
        if self._renderer is None:
            self._renderer = self._begun(start)
        lasting = [voice for voice in voices if voice.key not in self._events]
        self._tracks.append(self._renderer.render_frame(start, result.time, lasting))
        self._felt.append(result.block)
        for name, event in self._events.items():
            event.follow(start, result.time, sounding.get(name))
        going_on = sum(not event.is_over for event in self._events.values())
        self._count += result.block.size * (1 + going_on)
        if self._count > MOST_SAMPLES:
            raise ValueError("the baked pack would be larger than 128 MB: choose fewer frames")

    def _begun(self, start: float) -> Renderer:
        """The renderer of the tracks, in the state of the frame before the first one."""
        assert self._first is not None
        rate = self._first.sample_rate
        if self._first.before is None:
            return Renderer(self._mixes, rate)
        return primed(self._mixes, rate, start, source_voices(self._first))

    def _begin(self, result: FrameResult, start: float, voices: Mapping[Any, Voice]) -> None:
        """Begin the blows and one-shots of a frame that begins at ``start`` [s]."""
        blows = result.sources[len(result.sources) - len(result.impacts) :]
        about: dict[str, dict[str, Any]] = {
            source.name: {
                "objects": [source.object, source.second_object],
                "time": source.onset,
                "position": impact.positions[0],
                "energy": impact.energy,
            }
            for source, impact in zip(blows, result.impacts, strict=True)
        }
        temporary = {item.name for item in result.sources if item.kind is SourceKind.TEMPORARY}
        about |= {
            shot.name: {"source": shot.source, "time": shot.onset}
            for shot in result.shots
            if shot.name in temporary and shot.onset >= start
        }
        for name in about.keys() - self._events.keys():
            renderer = Renderer(self._mixes, result.sample_rate)
            self._events[name] = _RecordedEvent(
                about[name], voices[name], renderer, result.first_sample
            )

    def document(self, scene: HapticScene) -> dict[str, Any]:
        """The pack of the recorded frames of ``scene``, which has the materials and the rules of
        blows. Positions are right-handed with y up, as in glTF. Raises ValueError without a second
        frame."""
        if self._first is None or not self._tracks:
            raise ValueError("a baked pack needs at least two frames with a listener")
        rate, listeners = self._first.sample_rate, self._first.listeners
        begun = sample_index(self._first.time, rate)
        tracks = np.concatenate(self._tracks, axis=1)
        felt = np.concatenate(self._felt, axis=1)
        rows = {"blows": list[dict[str, Any]](), "one_shots": list[dict[str, Any]]()}
        total = tracks.copy()
        for event in self._events.values():
            samples = self._whole(event)
            at = sample_index(event.about["time"], rate)
            samples = samples[:, max(at - event.first, 0) :]
            heard = total[:, max(at - begun, 0) :][:, : samples.shape[1]]
            heard += samples[:, : heard.shape[1]]
            form = {**event.about, "time": event.about["time"] - begun / rate}
            form["felt"] = {
                item.name: _base64(row)
                for item, row in zip(listeners, samples, strict=True)
                if np.abs(row).max(initial=0.0) > _SILENT
            }
            rows["one_shots" if "source" in form else "blows"].append(form)
        s_max = np.array([item.s_max for item in listeners])[:, None]
        materials = {item.name: item.material for item in scene.objects}
        return {
            "format": FORMAT,
            "version": VERSION,
            "limits": LIMITS,
            "difference": _difference(np.clip(total, -s_max, s_max), felt, rate),
            "sample_rate": rate,
            "axes": "right-handed, y up",
            "materials": materials,
            "listeners": [
                {"name": item.name, "body_part": item.body_part, "s_max": item.s_max}
                for item in listeners
            ],
            "samples": tracks.shape[1],
            "tracks": {
                item.name: _base64(row) for item, row in zip(listeners, tracks, strict=True)
            },
            "blows": [_blow(form, scene, materials) for form in rows["blows"]],
            "one_shots": rows["one_shots"],
        }

    def _whole(self, event: _RecordedEvent) -> FloatArray:
        """The samples (l, n) of an event. Its part after the last frame has that frame's gains."""
        voice = event.voice
        reached = voice.gains.reshape(len(voice.gains), -1).any(axis=1)
        late = 0.0 if voice.delays is None else voice.delays[reached].max(initial=0.0)
        last = voice.onset + voice.signal.duration + float(late) + _TAIL
        if not event.is_over and last > self._time:
            event.follow(self._time, last, voice)
        return np.concatenate(event.blocks, axis=1)


def _blow(form: dict[str, Any], scene: HapticScene, materials: Mapping[str, str]) -> dict[str, Any]:
    """A row of the table of blows."""
    first, second = form["objects"]
    x, y, z = form["position"]
    limits = scene.rules.impact_limits((first, materials[first]), (second, materials[second]))
    return {**form, "position": _turned((x, y, z)), "full_energy": limits.full_energy}


def _turned(position: Vector) -> list[float]:
    x, y, z = position
    return [x, z, -y]


def _base64(row: FloatArray) -> str:
    """Samples as float32, little-endian, without the silence at their end."""
    loud = np.flatnonzero(np.abs(row) > _SILENT / 100)
    return base64.b64encode(
        row[: loud[-1] + 1 if len(loud) else 0].astype("<f4").tobytes()
    ).decode()


def _difference(sums: FloatArray, felt: FloatArray, sample_rate: float) -> float:
    """The largest difference between the levels of two signals (l, n) in any quarter of a second
    [dB]."""
    window = round(LEVEL_SECONDS * sample_rate)
    largest = 0.0
    for begin in range(0, max(felt.shape[1] - window, 0) + 1, window):
        of_sum, of_felt = (
            np.maximum(vibration_rms(rows[:, begin : begin + window], sample_rate), _QUIET)
            for rows in (sums, felt)
        )
        largest = max(largest, float(np.abs(20 * np.log10(of_sum / of_felt)).max(initial=0.0)))
    return largest
