"""Parts of a bake as files: the active sources and gains of a range of frames, from which
`exported_parts` renders the same samples as a bake without parts.

An ``.npz`` archive without pickled objects: ``header``, JSON in UTF-8, and arrays.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.formats.io.atomic import atomic_file
from ..core.formats.io.budget import Budget, budget_of
from ..core.formats.io.error import FormatError, errors_in
from ..core.formats.io.scene_schema import SCENE
from ..core.formats.io.schema import validate
from ..core.formats.io.strict_json import parse_json
from ..core.formats.scene.values_json import item_to_dict, read_listener, read_source
from ..core.forms import Form
from ..core.frozen import frozen
from ..core.propagation import Propagation
from ..core.regular_file import open_regular
from ..core.render.frame_result import FrameResult
from ..core.scene.references import PlacedError
from ..core.scene.values import Listener, Source

_SCHEMA = "bake_part"
_VERSION = 1
_BARE_SCENE: Form = {"format": "haptic-scene", "version": "1.1", "objects": []}
_NOWHERE = (0.0, 0.0, 0.0)
_LARGEST, _LONGEST_FRAME = 1e9, 100.0
_ROW, _FRAME = 800, 2000  # bytes of a source in a frame, and of a frame, in memory


@frozen
class Origin:
    """Identification of a bake, the same in all its parts. ``frames``: the whole range, ``blend``:
    SHA-256 of the file, ``programs``: the versions that computed it."""

    name: str
    file: str
    blend: str
    mode: str
    settings: tuple[str, ...]
    frames: tuple[int, int]
    parts: int
    programs: str

    def range_of(self, number: int) -> tuple[int, int]:
        """First and last frame of a part, counted from 1."""
        first, last = self.frames
        count = last - first + 1
        return first + count * (number - 1) // self.parts, first + count * number // self.parts - 1

    def traced(self, number: int) -> tuple[int, int]:
        """First and last frame of a part that are kept: the last part also has the frame after the
        range, with which its samples end."""
        first, last = self.range_of(number)
        return first, last + (number == self.parts)

    def title(self, number: int) -> str:
        """Description of a part."""
        first, last = self.range_of(number)
        return f"part {number} of {self.parts} of {self.name} (frames {first} to {last})"


@frozen
class HeardFrame:
    """The data of a traced frame that rendering needs, without positions and contacts."""

    number: int
    time: float
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    propagation: Propagation

    @classmethod
    def of(cls, result: FrameResult) -> HeardFrame:
        """The data of a traced frame."""
        return cls(result.number, result.time, result.sources, result.listeners, result.propagation)


@frozen
class Part:
    """Part ``number`` of a bake. ``before``, ``after``: checksums of the tracer before its first
    frame ("" in the first part) and after its last one: a part continues the part whose ``after``
    equals its ``before``. The first part also has the frames traced before its own, whose signals
    may continue into it, and the ``provenance`` of all."""

    origin: Origin
    number: int
    sample_rate: float
    before: str
    after: str
    frames: tuple[HeardFrame, ...]
    provenance: Form | None = None


def checksum_of(file: Path) -> str:
    """SHA-256 of a file."""
    with open_regular(file) as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


@cache
def programs() -> str:
    """The versions on which the bits of a result depend."""
    return ", ".join(f"{name} {version(name)}" for name in ("haptic-tracing", "bpy", "numpy"))


def write_part(part: Part, path: Path) -> None:
    """Write a part atomically."""
    table = _Table()
    given = table.arrays(part.frames)
    header = {
        "haptic_tracing_part": _VERSION,
        "origin": asdict(part.origin),
        "number": part.number,
        "sample_rate": part.sample_rate,
        "before": part.before,
        "after": part.after,
        **({} if part.provenance is None else {"provenance": dict(part.provenance)}),
        "sources": [item_to_dict(item) for item in table.sources],
        "listeners": [item_to_dict(item) for item in table.listeners],
    }
    arrays = {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **given}
    with atomic_file(path) as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
        if _needed(arrays) > budget_of(file.tell()):
            file.seek(0)
            # Else it would be too small for its content.
            np.savez(file, allow_pickle=False, **arrays)


def read_part(path: Path) -> Part:
    """Read a part. Raises FormatError if it is damaged or not a part, and OSError."""
    budget = Budget(path)
    with open_regular(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                entries = archive.infolist()
                budget.take(sum(entry.file_size for entry in entries))
                arrays = {
                    entry.filename.removesuffix(".npy"): _array(archive, entry) for entry in entries
                }
        except FormatError:
            raise
        except (
            zipfile.BadZipFile,
            zlib.error,
            EOFError,
            OSError,
            ValueError,
            RuntimeError,
            NotImplementedError,
        ) as error:
            raise FormatError(path, "/", f"no part of a bake, or damaged: {error}") from None
    forms = {
        name: {
            "type": array.dtype.str,
            "shape": list(array.shape),
            "fortran": not array.flags.c_contiguous,
        }
        for name, array in arrays.items()
    }
    validate({"arrays": forms}, _SCHEMA, path)
    budget.take(_ROW * len(arrays["source"]) + _FRAME * len(arrays["time"]))
    header = parse_json(arrays.pop("header").tobytes(), path)
    validate({"header": header}, _SCHEMA, path)
    # In a part a source may begin before time 0, in a scene not.
    sources = [
        {key: value for key, value in form.items() if key != "onset"} for form in header["sources"]
    ]
    validate({**_BARE_SCENE, "sources": sources, "listeners": header["listeners"]}, SCENE, path)
    with errors_in(path):
        return _part(header, arrays)


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    """Read an array, with its checksum; it takes no more memory than the entry has bytes."""
    with archive.open(entry) as file:
        np.lib.format.read_magic(file)
        shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(file)
        data = np.frombuffer(file.read(entry.file_size), dtype=dtype)
        return data.reshape(shape, order="F" if is_fortran else "C")


class _Table:
    """The distinct sources and listeners of frames, each stored once without its position, with one
    amplitude per frame."""

    def __init__(self) -> None:
        self.sources: list[Source] = []
        self.listeners: list[Listener] = []
        self._numbers: dict[Any, int] = {}

    def arrays(self, frames: Sequence[HeardFrame]) -> dict[str, NDArray[Any]]:
        """``time`` and ``counts`` (f,) of sources; ``listener`` (f, l); ``source`` and
        ``amplitude`` (r,) of their rows, ``gain`` (r, l); ``has_delay`` and ``has_bands`` (f,), and
        the rows of these frames: ``delay`` (d, l) and ``bands`` (b, l, 6)."""
        found = [frame.propagation for frame in frames]
        people = len(frames[0].listeners)
        delays = [item.delay for item in found if item.delay is not None]
        bands = [item.band_gain for item in found if item.band_gain is not None]
        return {
            "time": np.array([frame.time for frame in frames]),
            "counts": np.array([len(frame.sources) for frame in frames], dtype=np.int64),
            "listener": np.array(
                [
                    [self._number(item, self.listeners) for item in frame.listeners]
                    for frame in frames
                ],
                dtype=np.int64,
            ),
            "source": np.array(
                [self._number(item, self.sources) for frame in frames for item in frame.sources],
                dtype=np.int64,
            ),
            "amplitude": np.array(
                [item.amplitude for frame in frames for item in frame.sources], dtype=np.float64
            ),
            "gain": np.concatenate([item.gain.reshape(-1, people) for item in found]),
            "has_delay": np.array([item.delay is not None for item in found]),
            "has_bands": np.array([item.band_gain is not None for item in found]),
            "delay": np.concatenate(delays) if delays else np.zeros((0, people)),
            "bands": np.concatenate(bands) if bands else np.zeros((0, people, 1)),
        }

    def _number(self, item: Any, known: list[Any]) -> int:
        bare = replace(item, position=_NOWHERE)
        if isinstance(item, Source):
            second = None if item.second_object is None else _NOWHERE
            bare = replace(bare, second_position=second, amplitude=0.0)
        number = self._numbers.setdefault(bare, len(known))
        if number == len(known):
            known.append(bare)
        return number


def _part(header: Form, arrays: Mapping[str, NDArray[Any]]) -> Part:
    """A part from its validated content. Raises PlacedError where that does not fit together."""
    given = header["origin"]
    origin = Origin(
        **{**given, "settings": tuple(given["settings"]), "frames": tuple(given["frames"])}
    )
    sources = [
        read_source(form, ("sources", number)) for number, form in enumerate(header["sources"])
    ]
    listeners = [
        read_listener(form, ("listeners", number))
        for number, form in enumerate(header["listeners"])
    ]
    _check(header, origin, arrays)
    number = int(header["number"])
    first, last = origin.traced(number)
    more = len(arrays["time"]) - (last - first + 1)
    counts = arrays["counts"]
    rows = np.cumsum([0, *counts])
    delays, bands = (
        np.cumsum([0, *(counts * arrays["has_delay"])]),
        np.cumsum([0, *(counts * arrays["has_bands"])]),
    )
    frames = []
    for k, time in enumerate(arrays["time"].tolist()):
        own = slice(rows[k], rows[k + 1])
        heard = tuple(
            replace(sources[row], amplitude=amplitude)
            for row, amplitude in zip(
                arrays["source"][own].tolist(), arrays["amplitude"][own].tolist(), strict=True
            )
        )
        delay = arrays["delay"][delays[k] : delays[k + 1]] if arrays["has_delay"][k] else None
        band_gain = arrays["bands"][bands[k] : bands[k + 1]] if arrays["has_bands"][k] else None
        propagation = Propagation.of_gains(arrays["gain"][own], band_gain, delay)
        frames.append(
            HeardFrame(
                first - more + k,
                time,
                heard,
                tuple(listeners[n] for n in arrays["listener"][k].tolist()),
                propagation,
            )
        )
    return Part(
        origin,
        number,
        float(header["sample_rate"]),
        header["before"],
        header["after"],
        tuple(frames),
        header.get("provenance"),
    )


def _check(header: Form, origin: Origin, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Raise PlacedError unless the numbers of the header and the arrays fit together."""
    first, last = origin.frames
    if not 1 <= header["number"] <= origin.parts <= last - first + 1:
        raise PlacedError(
            ("header", "number"),
            "is not the number of one of the parts, each of at least one frame",
        )
    begin, end = origin.traced(header["number"])
    frames, people, counts = len(arrays["time"]), arrays["gain"].shape[1], arrays["counts"]
    more = frames - (end - begin + 1)
    if more < 0 or (more and header["number"] > 1):
        raise PlacedError(("arrays", "time"), "frames are missing")
    if len(counts) != frames or counts.min() < 0 or counts.max() > len(arrays["source"]):
        raise PlacedError(("arrays", "counts"), "are not the numbers of sources of the frames")
    rows = int(counts.sum())
    shapes: dict[str, tuple[int, ...]] = {
        "listener": (frames, people),
        "source": (rows,),
        "amplitude": (rows,),
        "gain": (rows, people),
        "has_delay": (frames,),
        "has_bands": (frames,),
    }
    for name in ("delay", "bands"):
        shapes[name] = int(counts @ np.resize(arrays[f"has_{name}"], frames)), people
    for name, shape in shapes.items():
        if arrays[name].shape[: len(shape)] != shape:
            raise PlacedError(("arrays", name), f"has the shape {arrays[name].shape}, not {shape}")
    for name, known in (("source", header["sources"]), ("listener", header["listeners"])):
        if arrays[name].size and not (arrays[name].min() >= 0 and arrays[name].max() < len(known)):
            raise PlacedError(("arrays", name), "refers to one that the header does not have")
    for name in ("time", "amplitude", "gain", "delay", "bands"):
        if not (np.abs(arrays[name]) <= _LARGEST).all():
            raise PlacedError(("arrays", name), f"has values beyond {_LARGEST:g}")
    if arrays["amplitude"].size and not (
        arrays["amplitude"].min() >= 0 and arrays["amplitude"].max() <= 1
    ):
        raise PlacedError(("arrays", "amplitude"), "has values that are not from 0 to 1")
    if not ((steps := np.diff(arrays["time"])) > 0).all() or steps.max(initial=0) > _LONGEST_FRAME:
        raise PlacedError(
            ("arrays", "time"), f"does not rise by up to {_LONGEST_FRAME:g} s from frame to frame"
        )


def _needed(arrays: Mapping[str, NDArray[Any]]) -> int:
    """Bytes that a part takes in memory."""
    return (
        sum(array.nbytes + 256 for array in arrays.values())
        + _ROW * len(arrays["source"])
        + _FRAME * len(arrays["time"])
    )
