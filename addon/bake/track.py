"""The haptic track: the signals of all listeners over a range of frames, as plain values that can
be stored in a file.

Independent of Blender. The bytes are `MAGIC`, the version, the length of the header, the header as
JSON, then the arrays in order, each compressed by zlib. Everything read from a file is validated.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.contact_set import ContactSet
from ...core.diagnosis.connections import connections
from ...core.formats.io.strict_json import parse_json
from ...core.forms import Form
from ...core.graph.haptic_graph import ObjectTable, build_graph
from ...core.propagation import Propagation
from ...core.render.frame_result import FrameResult
from ...core.render.integers import FULL_SCALE, as_integers
from ...core.scene.values import HapticObject, Listener, Mode, Source, SourceKind

MAGIC = b"HAPTRACK"
VERSION = 1
MAX_BYTES = 1 << 28
"""Largest size of the samples: 256 MB are 4.6 hours of one listener, 28 minutes of ten."""
MAX_IMPACTS = 1 << 24
"""Most characters of the impacts of all frames."""
MAX_LINES = 1 << 21
"""Most connections of the paths of all frames, 84 MB before they are packed."""
MAX_FRAMES = 1_000_000
MAX_LISTENERS = 1_000
MAX_SOURCES = 100_000
MAX_HEADER = 1 << 26


class TrackError(ValueError):
    """Error for bytes that are not a haptic track, or one of a later version."""


def track_source(name: str, obj: str, second: str | None = None, onset: float = 0.0) -> Source:
    """A source of a track; ``second`` is the other object of an impact."""
    is_struck = second is not None or onset
    kind = SourceKind.TEMPORARY if is_struck else SourceKind.PERSISTENT
    return Source(name, obj, kind=kind, second_object=second, onset=onset)


def track_listener(name: str, part: str, radius: float, s_max: float) -> Listener:
    """A listener of a track."""
    return Listener(name, name, body_part=part, radius=radius, s_max=s_max)


_ARRAYS = (
    ("samples", "<i2", "l, n"),
    ("offsets", "<i8", "f + 1"),
    ("places", "<f4", "f, l, 3"),
    ("rows", "<i8", "f + 1"),
    ("row_source", "<i4", "r"),
    ("row_amplitude", "<f4", "r"),
    ("row_place", "<f4", "r, 3"),
    ("row_gain", "<f4", "r, l"),
    ("lines", "<f4", "p, 10"),
    ("line_rows", "<i8", "f + 1"),
)
"""Name, type and axes of each array, see `HapticTrack`."""


@dataclass(frozen=True, eq=False)
class HapticTrack:
    """What the listeners of a scene feel in a range of frames, and what made it: f consecutive
    frames, the last of which comes after the range and ends its samples.

    Attributes:
        frame_start: number of the first frame.
        frame_duration: of each frame [s].
        start: time of the first frame [s].
        sample_rate: samples per second.
        listeners: the l listeners, without their positions.
        sources: all sources that reach a listener in any frame, without positions and amplitudes.
        samples: (l, n) int16 of the listeners.
        first_sample: number of the first sample, counted from the start of the scene.
        offsets: (f + 1,) frame k has the samples ``offsets[k] : offsets[k + 1]``.
        places: (f, l, 3) positions of the listeners [m].
        rows: (f + 1,) the sources that sound in frame k are in ``rows[k] : rows[k + 1]`` of the
            following arrays.
        row_source: (r,) number of the source.
        row_amplitude: (r,) its amplitude.
        row_place: (r, 3) its position [m].
        row_gain: (r, l) amplitude with which it arrives at each listener.
        lines: (p, 10) connections of best paths, see `Connections.rows`.
        line_rows: (f + 1,) those of frame k are ``line_rows[k] : line_rows[k + 1]``.
        digest: checksums of the baked scene, see `scene_reader.digest`.
        impacts: by frame that has any, see `scene_reader.kept_impacts`.
    """

    frame_start: int
    frame_duration: float
    start: float
    sample_rate: int
    first_sample: int
    listeners: tuple[Listener, ...]
    sources: tuple[Source, ...]
    samples: NDArray[np.int16]
    offsets: IntArray
    places: NDArray[np.float32]
    rows: IntArray
    row_source: NDArray[np.int32]
    row_amplitude: NDArray[np.float32]
    row_place: NDArray[np.float32]
    row_gain: NDArray[np.float32]
    lines: NDArray[np.float32]
    line_rows: IntArray
    digest: Form
    impacts: Mapping[int, str]

    @property
    def frame_count(self) -> int:
        """Number of traced frames."""
        return len(self.offsets) - 1

    @property
    def frame_end(self) -> int:
        """The last frame of the range."""
        return self.frame_start + self.frame_count - 2

    @property
    def mode(self) -> str:
        """The mode of the study that was baked, "" if it is unknown."""
        settings = self.digest.get("settings")
        mode = settings.get("mode") if isinstance(settings, dict) else ""
        return mode if isinstance(mode, str) else ""

    @property
    def duration(self) -> float:
        """Seconds of samples."""
        return self.samples.shape[1] / self.sample_rate

    def samples_until(self, frame: int, seconds: float) -> FloatArray:
        """The last ``seconds`` of all listeners up to the end of a frame, (l, n)."""
        last = int(self.offsets[frame - self.frame_start + 1])
        return (
            self.samples[:, max(last - round(seconds * self.sample_rate), 0) : last].astype(
                np.float64
            )
            / FULL_SCALE
        )

    def paths(self, frame: int) -> FloatArray | None:
        """The connections (m, 10) of a frame, None if none are kept."""
        k = frame - self.frame_start
        if not len(self.lines):
            return None
        return self.lines[slice(*self.line_rows[k : k + 2])].astype(np.float64)

    def result(self, frame: int) -> FrameResult | None:
        """The result of a frame, without contacts and paths; None for one that was not traced."""
        k = frame - self.frame_start
        if not 0 <= k < self.frame_count:
            return None
        first, last = self.offsets[k : k + 2].tolist()
        rows = slice(*self.rows[k : k + 2].tolist())
        sources = tuple(
            replace(
                self.sources[number],
                position=tuple(place),
                second_position=None,
                amplitude=min(max(amplitude, 0.0), 1.0),
            )
            for number, amplitude, place in zip(
                self.row_source[rows].tolist(),
                self.row_amplitude[rows].tolist(),
                self.row_place[rows].tolist(),
                strict=True,
            )
        )
        listeners = tuple(
            item.moved(place)
            for item, place in zip(self.listeners, self.places[k].tolist(), strict=True)
        )
        gains = self.row_gain[rows].astype(np.float64)
        shape = gains.shape
        return FrameResult(
            number=frame,
            time=self.start + k * self.frame_duration,
            objects=self._table.names,
            contacts=ContactSet.empty(),
            graph=build_graph(
                self._table,
                ContactSet.empty(),
                [
                    Source(item.name, f"Source {k}", item.position, item.amplitude, item.kind)
                    for k, item in enumerate(sources)
                ],
                [
                    Listener(item.name, f"Listener {k}", item.position)
                    for k, item in enumerate(listeners)
                ],
            ),
            propagation=Propagation.of_gains(gains),
            sources=sources,
            listeners=listeners,
            amplitudes=gains,
            impacts=(),
            block=self.samples[:, first:last].astype(np.float64) / FULL_SCALE
            if last > first
            else None,
            first_sample=self.first_sample + first,
            sample_rate=float(self.sample_rate),
            milliseconds={},
            statistics={"sources": shape[0], "listeners": shape[1]},
        )

    @cached_property
    def _table(self) -> ObjectTable:
        """A table with an object of its own for every source and listener, without connections, so
        that none are drawn."""
        count = max(len(self.listeners), int(np.diff(self.rows).max(initial=0)))
        return ObjectTable.of(
            [
                HapticObject(f"{kind} {k}", 0.0, 1.0)
                for kind in ("Listener", "Source")
                for k in range(count)
            ],
            0.1,
        )

    def to_bytes(self) -> bytes:
        """The track as bytes."""
        header = {
            "frame_start": self.frame_start,
            "frames": self.frame_count,
            "frame_duration": self.frame_duration,
            "start": self.start,
            "sample_rate": self.sample_rate,
            "first_sample": self.first_sample,
            "samples": self.samples.shape[1],
            "rows": len(self.row_source),
            "lines": len(self.lines),
            "listeners": [
                [item.name, item.body_part, item.radius, item.s_max] for item in self.listeners
            ],
            "sources": [
                [item.name, item.object, item.second_object, item.onset] for item in self.sources
            ],
            "digest": self.digest,
            "impacts": list(self.impacts.items()),
        }
        packed = [
            zlib.compress(np.ascontiguousarray(getattr(self, name), dtype=kind).tobytes(), 4)
            for name, kind, _ in _ARRAYS
        ]
        text = zlib.compress(
            json.dumps(
                {**header, "packed": [len(data) for data in packed]}, allow_nan=False
            ).encode(),
            6,
        )
        return b"".join([MAGIC, struct.pack("<II", VERSION, len(text)), text, *packed])


def track_from_bytes(data: bytes) -> HapticTrack:
    """The track in ``data``. Raises TrackError."""
    if len(data) < len(MAGIC) + 8 or not data.startswith(MAGIC):
        raise TrackError("this is no haptic track")
    version, length = struct.unpack_from("<II", data, len(MAGIC))
    if version != VERSION:
        raise TrackError(f"the haptic track has version {version}, not {VERSION}: bake again")
    place = len(MAGIC) + 8
    try:
        header = parse_json(_unpacked(data[place : place + length], MAX_HEADER), "haptic track")
        return _track(header, data, place + length)
    except (
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        OverflowError,
        AttributeError,
        zlib.error,
    ) as error:
        raise TrackError(f"the haptic track is damaged: bake again ({error})") from None


def _unpacked(data: bytes, most: int) -> bytes:
    unpacker = zlib.decompressobj()
    result = unpacker.decompress(data, most)
    if not unpacker.eof:
        raise ValueError("it is cut off, or larger than it says")
    return result


def _count(value: Any, most: int) -> int:
    if type(value) is not int or not 0 <= value <= most:
        raise ValueError(f"{value!r} is not from 0 to {most}")
    return value


def _number(value: Any, low: float, high: float) -> float:
    if type(value) not in (int, float) or not low <= value <= high:
        raise ValueError(f"{value!r} is not from {low:g} to {high:g}")
    return float(value)


def _track(header: Form, data: bytes, place: int) -> HapticTrack:
    width = _count(len(header["listeners"]), MAX_LISTENERS)
    _count(len(header["sources"]), MAX_SOURCES)
    listeners = tuple(track_listener(*row) for row in header["listeners"])
    sources = tuple(track_source(*row) for row in header["sources"])
    frames = _count(header["frames"], MAX_FRAMES)
    rows = _count(header["rows"], 1 << 28)
    samples = _count(header["samples"], MAX_BYTES // 2 // max(width, 1))
    lines = _count(header["lines"], MAX_LINES)
    lengths = {"l": width, "n": samples, "f": frames, "f + 1": frames + 1, "r": rows}
    lengths |= {"p": lines, "3": 3, "10": 10}
    arrays = {}
    for (name, kind, axes), packed in zip(_ARRAYS, header["packed"], strict=True):
        shape = [lengths[axis] for axis in axes.split(", ")]
        size = math.prod(shape) * np.dtype(kind).itemsize
        if size > 2 * MAX_BYTES:
            raise ValueError(f"{name} is larger than the limit")
        values = _unpacked(data[place : place + _count(packed, len(data))], size + 1)
        if len(values) != size:
            raise ValueError(f"{name} has {len(values)} bytes, not {size}")
        arrays[name] = np.frombuffer(values, dtype=kind).reshape(shape)
        place += packed
    for name, array in arrays.items():
        if array.dtype.kind == "f" and not (np.abs(array) <= 1e9).all():
            raise ValueError(f"{name} is not finite")
    for name, end in (("offsets", samples), ("rows", rows), ("line_rows", lines)):
        steps = arrays[name]
        if steps[0] != 0 or steps[-1] != end or (np.diff(steps) < 0).any():
            raise ValueError(f"{name} are out of order")
    number = arrays["row_source"]
    if ((number < 0) | (number >= len(sources))).any() or (arrays["row_gain"] < 0).any():
        raise ValueError("a source is missing")
    digest = header["digest"]
    return HapticTrack(
        frame_start=_count(header["frame_start"] + 2**31, 2**32) - 2**31,
        frame_duration=_number(header["frame_duration"], 1e-6, 1e4),
        start=_number(header["start"], -1e9, 1e9),
        sample_rate=max(_count(header["sample_rate"], 192_000), 1),
        first_sample=_count(header["first_sample"] + 2**62, 2**63) - 2**62,
        listeners=listeners,
        sources=sources,
        digest=digest if isinstance(digest, dict) else {},
        impacts={int(frame): str(text) for frame, text in header["impacts"]},
        **arrays,
    )


class BakeRecorder:
    """Collects traced frames into a track: of each frame its samples as integers and a row per
    source."""

    def __init__(self) -> None:
        self._first: FrameResult | None = None
        self._first_sample: int | None = None
        self._frames: list[dict[str, NDArray[Any]]] = []
        self._numbers: dict[Source, int] = {}
        self._impacts: dict[int, str] = {}
        self._room = MAX_IMPACTS
        self._lines = 0

    @property
    def frame_count(self) -> int:
        """Frames recorded so far."""
        return len(self._frames)

    def add(self, result: FrameResult, impacts: str = "", mode: Mode = Mode.HT) -> None:
        """Record the next frame, traced in a ``mode``. ``impacts`` are left out beyond
        `MAX_IMPACTS`, paths beyond `MAX_LINES`."""
        lines = connections(result, mode).rows(result.graph)
        lines = lines if self._lines + len(lines) <= MAX_LINES else lines[:0]
        self._lines += len(lines)
        if 0 < len(impacts) <= self._room:
            self._impacts[result.number] = impacts
            self._room -= len(impacts)
        if self._first is None:
            self._first = result
        if result.block is not None and self._first_sample is None:
            self._first_sample = result.first_sample
        block = np.zeros((len(result.listeners), 0)) if result.block is None else result.block
        places = [item.position for item in result.sources]
        self._frames.append(
            {
                "samples": as_integers(block).T,
                "places": np.array([[item.position for item in result.listeners]], dtype="f4"),
                "row_source": np.array([*map(self._number, result.sources)], dtype="i4"),
                "row_amplitude": np.array([item.amplitude for item in result.sources], dtype="f4"),
                "row_place": np.array(places, dtype="f4").reshape(-1, 3),
                "row_gain": result.amplitudes.astype("f4"),
                "lines": lines.astype("f4"),
            }
        )

    def _number(self, source: Source) -> int:
        """The number of a source in the track."""
        struck = () if source.rubs else (source.second_object, source.onset)
        item = track_source(source.name, source.object, *struck)
        return self._numbers.setdefault(item, len(self._numbers))

    def track(self, digest: Form, frame_duration: float) -> HapticTrack:
        """The track of all recorded frames. Raises ValueError if there are none."""
        if self._first is None:
            raise ValueError("There is no frame to keep")
        arrays = {
            name: np.concatenate([frame[name] for frame in self._frames])
            for name in self._frames[0]
        }
        arrays["samples"] = np.ascontiguousarray(arrays["samples"].T)
        return HapticTrack(
            frame_start=self._first.number,
            frame_duration=frame_duration,
            start=self._first.time,
            sample_rate=round(self._first.sample_rate),
            first_sample=self._first_sample or 0,
            listeners=tuple(
                track_listener(item.name, item.body_part, item.radius, item.s_max)
                for item in self._first.listeners
            ),
            sources=tuple(self._numbers),
            offsets=self._ends("samples"),
            rows=self._ends("row_source"),
            line_rows=self._ends("lines"),
            digest=digest,
            impacts=self._impacts,
            **arrays,
        )

    def _ends(self, name: str) -> IntArray:
        """Where the frames begin in an array, and its end."""
        return np.cumsum([0, *(len(frame[name]) for frame in self._frames)])


def check_size(listeners: int, frames: int, frame_duration: float, sample_rate: float) -> None:
    """Raise ValueError if a track would be larger than `MAX_BYTES`."""
    size = 2 * listeners * frames * frame_duration * sample_rate
    if size > MAX_BYTES or frames > MAX_FRAMES or listeners > MAX_LISTENERS:
        raise ValueError(
            f"{frames} frames of {listeners} listeners are more than a file should keep "
            f"({size / 1e6:.0f} of {MAX_BYTES / 1e6:.0f} MB): "
            "bake fewer frames"
        )
