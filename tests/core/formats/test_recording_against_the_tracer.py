"""A recorded scene, written, read and traced again, against the tracer's first run; sizes;
references that lead nowhere."""

import copy
import gzip
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body, Motion
from haptic_tracing.core.contacts.shapes import Box, pose_matrix
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.recording import (
    RecordedFrame,
    Recording,
    SceneRecorder,
    states,
    traced,
)
from haptic_tracing.core.formats.tracks.track_recorder import TrackRecorder
from haptic_tracing.core.scene.device_mapping import ActuatorMapping, DeviceMapping
from haptic_tracing.core.scene.functions import Exponential, HapticTracing
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
    SourceKind,
)
from haptic_tracing.core.signals import Noise
from haptic_tracing.core.tracer import Frame, Tracer

RATE = 24.0
FRAMES = range(1, 61)


def record(recorder, result, objects):
    recorder.add(
        result.number, objects, result.sources, result.listeners, result.contacts, result.objects
    )


def recorded_tracks(results):
    recorder = TrackRecorder()
    for result in results:
        recorder.add(result)
    return recorder.tracks()


def crate_pose(number, time):
    """Falls, bounces once and stays."""
    fall = 0.45 + 0.1 * number
    since = time - fall
    height = (
        0.5 * 9.81 * (fall**2 - time**2)
        if since < 0
        else 0.4 * abs(math.sin(4 * since)) * (since < 0.7)
    )
    return Pose(
        (2.0 * number, 0.0, 0.25 + height), (math.cos(time / 2), 0.0, 0.0, math.sin(time / 2))
    )


def first_run():
    """The tracer detects contacts and impacts of crates on a ground; a recorder takes down what it
    finds."""
    ground = HapticObject(
        "ground", 0.2, 0.9, shape=Box((40, 40, 1)), pose=Pose((0, 0, -0.5)), mass=None
    )
    crates = [
        HapticObject(f"crate.{k}", 0.3, 0.8, shape=Box((0.5, 0.5, 0.5)), mass=20.0)
        for k in range(3)
    ]
    bodies = (
        Body("ground", ground.shape, None, Motion.STATIC),
        *(Body(c.name, c.shape, c.mass) for c in crates),
    )
    tracer = Tracer()
    recorder = SceneRecorder(RATE, FRAMES[0])
    results = []
    for number in FRAMES:
        time = (number - FRAMES[0]) / RATE
        function = Exponential(alpha=0.01 * number) if number > 25 else HapticTracing()
        moved = [
            ground,
            *(
                replace(crate, pose=crate_pose(k, time), propagation=function)
                for k, crate in enumerate(crates)
            ),
        ]
        source = Source(
            "hammer",
            "ground",
            (5.0, 1.0, 0.0),
            amplitude=0.25 + 0.5 * (number > 30),
            signal=Noise(),
        )
        seat = Listener(
            "seat",
            "ground",
            (-1.0, 0.01 * number, 0.0),
            "upper_leg.L",
            gain=0.5 + 0.01 * number,
            radius=0.0,
        )
        listeners = (seat, Listener("lid", "crate.1", moved[2].pose.position, radius=0.0))
        transforms = np.array([pose_matrix(item.pose) for item in moved])
        results.append(
            tracer.step(
                Frame(
                    number,
                    time,
                    tuple(moved),
                    (source,),
                    listeners,
                    bodies=bodies,
                    transforms=transforms,
                )
            )
        )
        record(recorder, results[-1], moved)
    return results, recorder


@pytest.fixture(scope="module")
def run():
    return first_run()


def test_tracing_the_file_gives_the_gains_and_samples_of_the_first_run(run, tmp_path):
    results, recorder = run
    assert sum(len(result.impacts) for result in results) >= 3
    write_export(
        Export("fall", recorder.scene(), recording=recorder.recording()), tmp_path / "fall.json.gz"
    )
    export = read_export(tmp_path / "fall.json.gz")
    again = list(traced(export.scene, export.recording))
    assert [result.number for result in again] == list(FRAMES)
    for first, second in zip(results, again, strict=True):
        assert [source.name for source in first.sources] == [
            source.name for source in second.sources
        ]
        np.testing.assert_allclose(second.amplitudes, first.amplitudes, rtol=1e-5, atol=1e-9)
    first, second = recorded_tracks(results), recorded_tracks(again)
    assert first.start == second.start and first.count == second.count == round(
        (len(FRAMES) - 1) / RATE * 8000
    )
    np.testing.assert_allclose(second.samples, first.samples, atol=1e-5)
    for one, other in zip(first.listeners, second.listeners, strict=True):
        assert len(one.impacts) >= 2
        np.testing.assert_allclose(other.impacts, one.impacts, atol=1e-5)


def test_the_samples_of_a_take_are_those_of_the_frames(run):
    results, _ = run
    tracks = recorded_tracks(results)
    expected = np.concatenate(
        [result.block for result in results if result.block is not None], axis=1
    )
    np.testing.assert_array_equal(tracks.samples, expected.astype(np.float32))
    with pytest.raises(ValueError, match="does not follow"):
        recorded_tracks([*results[:5], *results[8:]])


@pytest.mark.parametrize("tracks", ["none", "inline", "wav"])
@pytest.mark.parametrize("encoding", ["pcm16", "float32"])
def test_export_import_export_is_identical(run, tmp_path, tracks, encoding):
    results, recorder = run
    devices = (
        DeviceMapping(
            "pad", "dualsense", (ActuatorMapping("left grip", "seat", 0.5),), {"note": "mine"}
        ),
    )
    export = Export(
        "fall", recorder.scene(), recorded_tracks(results), recorder.recording(), devices
    )
    first = write_export(export, tmp_path / "fall.json", tracks=tracks, encoding=encoding)
    imported = read_export(tmp_path / "fall.json")
    assert (
        imported.devices == devices
        and imported.recording == export.recording
        and imported.scene == export.scene
    )
    (tmp_path / "again").mkdir()
    second = write_export(
        imported, tmp_path / "again" / "fall.json", tracks=tracks, encoding=encoding
    )
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    if tracks != "none":
        np.testing.assert_allclose(
            imported.tracks.samples,
            export.tracks.samples,
            atol=2**-15 if encoding == "pcm16" else 0,
        )


@pytest.mark.slow
def test_a_thousand_objects_over_3600_frames_stay_under_50_mb(tmp_path):
    """A hundred objects on the move at any time, a fifth of them rolling on the ground."""
    names = [f"crate.{k:03d}" for k in range(999)]
    random = np.random.default_rng(0)
    objects = (
        HapticObject("ground", 0.2, 0.9),
        *(HapticObject(n, 0.3, 0.8, pose=Pose()) for n in names),
    )

    def frames():
        for number in range(1, 3601):
            moving = [names[(number // 36 * 100 + k) % 999] for k in range(100)]
            rows = np.round(random.normal(0, 1, (100, 7)) * ([10] * 3 + [0.5] * 4), 5).tolist()
            place = np.round(random.normal(0, 10, (20, 3)), 6).tolist()
            yield RecordedFrame(
                number,
                poses={name: tuple(row) for name, row in zip(moving, rows, strict=True)},
                contacts=tuple(
                    Contact(("ground", name), (tuple(p), tuple(p)), area=0.012346, depth=0.000124)
                    for name, p in zip(moving[:20], place, strict=True)
                ),
            )

    path = tmp_path / "many.json.gz"
    write_export(
        Export("many", HapticScene(objects), recording=Recording(24, 1, tuple(frames()))), path
    )
    packed, size = path.stat().st_size, len(gzip.decompress(path.read_bytes()))
    print(
        f"\n3,600 frames, 1,000 objects, 100 of them moving at any time: {size / 1e6:.1f} MB, "
        f"packed {packed / 1e6:.1f} MB"
    )
    assert size < 50e6 and packed < size / 2


def small():
    """A document with everything in it."""
    crate = HapticObject("crate", 0.3, 0.8, pose=Pose((0, 0, 1)))
    scene = HapticScene(
        (HapticObject("ground", 0.2, 0.9), crate),
        sources=(Source("hammer", "ground"),),
        listeners=(Listener("seat", "crate", radius=0.0),),
    )
    touch = Contact(("ground", "crate"), ((0, 0, 0), (0, 0, 0)))
    impact = Source(
        "impact", "crate", kind=SourceKind.TEMPORARY, second_object="ground", onset=0.05
    )
    frames = (
        RecordedFrame(1),
        RecordedFrame(
            2, poses={"crate": (0, 0, 0, 1, 0, 0, 0)}, contacts=(touch,), sources=(impact,)
        ),
        RecordedFrame(
            5,
            parted=(("crate", "ground"),),
            amplitudes={"hammer": 0.5},
            listener_positions={"seat": (1, 2, 3)},
        ),
    )
    pad = DeviceMapping("pad", "xbox", (ActuatorMapping("left", "seat"),))
    return Export("small", scene, recording=Recording(24, 1, frames), devices=(pad,))


def test_missing_frames_change_nothing_and_impacts_end_by_themselves():
    export = small()
    seen = dict(states(export.scene, export.recording))
    assert list(seen) == [1, 2, 3, 4, 5]
    assert [len(seen[n].contacts) for n in seen] == [0, 1, 1, 1, 0]
    assert (
        seen[4].objects[1].pose == Pose()
        and seen[5].sources[0].amplitude == 0.5
        and seen[5].listeners[0].position == (1, 2, 3)
    )
    later = Recording(24, 1, (*export.recording.frames, RecordedFrame(60)))
    assert [source.name for source in list(states(export.scene, later))[-1][1].sources] == [
        "hammer"
    ]


def test_objects_and_listeners_that_come_and_go(tmp_path):
    """A crate with a drill and a hand on it stands on the ground in some frames; the hand lets go
    in others."""
    ground = HapticObject(
        "ground", 0.2, 0.9, shape=Box((4, 4, 1)), pose=Pose((0, 0, -0.5)), mass=None
    )
    crate = HapticObject(
        "crate", 0.3, 0.8, shape=Box((1, 1, 1)), pose=Pose((0.0, 0.0, 0.5)), mass=2.0
    )
    bodies = (Body("ground", ground.shape, None, Motion.STATIC), Body("crate", crate.shape, 2.0))
    tracer, recorder, expected = Tracer(), SceneRecorder(RATE, 1), []
    for number in range(1, 13):
        count = 2 if number in (3, 4, 5, 9, 10, 11) else 1
        objects = (ground, replace(crate, kappa=0.3 + 0.01 * number))[:count]
        sources = (
            Source("motor", "ground", (1, 1, 0)),
            Source("drill", "crate", (0, 0, 1), amplitude=0.7),
        )[:count]
        listeners = (Listener("foot", "ground", (-1, 0, 0), radius=0.0),) * (number != 7) + (
            Listener("hand", "crate", (0.5, 0, 1), radius=0.0),
        ) * (count == 2)
        transforms = np.array([pose_matrix(item.pose) for item in objects])
        frame = Frame(
            number,
            (number - 1) / RATE,
            objects,
            sources,
            listeners,
            bodies=bodies[:count],
            transforms=transforms,
        )
        expected.append(tracer.step(frame))
        record(recorder, expected[-1], objects)
    write_export(
        Export("crate", recorder.scene(), recording=recorder.recording()), tmp_path / "crate.json"
    )
    export = read_export(tmp_path / "crate.json")
    assert export.recording == recorder.recording() and [
        item.name for item in export.scene.objects
    ] == ["ground"]
    for ours, theirs in zip(expected, traced(export.scene, export.recording), strict=True):
        assert theirs.objects == ours.objects
        assert [item.name for item in theirs.listeners] == [item.name for item in ours.listeners]
        heard = dict(
            zip((item.name for item in theirs.sources), theirs.amplitudes.tolist(), strict=True)
        )
        for source, row in zip(ours.sources, ours.amplitudes.tolist(), strict=True):
            assert heard.pop(source.name) == pytest.approx(row, rel=1e-12)
        assert not heard  # nothing is left of what was on the crate


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        ({"removed_objects": ["moon"]}, "/frames/2/removed_objects/0: there is no object 'moon'"),
        (
            {"removed_listeners": ["ear"]},
            "/frames/2/removed_listeners/0: there is no listener 'ear'",
        ),
        (
            {"removed_objects": ["crate"], "gains": {"seat": 1}},
            "/frames/2/gains/seat: there is no listener 'seat'",
        ),
        (
            {"removed_objects": ["ground"], "amplitudes": {"hammer": 1}},
            "/frames/2/amplitudes/hammer: there is no source 'hammer'",
        ),
        (
            {"removed_objects": ["crate"], "poses": {"crate": [0, 0, 0, 1, 0, 0, 0]}},
            "/frames/2/poses/crate: there is no object 'crate'",
        ),
        (
            {"objects": [{"name": "crate", "kappa": 0, "rho": 1}]},
            "/frames/2/objects/0/name: there is an object 'crate' already",
        ),
        (
            {"listeners": [{"name": "ear", "object": "moon", "position": [0, 0, 0], "radius": 0}]},
            "/frames/2/listeners/0/object: there is no object 'moon'",
        ),
    ],
)
def test_what_comes_and_goes_wrongly_is_named_with_its_place(tmp_path, frame, expected):
    write_export(small(), tmp_path / "small.json")
    document = json.loads((tmp_path / "small.json").read_text("utf-8"))
    document["frames"] = [*document["frames"][:2], {"frame": 4, **frame}]
    (tmp_path / "broken.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(FormatError) as caught:
        read_export(tmp_path / "broken.json")
    assert str(caught.value).startswith(f"{tmp_path / 'broken.json'}: {expected}")


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (("frames", 1, "frame"), 1, "/frames/1/frame: must come after 1"),
        (("frames", 1, "frame"), 1.5, "/frames/1/frame: must be an integer, got 1.5"),
        (
            ("frames", 1, "poses"),
            {"crate": [0] * 6},
            "/frames/1/poses/crate: must have at least 7 items, has 6",
        ),
        (
            ("frames", 1, "poses"),
            {"crate": [0] * 7},
            "/frames/1/poses/crate/rotation: a quaternion of length 0 is no rotation",
        ),
        (
            ("frames", 1, "poses"),
            {"a/b": [0, 0, 0, 1, 0, 0, 0]},
            "/frames/1/poses/a~1b: there is no object 'a/b'",
        ),
        (
            ("frames", 1, "contacts", 0, "objects"),
            ["ground", "moon"],
            "/frames/1/contacts/0/objects/1: there is no object 'moon'",
        ),
        (
            ("frames", 1, "contacts", 0, "objects"),
            ["crate", "crate"],
            "/frames/1/contacts/0/objects: 'crate' can't touch itself",
        ),
        (
            ("frames", 1, "sources", 0, "name"),
            "hammer",
            "/frames/1/sources/0/name: there is a source 'hammer' already",
        ),
        (
            ("frames", 1, "sources", 0, "second_object"),
            "moon",
            "/frames/1/sources/0/second_object: there is no object 'moon'",
        ),
        (
            ("frames", 2, "parted"),
            [["ground", "crate"], ["crate", "ground"]],
            "/frames/2/parted/1: 'crate' and 'ground' did not touch",
        ),
        (
            ("frames", 2, "amplitudes"),
            {"drum": 1},
            "/frames/2/amplitudes/drum: there is no source 'drum'",
        ),
        (
            ("frames", 2, "amplitudes"),
            {"hammer": 2},
            "/frames/2/amplitudes/hammer: must be at most 1, got 2",
        ),
        (
            ("frames", 2, "listener_positions"),
            {"ear": [0, 0, 0]},
            "/frames/2/listener_positions/ear: there is no listener 'ear'",
        ),
        (("frames", 2, "extra"), 1, "/frames/2/extra: unknown key"),
        (("frame_rate",), 0, "/frame_rate: must be more than 0, got 0"),
        (("frame_rate",), None, "/frame_rate: must be a number, got null"),
        (
            ("devices", 0, "actuators", 0, "listener"),
            "ear",
            "/devices/0/actuators/0/listener: there is no listener 'ear'",
        ),
        (
            ("tracks",),
            {"sample_rate": 8000, "listeners": [{"name": "seat"}]},
            "/tracks/encoding: is required",
        ),
        (
            ("tracks",),
            {"sample_rate": 8000, "file": "../a.wav", "listeners": [{"name": "s"}]},
            "/tracks/file: '../a.wav' is not the name",
        ),
        (
            ("tracks",),
            {"sample_rate": 8000, "file": "C:a.wav", "listeners": [{"name": "s"}]},
            "/tracks/file: 'C:a.wav' is not the name",
        ),
        (
            ("tracks",),
            {"sample_rate": 8000, "file": "gone.wav", "listeners": [{"name": "s"}]},
            "/tracks/file: gone.wav: No such file",
        ),
        (
            ("tracks",),
            {
                "sample_rate": 8000,
                "encoding": "pcm16",
                "listeners": [{"name": "s", "samples": "AAA"}],
            },
            "/tracks/listeners/0/samples: is not base64",
        ),
        (
            ("tracks",),
            {
                "sample_rate": 8000,
                "encoding": "float32",
                "listeners": [{"name": "s", "samples": "AADAfw=="}],
            },
            "/tracks: samples: must be finite",
        ),
        (
            ("tracks",),
            {
                "sample_rate": 8000,
                "encoding": "pcm16",
                "listeners": [{"name": "s", "samples": "AAA=", "impacts": [[2, 0], [1, 0]]}],
            },
            "/tracks/listeners/0/impacts: times must ascend",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_place(tmp_path, path, value, expected):
    write_export(small(), tmp_path / "small.json")
    document = json.loads((tmp_path / "small.json").read_text("utf-8"))
    broken = copy.deepcopy(document)
    parent = broken
    for key in path[:-1]:
        parent = parent[key]
    parent[path[-1]] = value
    (tmp_path / "broken.json").write_text(json.dumps(broken), "utf-8")
    with pytest.raises(FormatError) as caught:
        read_export(tmp_path / "broken.json")
    assert str(caught.value).startswith(f"{tmp_path / 'broken.json'}: {expected}")


def test_a_packed_file_is_the_same_text(tmp_path):
    write_export(small(), tmp_path / "a.json")
    write_export(small(), tmp_path / "a.json.gz")
    assert (
        gzip.decompress((tmp_path / "a.json.gz").read_bytes()) == (tmp_path / "a.json").read_bytes()
    )
