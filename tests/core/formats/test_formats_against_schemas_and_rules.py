"""Every written file against its schema, by `jsonschema`, and the rules that schemas can't say."""

import importlib.util
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.body import BODY_PART, BODY_PARTS
from haptic_tracing.core.scene.values import HapticObject, HapticScene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

spec = importlib.util.spec_from_file_location(
    "format_rules", Path(__file__).with_name("format_rules.py")
)
rules = importlib.util.module_from_spec(spec)
sys.modules["format_rules"] = rules
spec.loader.exec_module(rules)

FORMATS = [name for name in catalogue.formats() if name != "scene"]
SCENE = HapticScene(objects=(HapticObject("ground", 0.2, 0.9),))


def write_all(tracks, folder, formats=FORMATS):
    export = Export("scene", SCENE, tracks, date="2026-01-02")
    return {form: registry.write(form, export, folder) for form in formats}


@pytest.fixture(scope="module")
def written_study(study, tmp_path_factory):
    """The study written in every format: the folder, and the result of writing by format."""
    folder = tmp_path_factory.mktemp("study")
    return folder, write_all(study, folder)


@pytest.mark.slow
def test_the_study_in_every_format(study, written_study):
    folder, written = written_study
    for result in written.values():
        for path in result.files:
            rules.check_file(path, study)
        assert result.losses and all(loss.isprintable() for loss in result.losses)
    files = {path for result in written.values() for path in result.files}
    assert {path for path in folder.rglob("*") if path.is_file()} == files


@pytest.mark.slow
def test_two_writings_are_the_same_bytes(study, written_study, tmp_path):
    folder, _ = written_study
    write_all(study, tmp_path)
    for path in folder.rglob("*"):
        if path.is_file():
            assert path.read_bytes() == (tmp_path / path.relative_to(folder)).read_bytes(), (
                path.name
            )


@st.composite
def generated_tracks(draw):
    """One to many listeners, silence, noise, tones and clipping, with impacts in any place."""
    count = draw(st.one_of(st.sampled_from([1, 2, 4]), st.integers(1, 24)))
    seconds = draw(st.sampled_from([0.001, 0.02] if count > 4 else [0.001, 0.02, 0.3, 0.7]))
    rate = draw(st.sampled_from([1000, 8000, 11025]))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    time = np.arange(max(round(seconds * rate), 1)) / rate
    kinds = {
        "silence": lambda: np.zeros(len(time)),
        "tone": lambda: (
            random.uniform(0, 1)
            * np.sin(2 * np.pi * random.uniform(10, 400) * time + random.uniform(0, 6))
        ),
        "noise": lambda: random.uniform(0, 0.3) * random.standard_normal(len(time)),
        "clipping": lambda: 3 * np.sin(2 * np.pi * 50 * time),
        "constant": lambda: np.full(len(time), 0.5),
        "spike": lambda: (np.arange(len(time)) == len(time) // 2).astype(np.float64),
    }
    samples = np.array([kinds[draw(st.sampled_from(sorted(kinds)))]() for _ in range(count)])
    parts = ["", *[part.name for part in BODY_PARTS]]
    impacts = draw(
        st.one_of(st.sampled_from([0, 1, 10]), st.integers(0, 100 if count > 4 else 10_000))
    )
    listeners = tuple(
        ListenerTrack(
            f"listener {number}",
            parts[number % len(parts)],
            np.column_stack(
                [np.sort(random.uniform(0, time[-1], impacts)), random.uniform(0, 1, impacts)]
            ),
        )
        for number in range(count)
    )
    return Tracks(listeners, rate, samples, start=draw(st.sampled_from([0.0, -3.5, 10.0])))


@pytest.mark.slow
@settings(
    max_examples=10,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(generated_tracks())
@pytest.mark.plugins
def test_generated_tracks_in_every_format(tmp_path_factory, tracks):
    from haptic_tracing.plugins.bhaptics.motors import DEVICES

    folder = tmp_path_factory.mktemp("generated")
    positions = {position for layout in DEVICES.values() for position in layout}
    worn = any(
        BODY_PART[item.body_part].bhaptics in positions
        for item in tracks.listeners
        if item.body_part in BODY_PART
    )
    if not worn:
        with pytest.raises(ValueError, match="give one such a body part"):
            write_all(tracks, folder, ["tact"])
    for result in write_all(
        tracks, folder, [name for name in FORMATS if worn or name != "tact"]
    ).values():
        for path in result.files:
            rules.check_file(path, tracks)
            if path.suffix in catalogue.readers() and ".transients" not in path.name:
                for channel in registry.read(path).channels:
                    assert np.isfinite(channel.at_rate(tracks.sample_rate)).all()


@pytest.mark.slow
@pytest.mark.parametrize(("count", "formats"), [(1, FORMATS), (127, ["hjif"]), (128, FORMATS)])
@pytest.mark.plugins
def test_many_listeners(tmp_path, count, formats):
    """One, and more than an hjif file of level 1 may have, 127: the only limit on their number that
    a format knows."""
    time = np.arange(400) / 8000
    listeners = tuple(
        ListenerTrack(f"listener {number}", BODY_PARTS[number % 25].name) for number in range(count)
    )
    tracks = Tracks(listeners, 8000, np.sin(2 * np.pi * (40 + np.arange(count))[:, None] * time))
    for result in write_all(tracks, tmp_path, formats).values():
        for path in result.files:
            rules.check_file(path, tracks)


@pytest.mark.slow
@pytest.mark.plugins
def test_ten_minutes_and_two_thousand_impacts(tmp_path):
    rate = 1000
    time = np.arange(600 * rate) / rate
    impacts = np.column_stack([np.arange(2000) * 0.295 + 0.5, np.full(2000, 0.4)])
    samples = np.array([0.3 * np.sin(2 * np.pi * 60 * time), np.zeros(len(time))], dtype=np.float32)
    ring = np.exp(-np.arange(200) / 30) * np.sin(2 * np.pi * 0.15 * np.arange(200)) * 0.4
    for first in np.rint(impacts[:, 0] * rate).astype(int):
        samples[0, first : first + 200] += ring[: len(time) - first]
    tracks = Tracks(
        (ListenerTrack("hand", "hand.L", impacts), ListenerTrack("ear", "ear.L")), rate, samples
    )
    for result in write_all(tracks, tmp_path).values():
        for path in result.files:
            rules.check_file(path, tracks)
    document = json.loads((tmp_path / "scene.hjif").read_bytes())
    waves = document["perceptions"][0]["channels"][0]["bands"]
    assert max(effect["position"] for band in waves for effect in band["effects"]) > 500_000
    assert [len(band["effects"]) for band in waves if band["band_type"] == "Transient"] == [2000]
    again = registry.read(tmp_path / "scene.hjif").channels[0].at_rate(rate)
    part = slice(120_000, 180_000)
    assert np.mean((again[part] - samples[0, part]) ** 2) < 0.05 * np.mean(samples[0, part] ** 2)


@pytest.mark.slow
@pytest.mark.plugins
def test_options_of_formats(study, tmp_path):
    export = Export("scene", SCENE, study)
    registry.write("hjif", export, tmp_path, {"profile": "Simple Parametric", "transients": False})
    document = json.loads((tmp_path / "scene.hjif").read_bytes())
    assert document["profile"] == "Simple Parametric" and document["timescale"] == 1000
    assert {
        band["band_type"] for c in document["perceptions"][0]["channels"] for band in c["bands"]
    } == {"VectorialWave"}
    registry.write("wav", export, tmp_path, {"encoding": "float32", "sample_rate": 2000})
    half = Tracks(study.listeners, 2000, study.samples[:, ::4])
    rules.check_wav((tmp_path / "scene.wav").read_bytes(), 10, half.count, 2000)
    for chosen, message in [
        (
            {"profile": "Baseline"},
            "profile: must be one of Main, Simple Parametric, got 'Baseline'",
        ),
        ({"error": 2.0}, "error: must be from 0.001 to 0.5, got 2.0"),
        ({"error": float("nan")}, "error: must be from"),
        ({"transients": 1}, "transients: must be true or false, got 1"),
        ({"speed": 1}, "speed: unknown option; known are profile, error, transients"),
    ]:
        with pytest.raises(ValueError, match=re.escape(message)):
            registry.write("hjif", export, tmp_path, chosen)
    with pytest.raises(ValueError, match="frequency_max: must be above frequency_min"):
        registry.write("haptic", export, tmp_path, {"frequency_min": 300.0, "frequency_max": 200.0})


@pytest.mark.parametrize("name", FORMATS)
def test_without_a_listener_there_is_nothing_to_write(tmp_path, name):
    for export in (
        Export("scene", SCENE),
        Export("scene", SCENE, Tracks((), 8000, np.zeros((0, 10)))),
    ):
        with pytest.raises(ValueError, match="there is no listener"):
            registry.write(name, export, tmp_path)
        with pytest.raises(ValueError, match="there is no listener"):
            registry.losses(name, export)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.plugins
def test_losses_say_what_is_cut_and_who_is_nowhere():
    time = np.arange(800) / 8000
    tracks = Tracks(
        (ListenerTrack("tail"), ListenerTrack("hand", "hand.L")),
        8000,
        np.array([2 * np.sin(300 * time), 0 * time]),
    )
    export = Export("scene", SCENE, tracks)
    assert any(
        re.search(r"\d+ samples beyond full scale are cut", loss)
        for loss in registry.losses("wav", export)
    )
    assert not any(
        "full scale are cut" in loss
        for loss in registry.losses("wav", export, {"encoding": "float32"})
    )
    assert "the place of listeners on no known body part: tail" in registry.losses("hjif", export)
    assert any("tail" in loss for loss in registry.losses("tact", export))
    with pytest.raises(ValueError, match="format 'midi' is unknown"):
        registry.losses("midi", export)


def test_wav_reads_back_exactly_with_names_and_body_parts(study, tmp_path):
    registry.write("wav", Export("scene", SCENE, study), tmp_path, {"encoding": "float32"})
    channels = registry.read(tmp_path / "scene.wav").channels
    assert [(c.name, c.body_part) for c in channels] == [
        (track.name, track.body_part) for track in study.listeners
    ]
    np.testing.assert_array_equal([c.samples for c in channels], study.samples.astype(np.float32))
