"""Parts of a bake against the bake in one go, to the bit; and what `export` says of parts that don't
add up."""

import json
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.session import session, timeline
from haptic_tracing.command_line import build_parser, exported_parts, main, part
from haptic_tracing.command_line.part_file import (
    HeardFrame,
    Origin,
    Part,
    programs,
    read_part,
    write_part,
)
from haptic_tracing.command_line.sample import _bake_rigid_bodies
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.tracks.track_recorder import TrackRecorder
from haptic_tracing.core.propagation import Propagation
from haptic_tracing.core.render.renderer import sample_index
from haptic_tracing.core.scene.values import Listener, Source, SourceKind
from haptic_tracing.core.signals import Sampled, Sine
from haptic_tracing.sample_scenes import SAMPLES, build_sample

RINGING = ("jackhammer_bench", "hammer_nail")
"""Samples in which an impact sounds over a cut."""
FEWER = {"domino_wall": 24, "pile": 8}
TYPICAL = ("hammer_nail", "domino_wall", "sliding_and_rolling")
"""Samples that represent the others in the suite: a blow that sounds over a cut, many impacts, what
slides and rolls."""


class Run:
    """Frames ``start`` to ``last`` of a scene, the checksums after them, and their samples."""

    def __init__(self, scene, start, last, looks_back=False):
        self.frames, self.after, self._recorder = {}, {}, TrackRecorder()
        for step in timeline.steps(scene, start, last, looks_back=looks_back):
            self.frames[step.result.number] = HeardFrame.of(step.result)
            self.after[step.result.number] = session.of(scene).tracer.checksum()
            self._recorder.add(step.result)
        self.rate = step.result.sample_rate

    @cached_property
    def tracks(self):
        return self._recorder.tracks()


def origin_of(name, last, parts):
    """Of a range that begins with frame 1 and ends with the beginning of frame ``last``."""
    return Origin(name, "", "", "HT", (), (1, last - 1), parts, programs())


def baked_part(runs, origin, number, start):
    """A part as `export --part` traces it: from ``start``."""
    first, last = origin.traced(number)
    own = runs[start]
    frames = tuple(own.frames[frame] for frame in range(first, last + 1))
    return Part(origin, number, own.rate, own.after.get(first - 1, ""), own.after[last], frames)


def built(name, count=None):
    """A sample, alone in a new file: rows name objects."""
    with suspended():
        bpy.ops.wm.read_homefile(use_empty=True)
        return build_sample(name, count)


@pytest.fixture(scope="module")
def slides(registered, tmp_path_factory):
    """The file of a sample in which things slide and roll, with its simulation baked."""
    path = tmp_path_factory.mktemp("slides") / "slides.blend"
    _bake_rigid_bodies(built("sliding_and_rolling"))
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in TYPICAL else pytest.param(name, marks=pytest.mark.more) for name in SAMPLES],
)
def test_parts_of_every_sample_add_up_to_the_bit(registered, tmp_path, name):
    scene = built(name, FEWER.get(name))
    seconds = timeline.sounding_seconds(scene)
    last = next(
        last
        for last in range(60, 500, 7)
        if timeline.warm_start(scene, origin_of(name, last, 7).range_of(7)[0], seconds) > 1
    )
    if scene.rigidbody_world is not None:
        scene.rigidbody_world.point_cache.frame_end = last
    _bake_rigid_bodies(scene)
    starts = {
        (parts, number): max(
            timeline.warm_start(scene, origin_of(name, last, parts).range_of(number)[0], seconds), 1
        )
        for parts in (2, 3, 7)
        for number in range(1, parts + 1)
    }
    ends = {1: last}  # of each run, the last frame that is wanted
    for (parts, number), start in starts.items():
        ends[start] = max(origin_of(name, last, parts).traced(number)[1], ends.get(start, 0))
    runs = {start: Run(scene, start, end) for start, end in ends.items()}
    rings_over_a_cut = False
    for parts in (2, 3, 7):
        origin = origin_of(name, last, parts)
        for number in range(1, parts + 1):
            write_part(
                baked_part(runs, origin, number, starts[parts, number]), tmp_path / f"{number}.npz"
            )
            at_cut = runs[1].frames[origin.range_of(number)[0]]
            rings_over_a_cut |= any(
                s.kind is SourceKind.TEMPORARY and s.onset < at_cut.time - 0.05
                for s in at_cut.sources
            )
        merged = exported_parts._tracks(
            exported_parts._bakes([tmp_path / f"{number}.npz" for number in range(1, parts + 1)])[
                name
            ]
        )
        assert merged.samples.tobytes() == runs[1].tracks.samples.tobytes()
        for one, other in zip(merged.listeners, runs[1].tracks.listeners, strict=True):
            assert (one.name, one.impacts.tobytes()) == (other.name, other.impacts.tobytes())
    assert len(runs) > 1  # some part was traced without the first frames
    assert rings_over_a_cut or name not in RINGING


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene_start", "frames"), [(1, (1, 118)), (1, (185, 240)), (200, (180, 260))]
)
def test_parts_and_ranges_of_what_slides_have_the_bits_of_the_whole(
    slides, tmp_path, scene_start, frames
):
    """The range begins with the scene's first frame, in the middle of a slide after it, and before
    it. A file slides in frames 5 to 57, a ball rolls in 65 to 113, and a crate slides in 177 to
    241."""
    bpy.ops.wm.open_mainfile(filepath=str(slides))
    scene = bpy.context.scene
    scene.frame_start = scene_start
    whole = Run(scene, *frames, looks_back=True)
    assert whole.tracks.samples.any(axis=1).sum() > 1
    origins = {
        parts: replace(origin_of("slides", 2, parts), frames=(frames[0], frames[1] - 1))
        for parts in (2, 3, 7)
    }
    starts = {
        (parts, k): part.start_of(scene, origins[parts], k)
        for parts in origins
        for k in range(1, parts + 1)
    }
    ends = {}
    for (parts, number), start in starts.items():
        ends[start] = max(origins[parts].traced(number)[1], ends.get(start, 0))
    begin = starts[2, 1]  # of the whole as well
    runs = {
        start: whole if start == begin else Run(scene, start, end) for start, end in ends.items()
    }
    longest = part._baked(scene, origins[2], 1, begin)
    for parts, origin in origins.items():
        last = origin.traced(1)[1]
        heard = tuple(frame for frame in longest.frames if frame.number <= last)
        write_part(
            replace(
                longest,
                origin=origin,
                after=longest.after if parts == 2 else whole.after[last],
                frames=heard,
            ),
            tmp_path / "1.npz",
        )
        for number in range(2, parts + 1):
            write_part(
                baked_part(runs, origin, number, starts[parts, number]), tmp_path / f"{number}.npz"
            )
        merged = exported_parts._tracks(
            exported_parts._bakes([tmp_path / f"{number}.npz" for number in range(1, parts + 1)])[
                "slides"
            ]
        )
        assert merged.samples.tobytes() == whole.tracks.samples.tobytes()
    if scene_start == frames[0]:
        own = Run(scene, 90, 100, looks_back=True)
        begin = sample_index((90 - frames[0]) / 24, own.rate)
        assert own.tracks.samples.any()
        assert np.array_equal(
            own.tracks.samples, whole.tracks.samples[:, begin : begin + own.tracks.samples.shape[1]]
        )


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "haptic_tracing", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def hammer(falling):
    """The hammer's file, its bake by the add-on, and two parts of it; the blow is between frames 1
    and 30."""
    for number in (1, 2):
        args = build_parser().parse_args(
            [
                "export",
                str(falling / "hammer.blend"),
                "--part",
                f"{number}/2",
                "--out",
                str(falling),
            ]
        )
        part.write_parts_of(bpy.context.scene, args, "hammer", (1, 30))
    return falling


def parts_in(hammer, folder):
    """Copies of the two parts."""
    return [str(shutil.copy(hammer / f"hammer.{number}-of-2.npz", folder)) for number in (1, 2)]


@pytest.mark.slow
def test_merged_files_are_those_of_the_bake(hammer, tmp_path, capsys):
    assert main(["export", *parts_in(hammer, tmp_path), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "hammer.wav").read_bytes() == (hammer / "addon.wav").read_bytes()


@pytest.mark.slow
def test_another_process_keeps_a_part_that_is_there(hammer):
    done = run(
        "export", hammer / "hammer.blend", "--frames", "1:30", "--out", hammer, "--part", "2/2"
    )
    assert done.returncode == 0 and "kept" in done.stdout


@pytest.mark.slow
def test_parts_that_do_not_add_up_are_named(hammer, tmp_path, capsys):
    first, second = parts_in(hammer, tmp_path)
    known = read_part(Path(second))

    def said(*parts):
        assert main(["export", *map(str, parts), "--out", str(tmp_path / "out")]) == 2
        assert not (tmp_path / "out").exists()
        return capsys.readouterr().err

    assert "missing: part 2 of 2 of hammer (frames 16 to 30)" in said(first)
    for change, words in (
        ({"blend": "0" * 64}, "of another .blend file"),
        ({"settings": ("scene.haptics.minimum_energy=0",)}, "of other settings"),
        ({"programs": "haptic-tracing 0.0.1"}, "of other versions"),
    ):
        write_part(replace(known, origin=replace(known.origin, **change)), second)
        assert f"{second}: {words} than {first}" in said(first, second)
    write_part(replace(known, before="0"), second)
    assert f"{second}: what moved and touched before it is not known to the bit" in said(
        first, second
    )
    write_part(
        replace(known, origin=replace(known.origin, file=str(hammer / "hammer.1-of-2.npz"))), second
    )
    assert "stale" in said(second, first)


@pytest.mark.slow
def test_damaged_parts_are_named(hammer, tmp_path, capsys):
    first, second = parts_in(hammer, tmp_path)
    whole = Path(second).read_bytes()
    flipped = whole[:200] + bytes([whole[200] ^ 1]) + whole[201:]
    for damaged in (b"", whole[: len(whole) // 2], flipped, b"PK" + whole[:100]):
        Path(second).write_bytes(damaged)
        assert main(["export", first, second, "--out", str(tmp_path / "out")]) == 2
        assert f"{second}: no part of a bake, or damaged" in capsys.readouterr().err


def test_a_part_keeps_recordings_bands_and_delays_to_the_bit(tmp_path):
    rng = np.random.default_rng(1)
    recording = Sampled(rng.normal(scale=0.1, size=1000), 8000.0)
    saw = Source("saw", "box", (1.0, 2.0, 3.0), 0.3, signal=recording, extras={"x": [1, {"y": 2}]})
    hit = Source(
        "hit",
        "box",
        kind=SourceKind.TEMPORARY,
        signal=Sine(60.0 + 1e-13),
        second_object="floor",
        onset=0.1 / 3,
    )

    def frame(number, *sources, bands):
        shape = len(sources), 1
        more = (rng.random((*shape, 6)), None) if bands else (None, rng.random(shape))
        gains = Propagation.of_gains(rng.random(shape), *more)
        return HeardFrame(
            number,
            number / 7,
            sources,
            (Listener("hand", "box", (number, 0.0, 0.0), radius=0.0),),
            gains,
        )

    frames = (
        frame(1, saw, bands=True),
        frame(2, bands=False),
        frame(3, saw, hit, bands=False),
        frame(4, replace(saw, amplitude=0.1), bands=True),
    )
    write_part(Part(origin_of("any", 4, 1), 1, 8000.0, "", "after", frames), tmp_path / "part.npz")
    for kept, read in zip(frames, read_part(tmp_path / "part.npz").frames, strict=True):
        assert (kept.number, kept.time, len(kept.sources)) == (
            read.number,
            read.time,
            len(read.sources),
        )
        for one, other in zip(kept.sources, read.sources, strict=True):
            keys = ("name", "amplitude", "kind", "signal", "onset", "priority", "extras")
            assert [getattr(one, key) for key in keys] == [getattr(other, key) for key in keys]
        for key in ("gain", "band_gain", "delay"):
            one, other = getattr(kept.propagation, key), getattr(read.propagation, key)
            assert (one is None) == (other is None) and (
                one is None or one.tobytes() == other.tobytes()
            )


def test_an_array_is_read_only_as_far_as_the_file_goes(tmp_path):
    """A header that claims a terabyte, and one with objects."""
    for name, dtype, shape in (("claims", "|u1", (2**40,)), ("objects", "|O", (1,))):
        path = tmp_path / f"{name}.npz"
        with zipfile.ZipFile(path, "w") as archive, archive.open("header.npy", "w") as entry:
            np.lib.format.write_array_header_1_0(
                entry, {"descr": dtype, "fortran_order": False, "shape": shape}
            )
            entry.write(b"\0" * 8)
        with pytest.raises(FormatError, match="no part of a bake, or damaged: "):
            read_part(path)


@pytest.fixture
def small_part(tmp_path):
    """A part of two frames, and a function that writes it with changes to its header and arrays."""
    saw, hand = (
        Source("saw", "box", (0.0, 0.0, 0.0), 0.3, signal=Sine(60.0)),
        Listener("hand", "box", (0.0, 0.0, 0.0), radius=0.0),
    )
    frames = tuple(
        HeardFrame(n, n / 24, (saw,), (hand,), Propagation.of_gains(np.full((1, 1), 0.5)))
        for n in (1, 2)
    )
    path = tmp_path / "part.npz"
    write_part(Part(origin_of("any", 2, 1), 1, 8000.0, "", "after", frames), path)

    def write(change_header=lambda header: None, **arrays):
        with np.load(path) as archive:
            stored = {name: archive[name] for name in archive.files}
        header = json.loads(stored["header"].tobytes())
        change_header(header)
        stored |= {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays}
        np.savez_compressed(
            path, **{name: array for name, array in stored.items() if array is not None}
        )
        return path

    return write


def setting(*place, value):
    def change(header):
        for key in place[:-1]:
            header = header[key]
        header[place[-1]] = value

    return change


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("origin", "parts"), 0, "/header/origin/parts: must be at least 1, got 0"),
        (("origin", "parts"), 50_000_000, "/header/origin/parts: must be at most"),
        (("origin", "parts"), 3, "/header/number: is not the number of one of the parts"),
        (("number",), 2.5, "/header/number: must be an integer"),
        (("sources",), "saw", '/header/sources: must be an array, got "saw"'),
        (("sources", 0), "saw", '/header/sources/0: must be an object, got "saw"'),
        (("sources", 0, "signal"), {"signal": "sine", "frequency": "high"}, "/sources/0/signal"),
        (("listeners", 0, "gain"), "loud", "/listeners/0/gain: must be a number"),
        (("origin", "frames"), [1], "/header/origin/frames: must have at least 2 items"),
        (("origin", "frames"), [1, 3], "/arrays/time: frames are missing"),
        (("haptic_tracing_part",), 2, "/header/haptic_tracing_part: must be 1, got 2"),
        (("k" * 5000,), 1, "/header/kkk"),
    ],
)
def test_a_part_with_a_strange_header_is_refused_with_its_place(small_part, place, value, message):
    path = small_part(setting(*place, value=value))
    with pytest.raises(FormatError) as caught:
        read_part(path)
    assert str(caught.value).startswith(f"{path}: {message}") and len(str(caught.value)) < 600


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"gain": None}, "/arrays/gain: is required"),
        ({"more": np.zeros(1)}, "/arrays/more: unknown key"),
        (
            {"gain": np.zeros((2, 1), dtype=np.float32)},
            '/arrays/gain/type: must be "<f8", got "<f4"',
        ),
        ({"gain": np.zeros((3, 1))}, "/arrays/gain: has the shape"),
        ({"gain": np.full((2, 1), np.nan)}, "/arrays/gain: has values beyond"),
        ({"time": np.array([0.0, 1e8])}, "/arrays/time: does not rise"),
        ({"counts": np.array([1, -1])}, "/arrays/counts: are not the numbers"),
        (
            {"source": np.array([0, 7])},
            "/arrays/source: refers to one that the header does not have",
        ),
        (
            {"source": np.array([0, -1])},
            "/arrays/source: refers to one that the header does not have",
        ),
    ],
)
def test_a_part_with_strange_arrays_is_refused_with_its_place(small_part, arrays, message):
    path = small_part(**arrays)
    with pytest.raises(FormatError) as caught:
        read_part(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@pytest.mark.slow
def test_a_part_that_would_become_gigabytes_is_refused(small_part):
    """Zeros, a thousandth of their size when compressed."""
    path = small_part(gain=np.zeros((2, 16_000_000)))
    assert path.stat().st_size < 300_000
    with pytest.raises(FormatError, match=r"its content takes more than 7. MB of memory"):
        read_part(path)


@pytest.mark.slow
def test_a_large_part_of_equal_gains_is_read_again(tmp_path):
    """It is stored without compression, which would make it too small for its content."""
    saws = tuple(Source(f"saw {n}", "box", (0.0, 0.0, 0.0), 0.3) for n in range(1000))
    hand, gains = (
        Listener("hand", "box", (0.0, 0.0, 0.0), radius=0.0),
        Propagation.of_gains(np.full((1000, 1), 0.5)),
    )
    frames = tuple(HeardFrame(n, n / 24, saws, (hand,), gains) for n in range(1, 101))
    write_part(
        Part(origin_of("any", 100, 1), 1, 8000.0, "", "after", frames), tmp_path / "part.npz"
    )
    assert (read_part(tmp_path / "part.npz").frames[99].propagation.gain == 0.5).all()


def test_an_encrypted_part_is_refused(small_part):
    path = small_part()
    data = bytearray(path.read_bytes())
    for signature, flags in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        place = data.find(signature)
        data[place + flags] |= 1
    path.write_bytes(data)
    with pytest.raises(FormatError, match=r"no part of a bake, or damaged: .* is encrypted"):
        read_part(path)
