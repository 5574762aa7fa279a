"""Motions: what was packed comes back to the last digit, by a decoder written from the words of the
schema too; broken ones say why."""

import base64
import json
import zlib

import numpy as np
import pytest
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.motion import decoded, encoded, packed, unpacked
from haptic_tracing.core.formats.scene.recording import Poses, RecordedFrame, Recording
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Pose
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

tables = st.integers(1, 20).flatmap(
    lambda n: arrays(np.int64, (n, 7), elements=st.integers(-(10**14), 10**14))
)


def by_the_words_of_the_schema(text, count):
    """One number after the other, with Python's own integers."""
    data = zlib.decompress(base64.b64decode(text))
    numbers = [
        sum(data[plane * 7 * count + k] << (8 * plane) for plane in range(8))
        for k in range(7 * count)
    ]
    numbers = [n // 2 if n % 2 == 0 else -(n + 1) // 2 for n in numbers]
    columns = []
    for c in range(7):
        column = numbers[c * count : (c + 1) * count]
        for n in range(1, count):
            column[n] += column[n - 1] if n == 1 else 2 * column[n - 1] - column[n - 2]
        columns.append(column)
    return np.array(columns).T


@settings(deadline=None, derandomize=True)
@given(table=tables)
def test_tables_come_back(table):
    text = encoded(table)
    np.testing.assert_array_equal(decoded(text, len(table)), table)
    np.testing.assert_array_equal(by_the_words_of_the_schema(text, len(table)), table)


def rolling(names, frames, seed=0):
    """Objects that go round and turn, each in its own way."""
    random = np.random.default_rng(seed)
    phase, speed, radius = (
        random.uniform(0, 6, len(names)),
        random.uniform(0.5, 3, len(names)),
        random.uniform(0.5, 5, len(names)),
    )
    for number in range(1, frames + 1):
        angle = phase + speed * number / 24
        turned = [
            np.cos(angle / 2),
            np.zeros_like(angle),
            0.6 * np.sin(angle / 2),
            0.8 * np.sin(angle / 2),
        ]
        rows = np.column_stack(
            [radius * np.cos(angle), radius * np.sin(angle), np.abs(np.sin(3 * angle)), *turned]
        )
        yield RecordedFrame(number, poses=Poses(tuple(names), np.rint(rows * 1e5).astype(np.int64)))


def exported(frames, count, tmp_path, name):
    names = [f"crate.{k:03d}" for k in range(count)]
    scene = HapticScene(tuple(HapticObject(n, 0.3, 0.8, pose=Pose()) for n in names))
    export = Export("many", scene, recording=Recording(24.0, 1, tuple(rolling(names, frames))))
    write_export(export, tmp_path / name)
    return export, (tmp_path / name).stat().st_size


def test_a_long_recording_comes_back_the_same(tmp_path):
    export, size = exported(300, 100, tmp_path, "many.json")
    document = json.loads((tmp_path / "many.json").read_bytes())
    assert len(document["motions"]) == 100 and not any(
        "poses" in frame for frame in document["frames"]
    )
    again = read_export(tmp_path / "many.json")
    assert again.recording == export.recording
    write_export(again, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (
        tmp_path / "many.json"
    ).read_bytes() and size < 30_000 * 14


def test_a_thousand_objects_that_all_move_over_3600_frames_stay_under_50_mb(tmp_path):
    """As many frames as tell the size of all: a tenth, in which the beginnings of the motions weigh
    more than in all of them."""
    _, size = exported(360, 1000, tmp_path, "all.json")
    print(
        "\n3,600 frames, 1,000 objects, all of them moving in every frame: "
        f"{10 * size / 1e6:.1f} MB"
    )
    assert 10 * size < 50e6


def test_few_poses_stay_readable_and_fine_ones_exact():
    few = tuple(RecordedFrame(n, poses={"a": (n, 0, 0, 1, 0, 0, 0)}) for n in range(100))
    assert packed(few) == ([], few)
    fine = tuple(
        RecordedFrame(n, poses={str(k): (k / 3, 0, 0, 1, 0, 0, 0) for k in range(300)})
        for n in range(100)
    )
    assert packed(fine) == ([], fine)


def test_what_moves_for_a_moment_stands_in_the_frames():
    frames = []
    for n in range(300):
        poses = {f"{k:03d}": (n + k, 0.5, -0.25, 1.0, 0.0, 0.0, 0.0) for k in range(100)}
        if n % 50 < 5:
            poses["short"] = (n, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
        frames.append(RecordedFrame(n if n < 200 else n + 10, poses=poses))
    motions, left = packed(frames)
    assert len(motions) == 200 and {motion["count"] for motion in motions} == {200, 100}
    assert [len(frame.poses) for frame in left] == [1 if n % 50 < 5 else 0 for n in range(300)]
    poses = unpacked(motions, {motion["object"] for motion in motions})
    for frame, rest in zip(frames, left, strict=True):
        assert {**poses[frame.number], **rest.poses} == frame.poses


GOOD = {
    "object": "a",
    "frame": 1,
    "count": 2,
    "poses": encoded(np.array([[0, 0, 0, 1, 0, 0, 0]] * 2)),
}
BOMB = base64.b64encode(zlib.compress(bytes(50_000_000))).decode()


@pytest.mark.parametrize(
    ("motions", "expected"),
    [
        ([{**GOOD, "object": "b"}], "/motions/0/object: there is no object 'b'"),
        ([{**GOOD, "count": 3}], "/motions/0/poses: does not hold 3 poses"),
        ([{**GOOD, "count": 1}], "/motions/0/poses: does not hold 1 poses"),
        ([{**GOOD, "count": 4_500_000}, GOOD], "/motions/0/poses: does not hold 4500000 poses"),
        ([GOOD, {**GOOD, "count": 4_500_000}], "/motions/1/count: more than 4500000 poses"),
        ([{**GOOD, "poses": BOMB}], "/motions/0/poses: does not hold 2 poses"),
        ([{**GOOD, "poses": "%"}], "/motions/0/poses: is not base64"),
        ([{**GOOD, "poses": "AAAA"}], "/motions/0/poses: is not compressed by zlib"),
        (
            [{**GOOD, "poses": encoded(np.zeros((2, 7), dtype=np.int64))}],
            "/motions/0/poses: a quaternion of length 0 is no rotation",
        ),
        (
            [{**GOOD, "poses": encoded(np.full((2, 7), 10**15))}],
            "/motions/0/poses: beyond 1e9 metres",
        ),
        ([GOOD, GOOD], "/motions: 'a' has two poses in frame 1"),
        ([{**GOOD, "frame": 2}], "/motions: frame 3 is not among the frames"),
        ([{**GOOD, "frame": 0}], "/motions: frame 0 is not among the frames"),
        ([{**GOOD, "count": 0}], "/motions/0/count: must be at least 1"),
        ([{**GOOD, "speed": 0}], "/motions/0/speed: unknown key"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(tmp_path, motions, expected):
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "a", "kappa": 0, "rho": 1}],
        "frame_rate": 24,
        "motions": motions,
        "frames": [{"frame": 1}, {"frame": 2}],
    }
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(document))
    with pytest.raises(FormatError) as caught:
        read_export(path)
    assert str(caught.value).startswith(f"{path}: {expected}")


def test_a_pose_for_a_frame_stands_in_one_place(tmp_path):
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "a", "kappa": 0, "rho": 1}],
        "frame_rate": 24,
        "motions": [GOOD],
        "frames": [{"frame": 1, "poses": {"a": [0, 0, 0, 1, 0, 0, 0]}}, {"frame": 2}],
    }
    (tmp_path / "bad.json").write_text(json.dumps(document))
    with pytest.raises(
        FormatError, match="/frames/0/poses/a: a motion has a pose for this frame, too"
    ):
        read_export(tmp_path / "bad.json")
