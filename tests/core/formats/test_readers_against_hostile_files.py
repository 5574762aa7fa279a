"""Readers against what may come: broken, truncated and hostile files give one clear error, in
bounded time and memory."""

import copy
import gzip
import json
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from carriers import values_at
from haptic_tracing.core.formats import haptic_scene, registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import catalogue, strict_json
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Source
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from written_scenes import read_scene

JSON_SUFFIXES = {*catalogue.readers(), ".json"} - {".wav"}
LOOSE = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """A small good file of each kind that can be read."""
    folder = tmp_path_factory.mktemp("corpus")
    time = np.arange(1600) / 8000
    tracks = Tracks(
        (ListenerTrack("hand", "hand.L", [[0.05, 0.5]]),),
        8000,
        0.5 * np.sin(2 * np.pi * 80 * time)[None],
    )
    scene = HapticScene((HapticObject("ground", 0.2, 0.9),), sources=(Source("hammer", "ground"),))
    export = Export("small", scene, tracks)
    files = [
        path
        for name in catalogue.readers().values()
        for path in registry.write(name, export, folder).files
    ]
    good = {
        path.suffix: path
        for path in files
        if path.suffix in catalogue.readers() and ".transients" not in path.name
    }
    everything = haptic_scene.read_export(Path(__file__).parent / "corpus" / "good-devices.json")
    haptic_scene.write_export(
        replace(everything, tracks=tracks), folder / "small.scene.json", tracks="inline"
    )
    return {**good, ".json": folder / "small.scene.json"}


def read(path):
    return (
        haptic_scene.read_export(path)
        if path.name.endswith((".json", ".json.gz"))
        else registry.read(path)
    )


def outcome(path):
    """What reading gives, or the FormatError that it ends with."""
    try:
        return read(path), None
    except FormatError as error:
        return None, error


def is_fine(path, result, error):
    """Whether the error is one line that names the file and the reason, or what was read is made of
    finite numbers."""
    if error is not None:
        return (
            str(error).startswith(f"{path}: ") and str(error).isprintable() and bool(error.reason)
        )
    channels = getattr(result, "channels", ())
    return all(np.isfinite(channel.duration) for channel in channels) and all(
        np.isfinite(values_at(carrier, np.array([carrier.start]))).all()
        for channel in channels
        for carrier in getattr(channel, "carriers", ())
    )


def one_clear_error(path):
    """The text of the error, None where there is nothing wrong."""
    result, error = outcome(path)
    assert is_fine(path, result, error), error
    return None if error is None else str(error)


def test_the_corpus_itself_reads(corpus):
    assert set(corpus) == {*catalogue.readers(), ".json"}
    for path in corpus.values():
        assert one_clear_error(path) is None


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [*catalogue.readers(), ".json"])
@LOOSE
@given(data=st.data())
def test_damaged_bytes(corpus, tmp_path, suffix, data):
    good = corpus[suffix].read_bytes()
    place = data.draw(st.integers(0, len(good) - 1))
    match data.draw(st.sampled_from(["cut", "flip", "insert", "repeat"])):
        case "cut":
            bad = good[:place]
        case "flip":
            bad = (
                good[:place]
                + bytes([good[place] ^ data.draw(st.integers(1, 255))])
                + good[place + 1 :]
            )
        case "insert":
            bad = good[:place] + data.draw(st.binary(min_size=1, max_size=8)) + good[place:]
        case "repeat":
            bad = good[:place] + good[max(place - 20, 0) :]
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(bad)
    assert is_fine(path, *outcome(path))
    path.unlink()  # what is written over has to reach the disk first, what is removed never does


WORDS = ["", "x", "Reference", "Composite", "Curve", "Square"]
ODD = [*WORDS, None, True, -1, 0, 0.5, 1e9, -1e9, 1e308, 10**40, [], {}, [0], [[]], {"m_type": 0}]


def places(document, path=()):
    yield path
    items = (
        document.items()
        if isinstance(document, dict)
        else enumerate(document)
        if isinstance(document, list)
        else ()
    )
    for key, value in items:
        yield from places(value, (*path, key))


@pytest.mark.slow
@pytest.mark.parametrize("suffix", sorted(JSON_SUFFIXES))
@LOOSE
@given(data=st.data())
def test_damaged_values(corpus, tmp_path, suffix, data):
    document = json.loads(corpus[suffix].read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from([p for p in places(document) if p]))
        parent = document
        for key in path[:-1]:
            parent = parent[key]
        if data.draw(st.booleans()):
            parent[path[-1]] = copy.deepcopy(data.draw(st.sampled_from(ODD)))
        else:
            del parent[path[-1]]
        if not document:
            break
    file = tmp_path / f"bad{suffix}"
    file.write_text(json.dumps(document))
    assert is_fine(file, *outcome(file))
    file.unlink()


@pytest.mark.parametrize("suffix", sorted(JSON_SUFFIXES))
@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "the file is empty"),
        (b" \n\t", "the file is empty"),
        (b"\xff\xfe{}", "not UTF-8: byte 0 is 0xff"),
        (b"BLENDER17-01v0500", "a Blender file, no JSON: export its haptic scene"),
        (b"{", "not JSON: "),
        (b'{"a": 1,}', "not JSON: "),
        (b'{"a": 1} x', "not JSON: "),
        (b'{"a": NaN}', "/a: NaN is not a JSON number"),
        (b'{"a": [1, -Infinity]}', "/a/1: -Infinity is not a JSON number"),
        (b'{"b": {"a": 1, "a": 2}}', "/b: the key 'a' occurs twice"),
        (b'{"a": "\\ud800"}', "/a: '\\ud800' has an unpaired surrogate"),
        (b"[" * 100_000, "nested deeper than 100 levels at byte 100"),
        (b'{"a":' * 200 + b"1" + b"}" * 200, "nested deeper than 100 levels"),
        (b'{"a": ' + b"9" * 5000 + b"}", "a number has too many digits"),
    ],
)
def test_what_is_no_json_document_says_so(tmp_path, suffix, data, reason):
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(data)
    if suffix == ".ahap" and data == b'{"a": 1,}':
        reason = "/Pattern: "  # Apple's loader takes commas before closing brackets
    assert reason in one_clear_error(path)


def test_brackets_in_strings_are_text(tmp_path):
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": '\\"[[' + "[{" * 110 + "\\", "kappa": 0, "rho": 1}],
    }
    (tmp_path / "odd.json").write_text(json.dumps(document))
    assert read_scene(tmp_path / "odd.json").objects[0].name.startswith('\\"[[')


@pytest.mark.slow
def test_a_zip_bomb_is_not_unpacked(tmp_path):
    path = tmp_path / "bomb.json.gz"
    path.write_bytes(
        40 * gzip.compress(b" " * (16 << 20), compresslevel=9)
    )  # a gzip file may have several members
    assert path.stat().st_size < 1 << 20
    with pytest.raises(FormatError, match=r"bomb\.json\.gz: larger than 256 MiB"):
        read_scene(path)


@pytest.mark.parametrize(
    "data", [b"\x1f\x8b\x08", b"no gzip at all", gzip.compress(b"{}" * 5000, mtime=0)[:-20], b""]
)
def test_broken_gzip_files(tmp_path, data):
    path = tmp_path / "broken.json.gz"
    path.write_bytes(data)
    assert one_clear_error(path)


def test_billions_of_values_are_refused_before_they_are_made(tmp_path, monkeypatch):
    monkeypatch.setattr(strict_json, "MAX_VALUES", 1_000_000)
    path = tmp_path / "many.json"
    path.write_bytes(b'{"objects":[' + b"[]," * 1_000_000 + b"[]]}")
    tracemalloc.start()
    with pytest.raises(FormatError, match="more than 1000000 values"):
        haptic_scene.read_export(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100 << 20


@pytest.mark.plugins
def test_vibrations_that_last_for_ages_are_not_rendered(corpus, tmp_path):
    document = json.loads(corpus[".hjif"].read_bytes())
    document["perceptions"][0]["channels"][0]["bands"][0]["effects"][0]["position"] = 900_000_000
    path = tmp_path / "long.hjif"
    path.write_text(json.dumps(document))
    (channel,) = registry.read(path).channels
    with pytest.raises(ValueError, match="too long"):
        channel.at_rate(8000)


@pytest.mark.plugins
def test_a_file_of_countless_long_effects_is_not_rendered(corpus, tmp_path):
    document = json.loads(corpus[".hjif"].read_bytes())
    document["timescale"] = 100
    (effect,) = document["perceptions"][0]["channels"][0]["bands"][0]["effects"][:1]
    effect["keyframes"][-1]["relative_position"] = 65535
    document["perceptions"][0]["channels"][0]["bands"][0]["effects"] = [effect] * 1000
    path = tmp_path / "layers.hjif"
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match="too many at once"):
        registry.read(path).channels[0].at_rate(8000)


def wav(form=b"", data=b"\0\0" * 8, size=None):
    form = form or struct.pack("<HHIIHH", 1, 1, 8000, 16000, 2, 16)
    chunks = (
        b"WAVEfmt "
        + struct.pack("<I", len(form))
        + form
        + b"data"
        + struct.pack("<I", len(data) if size is None else size)
        + data
    )
    return b"RIFF" + struct.pack("<I", len(chunks)) + chunks


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"RIFF",
        wav()[:30],
        wav(data=b""),
        wav(form=struct.pack("<HHIIHH", 1, 0, 8000, 0, 0, 16)),
        wav(form=struct.pack("<HHIIHH", 1, 65535, 8000, 0, 2, 16)),
        wav(form=struct.pack("<HHIIHH", 85, 1, 8000, 16000, 2, 16)),
        wav(
            form=struct.pack("<HHIIHH", 3, 1, 8000, 32000, 4, 32),
            data=struct.pack("<f", float("nan")),
        ),
        wav().replace(b"fmt ", b"abcd"),
    ],
)
def test_broken_wav_files(tmp_path, data):
    path = tmp_path / "bad.wav"
    path.write_bytes(data)
    assert one_clear_error(path)


def test_a_wav_file_that_claims_more_than_it_has_is_taken_as_far_as_it_goes(tmp_path):
    path = tmp_path / "short.wav"
    path.write_bytes(wav(size=2**31))
    assert registry.read(path).channels[0].duration == 8 / 8000


def test_other_endings_and_missing_files(tmp_path):
    for name in ("a.mid", "a", "a.json.gz.exe"):
        (tmp_path / name).write_bytes(b"x")
        with pytest.raises(FormatError, match="the ending must be one of"):
            registry.read(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        registry.read(tmp_path / "gone.wav")
    with pytest.raises(OSError, match=r"is not a file|Permission"):
        (tmp_path / "folder.wav").mkdir()
        registry.read(tmp_path / "folder.wav")
