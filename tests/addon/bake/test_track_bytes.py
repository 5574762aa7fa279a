"""A track as bytes: what goes in comes out, and nothing but a track comes out of anything else."""

import json
import struct
import zlib

import numpy as np
import pytest
from haptic_tracing.addon.bake.track import (
    MAGIC,
    HapticTrack,
    TrackError,
    check_size,
    track_from_bytes,
    track_listener,
    track_source,
)
from hypothesis import given, settings
from hypothesis import strategies as st

ARRAYS = (
    "samples",
    "offsets",
    "places",
    "rows",
    "row_source",
    "row_amplitude",
    "row_place",
    "row_gain",
    "lines",
    "line_rows",
)
deterministic = settings(derandomize=True, deadline=None)


def random_track(seed):
    random = np.random.default_rng(seed)
    frames, width, many = (int(random.integers(0, n)) for n in (9, 5, 6))
    sounding = random.integers(0, 4, frames) if many else np.zeros(frames, dtype=int)
    counts = random.integers(0, 50, frames)
    rows = int(sounding.sum())
    return HapticTrack(
        frame_start=int(random.integers(-99, 99)),
        frame_duration=float(random.uniform(0.001, 0.1)),
        start=float(random.uniform(-9, 9)),
        sample_rate=8000,
        first_sample=int(random.integers(-(10**6), 10**6)),
        listeners=tuple(track_listener(f"ω {k}", "hand.L", 0.05, 0.9) for k in range(width)),
        sources=tuple(
            track_source(f"s{k}", "o", "p" if k % 2 else None, 0.25 * k) for k in range(many)
        ),
        samples=random.integers(-32767, 32768, (width, int(counts.sum()))).astype(np.int16),
        offsets=np.cumsum([0, *counts]).astype(np.int64),
        places=random.normal(size=(frames, width, 3)).astype(np.float32),
        rows=np.cumsum([0, *sounding]).astype(np.int64),
        row_source=random.integers(0, max(many, 1), rows).astype(np.int32),
        row_amplitude=random.uniform(0, 1, rows).astype(np.float32),
        row_place=random.normal(size=(rows, 3)).astype(np.float32),
        row_gain=random.uniform(0, 1, (rows, width)).astype(np.float32),
        lines=random.normal(size=(3 * frames, 10)).astype(np.float32),
        line_rows=3 * np.arange(frames + 1),
        digest={"objects": {"a": {"pose": "0"}}},
        impacts={int(frame): "ω" * int(frame) for frame in random.integers(-99, 99, 3)},
    )


@deterministic
@given(st.integers(0, 2**32 - 1))
def test_round_trip(seed):
    track = random_track(seed)
    again = track_from_bytes(track.to_bytes())
    for name in ARRAYS:
        assert np.array_equal(getattr(again, name), getattr(track, name)), name
    for name in (
        "frame_start",
        "frame_duration",
        "start",
        "sample_rate",
        "first_sample",
        "listeners",
        "sources",
        "digest",
        "impacts",
    ):
        assert getattr(again, name) == getattr(track, name), name
    for frame in range(track.frame_start - 1, track.frame_end + 3):
        result = again.result(frame)
        assert (result is not None) == (track.frame_start <= frame <= track.frame_end + 1)
        if result is not None:
            number = 3 * (frame - track.frame_start)
            assert np.array_equal(again.paths(frame), track.lines[number : number + 3])


@deterministic
@given(st.integers(0, 99), st.data())
def test_damaged_bytes_are_refused_or_read_as_a_track(seed, data):
    whole = bytearray(random_track(seed).to_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    try:
        track = track_from_bytes(bytes(whole[: data.draw(st.integers(0, len(whole)))]))
    except TrackError:
        return
    for frame in range(track.frame_start, track.frame_end + 1):
        result = track.result(frame)
        assert result is not None and result.number == frame


def _with_header(change):
    """The bytes of a track whose header was changed."""
    data = random_track(7).to_bytes()
    (length,) = struct.unpack_from("<I", data, len(MAGIC) + 4)
    place = len(MAGIC) + 8
    header = json.loads(zlib.decompress(data[place : place + length]))
    change(header)
    text = zlib.compress(json.dumps(header).encode())
    return data[: len(MAGIC) + 4] + struct.pack("<I", len(text)) + text + data[place + length :]


@pytest.mark.parametrize(
    "change",
    [
        lambda h: h.update(samples=2**40),
        lambda h: h.update(frames=2**40),
        lambda h: h.update(rows=-1),
        lambda h: h.update(rows=10**8),
        lambda h: h.update(sample_rate="8000"),
        lambda h: h.update(frame_duration=0),
        lambda h: h.update(frame_duration=float("nan")),
        lambda h: h.update(listeners=None),
        lambda h: h.update(listeners=[[1, 2, 3, 4]]),
        lambda h: h.update(sources=[["s"]]),
        lambda h: h.update(packed=[]),
        lambda h: h.update(packed=[-5] * len(ARRAYS)),
        lambda h: h.update(frame_start=[]),
        lambda h: h.pop("digest"),
    ],
)
def test_hostile_headers_are_refused(change):
    with pytest.raises(TrackError, match="bake again"):
        track_from_bytes(_with_header(change))


@pytest.mark.slow
def test_a_small_file_that_unpacks_to_a_huge_one_is_refused():
    bomb = zlib.compress(bytes(1 << 27), 9)
    data = MAGIC + struct.pack("<II", 1, len(bomb)) + bomb
    with pytest.raises(TrackError, match="larger than it says"):
        track_from_bytes(data)


def test_other_bytes_and_versions_are_named():
    with pytest.raises(TrackError, match="no haptic track"):
        track_from_bytes(b"RIFF....WAVE")
    data = bytearray(random_track(1).to_bytes())
    data[len(MAGIC)] = 9
    with pytest.raises(TrackError, match="version 9"):
        track_from_bytes(bytes(data))


def test_what_is_too_much_for_a_file_is_refused_before_it_is_traced():
    check_size(10, 3600, 1 / 24, 8000.0)
    with pytest.raises(ValueError, match="bake fewer frames"):
        check_size(10, 100_000, 1 / 24, 8000.0)
