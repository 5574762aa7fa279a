"""Parametric haptics of OpenXR (``XR_EXT_haptic_parametric``) as JSON, one file per listener: the
members of ``XrHapticParametricVibrationEXT`` by their names, for ``xrApplyHapticFeedback``.

A call takes at most 500 points of amplitude, of frequency, and transients, so that a longer
vibration is a stream of several, which follow each other. Times are nanoseconds from the beginning
of their call. Values of frequency are shares of the range between ``minFrequencyHz`` and
``maxFrequencyHz``. The extension leaves open how an actuator plays a transient.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.io.json_text import write_compact
from ...core.formats.tracks.fidelity import Progress
from ...core.formats.tracks.listener_tracks import Tracks
from ...core.formats.tracks.track_export import TrackExport, common_losses, credit
from ...core.forms import Form, JsonObject
from ...core.signals.drawn import EMPHASIS_SECONDS
from ..keyframes.carrier import Carrier, compare_carriers
from ..keyframes.comparison import Comparison, Kind, Measures
from ..keyframes.envelopes import Burst, WithoutBursts, bursts_of, thinned_carrier
from ..keyframes.files import json_points, listener_files

MOST = 500
"""``XR_HAPTIC_PARAMETRIC_MAX_POINTS_TRANSIENTS_EXT``."""
LOWEST, HIGHEST = 20.0, 500.0
"""Frequencies [Hz] of the values 0 and 1."""
WHOLE, FIRST, INTERMEDIATE, LAST = range(4)
"""Values of ``XrHapticParametricStreamFrameTypeEXT``."""


def loss(export: TrackExport, options: Form) -> Iterator[str]:
    """What the files do not carry, one sentence each."""
    yield from common_losses(export.need_tracks(), body=False)
    yield "the place on the body: the file name gives the listener"
    yield f"all but one oscillation at a time, between {LOWEST:g} and {HIGHEST:g} Hz"
    yield "the form of impacts: each device has its own transients"


def comparison(tracks: Tracks, options: Form, progress: Progress) -> Comparison:
    """What compares the files with the tracks."""
    return Comparison(tracks, Measures(Kind.SPECTRUM, LOWEST, HIGHEST), progress)


def write(export: TrackExport, folder: Path, options: Form, measured: Comparison) -> list[Path]:
    """Write ``<scene>.<listener>.parametric``."""
    files = []
    for number, listener, row, path in listener_files(export, folder, ".parametric"):
        bursts = bursts_of(row, listener.impacts, lambda frequency: (EMPHASIS_SECONDS, 0.5))
        tone = thinned_carrier(WithoutBursts(row, bursts), LOWEST, HIGHEST, options["points"])
        compare_carriers(number, (tone, *map(_played, bursts)), measured)
        document = {
            "name": listener.name,
            "generator": credit(export),
            "vibrations": list(_vibrations(tone, bursts)),
        }
        files.append(write_compact(path, document))
    return files


def _played(burst: Burst) -> Carrier:
    """A transient as the sine that it stands for."""
    zero = np.zeros(1)
    return Carrier(
        burst.time,
        burst.time + burst.seconds,
        0.0,
        zero,
        np.full(1, burst.amplitude),
        zero,
        np.full(1, burst.frequency),
    )


def _vibrations(tone: Carrier, bursts: Sequence[Burst]) -> Iterator[JsonObject]:
    """The calls that play a tone and transients one after the other."""
    borders = _borders(tone, [burst.time for burst in bursts])
    for first, last in pairwise(borders):
        inside = [burst for burst in bursts if first <= burst.time < last]
        yield {
            "amplitudePoints": _points(first, last, tone.amplitude_times, tone.amplitudes),
            "frequencyPoints": _points(first, last, tone.frequency_times, _share(tone.frequencies)),
            "transients": [
                {
                    "time": _nanoseconds(burst.time - first),
                    "amplitude": round(min(burst.amplitude, 1.0), 6),
                    "frequency": round(float(_share(np.array(burst.frequency))), 6),
                }
                for burst in inside
            ],
            "minFrequencyHz": LOWEST,
            "maxFrequencyHz": HIGHEST,
            "streamFrameType": _frame_type(first == borders[0], last == borders[-1]),
        }


def _borders(tone: Carrier, times: Sequence[float]) -> list[float]:
    """Times (seconds) at which calls begin, and the end of the last one: none has more than
    ``MOST`` points of one kind, those at its two borders with them."""
    borders = [0.0]
    kinds = [np.sort(kind) for kind in (tone.amplitude_times, tone.frequency_times, times)]
    while borders[-1] < tone.end:
        ends = [tone.end]
        for kind in kinds:
            later = kind[kind > borders[-1]]
            ends += later[MOST - 2 : MOST - 1].tolist()
        borders.append(min(ends))
    return borders


def _points(first: float, last: float, times: FloatArray, values: FloatArray) -> list[JsonObject]:
    """The keys between two times, with one at each of them."""
    inside = times[(times > first) & (times < last)]
    every = np.concatenate([[first], inside, [last]])
    levels = np.clip(np.interp(every, times, values), 0.0, 1.0).round(6)
    return json_points("time", "value", np.rint((every - first) * 1e9).astype(np.int64), levels)


def _share(frequencies: FloatArray) -> FloatArray:
    """Frequencies [Hz] as shares of the range."""
    return np.clip((frequencies - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0)


def _nanoseconds(seconds: float) -> int:
    return math.floor(seconds * 1e9 + 0.5)


def _frame_type(is_first: bool, is_last: bool) -> int:
    if is_first and is_last:
        return WHOLE
    return FIRST if is_first else LAST if is_last else INTERMEDIATE
