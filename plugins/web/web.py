"""A self-contained web page that plays the tracks: body map, levels over time, sound, and a gamepad
by the Gamepad API."""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import FloatArray
from ...core.formats.io.atomic import write_text
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit, scene_file
from ...core.forms import Form
from ...core.render import lane
from ...core.scene.body_map import figure
from ...core.signals.interpolation import resample
from ..keyframes.comparison import Comparison, Kind, Measures

RATE = 2000
"""Largest sample rate [Hz], with which 150 s of ten listeners take less than 5 MB."""
HIGHEST = 900.0
"""Highest frequency at this rate [Hz]."""
_STEPS = 127
_LAW = 255.0


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the page does not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=True)
    yield (
        f"frequencies above {HIGHEST:g} Hz, and all but 8 bit of each sample, on a logarithmic "
        "scale"
    )


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.WAVE, 0.0, HIGHEST), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.html``."""
    tracks = export.need_tracks()
    rate = min(RATE, tracks.sample_rate)
    packed = [_packed(tracks, number, rate, measured) for number in range(len(tracks.listeners))]
    document = {
        "rate": rate,
        "count": -(-tracks.count * rate // tracks.sample_rate),
        "figures": [
            [[limb.part, *limb.start, *limb.end, limb.width] for limb in figure(view)]
            for view in ("front", "back")
        ],
        "listeners": [
            {
                "name": listener.name,
                "body_part": listener.body_part,
                "samples": samples,
                "lane": row,
            }
            for listener, (samples, row) in zip(tracks.listeners, packed, strict=True)
        ],
    }
    # Names are untrusted: without "<" they cannot end the element that contains them.
    text = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":")).replace(
        "<", "\\u003c"
    )
    parts = {
        "@TITLE@": html.escape(export.name),
        "@CREDIT@": html.escape(credit(export)),
        "@DATA@": text,
    }
    page = Path(__file__).with_name("player.html").read_text("utf-8")
    path = scene_file(export.name, folder, ".html")
    return [write_text(path, (parts.get(piece, piece) for piece in re.split(r"(@[A-Z]+@)", page)))]


def _packed(tracks: Tracks, number: int, rate: int, measured: Comparison) -> tuple[str, str]:
    """A listener's samples at ``rate``, a byte each, compressed, as text; and its level as SVG."""
    row = tracks.row(number).read(0, tracks.count)
    coded = encoded(resample(row, tracks.sample_rate, rate))
    played = resample(decoded(coded), rate, tracks.sample_rate)[: len(row) : measured.thinning]
    measured.add(number, played)
    text = base64.b64encode(zlib.compress(coded.tobytes(), 9)).decode("ascii")
    return text, lane.svg(row, tracks.sample_rate)


def encoded(samples: FloatArray) -> NDArray[np.uint8]:
    """Samples within ±1 as bytes: 128 is 0, steps grow with the logarithm of 1 + 255 |x| (the µ-law
    of ITU-T G.711, without its segments)."""
    cut = np.clip(samples, -1.0, 1.0)
    return np.asarray(
        np.rint(128 + _STEPS * np.sign(cut) * np.log1p(_LAW * np.abs(cut)) / np.log1p(_LAW)),
        dtype=np.uint8,
    )


def decoded(codes: NDArray[np.uint8]) -> FloatArray:
    """Decode bytes to samples, as the page does."""
    steps = (codes.astype(np.float64) - 128) / _STEPS
    return np.asarray(np.sign(steps) * np.expm1(np.abs(steps) * np.log1p(_LAW)) / _LAW)
