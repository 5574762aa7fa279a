"""What an importer reads back against what was written, by ST-SIM (vibromaf), and against an
evaluation of the files of our own.

ST-SIM compares blocks of 512 samples; it has no value where the source is silent, so that only
blocks in which it sounds are compared.
"""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.io.catalogue import named
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticObject, HapticScene
from haptic_tracing.plugins.keyframes.carrier import rendered
from vibromaf.metrics.stsim import st_sim

BLOCK = 512
SILENCE = 2e-4
SCENE = HapticScene(objects=(HapticObject("ground", 0.2, 0.9),))


def similarity(source, again):
    """ST-SIM over the blocks in which the source sounds."""
    count = len(source) // BLOCK * BLOCK
    again = np.pad(again, (0, max(count - len(again), 0)))[:count].reshape(-1, BLOCK)
    source = source[:count].reshape(-1, BLOCK)
    sounds = np.abs(source).max(axis=1) > SILENCE
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return st_sim(again[sounds].ravel(), source[sounds].ravel())


WAVES = {".wav", ".hjif", ".haptic", ".haps", ".ahap"}
"""What has a channel for each listener when it is read back."""
OPTIONS = {
    "scene": {"tracks": "inline"},
    "haptic": {"points": 0, "frequency_min": 5.0, "frequency_max": 500.0},
}  # 0: breakpoints follow the wave, which ST-SIM compares, as far as the range lets them


def read_back(files, suffix):
    """The channels of the files that can be imported, in the order of writing."""
    paths = [
        path for path in files if path.name.endswith(suffix) and ".transients." not in path.name
    ]
    return (
        [channel for path in paths for channel in registry.read(path).channels]
        if suffix in WAVES
        else []
    )


@pytest.mark.slow
def test_the_study_scene_comes_back_as_it_was(study, tmp_path):
    rows = []
    for name in catalogue.formats():
        written = registry.write(
            name, Export("study", SCENE, study), tmp_path, OPTIONS.get(name, {})
        )
        again = (
            list(read_export(written.files[0]).tracks.samples)
            if name == "scene"
            else [channel.at_rate(8000) for channel in read_back(written.files, named(name).suffix)]
        )
        scores = [
            similarity(source, samples)
            for source, samples in zip(study.samples, again, strict=bool(again))
        ]
        size = sum(path.stat().st_size for path in written.files)
        rows.append((name, len(written.files), size, scores))
    print("\nformat   files       bytes  ST-SIM mean    min")
    for name, files, size, scores in rows:
        values = f"{np.mean(scores):10.3f} {min(scores):6.3f}" if scores else "         -      -"
        print(f"{name:8} {files:5} {size:11,} {values}")
    scores = {name: min(scores) for name, _, _, scores in rows if scores}
    for name in ("scene", "wav", "hjif", "haptic"):
        assert scores[name] >= 0.95, name


TIME = np.arange(4 * 8000) / 8000
SIGNALS = {
    "tone": 0.5 * np.sin(2 * np.pi * 60 * TIME),
    "tone between whole hertz": 0.5 * np.sin(2 * np.pi * 60.37 * TIME),
    "sweep": 0.5 * np.sin(2 * np.pi * (30 * TIME + 20 * TIME**2)),
    "beating tones": 0.3 * np.sin(2 * np.pi * 60 * TIME) + 0.3 * np.sin(2 * np.pi * 183 * TIME),
    "swell": 0.8 * np.sin(2 * np.pi * 80 * TIME) * np.sin(np.pi * TIME / 4) ** 2,
    "bursts": 0.6 * np.sin(2 * np.pi * 120 * TIME) * (TIME % 0.5 < 0.1),
}


@pytest.mark.parametrize("name", SIGNALS)
def test_signals_in_hjif(tmp_path, name):
    tracks = Tracks((ListenerTrack("hand", "hand.L"),), 8000, SIGNALS[name][None])
    (path,) = registry.write("hjif", Export("one", SCENE, tracks), tmp_path).files
    (channel,) = registry.read(path).channels
    assert channel.body_part == "hand.L" and abs(channel.duration - 4) < 0.02
    assert similarity(SIGNALS[name], channel.at_rate(8000)) > 0.95


@pytest.mark.parametrize("beside", [0.0, 0.05])
@pytest.mark.parametrize(("hertz", "decay"), [(60, 0.1), (80, 0.015), (150, 0.03), (300, 0.008)])
def test_emphases_add_to_the_similarity_of_the_envelope(tmp_path, hertz, decay, beside):
    """Five rebounds in `.haptic`. Players begin the envelope in a phase of their own, which ST-SIM
    compares: in the mean over phases, that of both is higher than that of the envelope alone.
    Their amplitude is that of the energy: ST-SIM does not determine it. With ``points`` 0 the
    envelope follows the wave."""
    blows = ((0.5, 0.9), (1.1, 0.5), (1.4, 0.25), (1.55, 0.12), (1.63, 0.06))
    samples = beside * np.sin(2 * np.pi * 60 * TIME)
    for time, strength in blows:
        since = np.maximum(TIME - time, 0)
        samples += strength * np.exp(-since / decay) * np.sin(2 * np.pi * hertz * since)
    tracks = Tracks((ListenerTrack("hand", "hand.L", np.array(blows)),), 8000, samples[None])
    export = Export("one", SCENE, tracks)
    (channel,) = registry.read(registry.write("haptic", export, tmp_path).files[0]).channels
    envelope, *emphases = channel.carriers
    assert len({emphasis.start for emphasis in emphases}) == len(blows)
    added = rendered(tuple(emphases), 0, len(TIME), 8000)
    scores = []
    for phase in np.arange(12) * np.pi / 6:
        alone = rendered((replace(envelope, phase=phase),), 0, len(TIME), 8000)
        scores.append([np.real(similarity(samples, wave)) for wave in (alone + added, alone)])
    assert np.greater(*np.mean(scores, axis=0))
    (channel,) = registry.read(
        registry.write("haptic", export, tmp_path, OPTIONS["haptic"]).files[0]
    ).channels
    assert similarity(samples, channel.at_rate(8000)) > 0.75


@pytest.mark.parametrize(
    ("samples", "most"),
    [(SIGNALS["tone"], 60), (0.5 * ((np.arange(20 * 8000) / 320) % 1.0 < 0.1), 1500)],
)
def test_what_is_steady_takes_few_keyframes(tmp_path, samples, most):
    """A tone, and a jackhammer of 25 blows a second for 20 seconds."""
    tracks = Tracks((ListenerTrack("hand", "hand.L"),), 8000, samples[None])
    (path,) = registry.write("hjif", Export("one", SCENE, tracks), tmp_path).files
    bands = json.loads(path.read_bytes())["perceptions"][0]["channels"][0]["bands"]
    assert sum(len(effect["keyframes"]) for band in bands for effect in band["effects"]) < most
    assert similarity(samples, registry.read(path).channels[0].at_rate(8000)) > 0.95


def evaluated(document, count):
    """The first channel of an HJIF document by adding up phase, sample after sample."""
    samples = np.zeros(count)
    for band in document["perceptions"][0]["channels"][0]["bands"]:
        for effect in band["effects"]:
            keys = effect["keyframes"]
            if band["band_type"] == "Transient":
                since = np.arange(count) / 8000 - effect["position"] / 1000
                burst = np.sin(4 * np.pi * since / 0.022) * keys[0]["amplitude_modulation"]
                samples += np.where((since >= 0) & (since < 0.022), burst, 0.0)
                continue
            first, last = (8 * (effect["position"] + keys[k]["relative_position"]) for k in (0, -1))
            # Sixteen steps a sample, each with the frequency in its middle.
            fine = (np.arange((last - first) * 16) + 0.5) / 16 / 8
            known = [
                [k["relative_position"], k["frequency_modulation"]]
                for k in keys
                if "frequency_modulation" in k
            ]
            levels = [
                [k["relative_position"], k["amplitude_modulation"]]
                for k in keys
                if "amplitude_modulation" in k
            ]
            phase = (
                effect["phase"]
                + np.concatenate(
                    [[0], np.cumsum(np.interp(fine, *np.array(known).T)) * 2 * np.pi / 8000 / 16]
                )[:-1:16]
            )
            wave = np.interp(np.arange(last - first) / 8, *np.array(levels).T) * np.sin(phase)
            samples[first : min(last, count)] += wave[: max(count - first, 0)]
    return samples


def test_reading_hjif_against_adding_up_the_phase(tmp_path):
    samples = SIGNALS["sweep"] * 0.5 + SIGNALS["bursts"] * 0.3
    tracks = Tracks(
        (ListenerTrack("hand", "hand.L", np.array([[1.0, 0.3], [2.0, 0.3]])),), 8000, samples[None]
    )
    (path,) = registry.write("hjif", Export("one", SCENE, tracks), tmp_path).files
    (channel,) = registry.read(path).channels
    expected = evaluated(json.loads(path.read_bytes()), len(TIME))
    np.testing.assert_allclose(channel.at_rate(8000)[: len(TIME)], expected, atol=2e-3)


@pytest.mark.parametrize("form", ["hjif", "haptic", "wyvrn", "ahap", "wav"])
@pytest.mark.parametrize("name", ["tone", "swell", "bursts"])
def test_a_template_plays_what_was_read(tmp_path, form, name):
    tracks = Tracks((ListenerTrack("hand", "hand.L"),), 8000, SIGNALS[name][None])
    written = registry.write(form, Export("one", SCENE, tracks), tmp_path)
    (channel,) = read_back(written.files, named(form).suffix)
    expected = channel.at_rate(8000)
    played = channel.to_signal().sample(0, len(expected), 8000.0)
    np.testing.assert_allclose(
        played, expected, atol=1e-6 if len(getattr(channel, "carriers", ())) <= 100 else 0.02
    )
