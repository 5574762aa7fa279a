"""What the samples are made of can be told from a blow: by a classifier that has heard other
energies and variations of the same materials.

For each material a scene file in which balls of it fall onto a slab of it, with the rule for
impacts that the samples have. Of each blow the classifier gets what the nearest listener feels,
from the WAV file: the share of energy in each octave and how long it lasts, not how strong it is.
It is the nearest neighbour among half of the energies; the other half is asked for.
"""

import json
from itertools import pairwise

import numpy as np
import pytest
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.scene.recording import traced
from haptic_tracing.core.formats.tracks.track_recorder import TrackRecorder
from haptic_tracing.core.formats.tracks.wav import write_wav
from haptic_tracing.core.scene.materials import Material
from haptic_tracing.core.signals import impact_material
from haptic_tracing.sample_scenes import SAMPLES, materials
from scipy import spatial
from scipy.io import wavfile

FRAME_RATE = 25
DROP, FALL = 3.0, (2 * 3.0 / 9.81) ** 0.5
"""Metres and seconds."""
APART = 0.44
"""Seconds from one blow to the next."""
ENERGIES = np.geomspace(8.0, 100.0, 8)
"""Joules."""
TIMES = 2
"""Blows of each energy."""
BANDS = np.array([20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 2000.0])
"""Edges in hertz."""
PLACES = [(0.3 * (k % 6) - 0.75, 0.3 * (k // 6) - 0.45) for k in range(len(ENERGIES) * TIMES)]
LISTENERS = {"near": (0.9, 0.6, 0.05), "far": (1.9, 1.9, 0.05)}


def substances():
    """The impact materials of everything in the samples."""
    known = {
        impact_material(item.name)
        for item in vars(materials).values()
        if isinstance(item, Material)
    }
    return sorted(name for name in known if name is not None)


def scene_document(material, rule):
    """Balls that fall onto a slab, one after the other, and stay there."""
    mass = 2 * ENERGIES / (9.81 * FALL) ** 2
    slab = {
        "name": "slab",
        "kappa": 0.1,
        "rho": 0.9,
        "motion": "static",
        "shape": {"type": "box", "size": [4, 4, 0.1]},
    }
    balls = [
        {"name": f"ball {k}", "kappa": 0.1, "rho": 0.9, "mass": float(mass[k % len(ENERGIES)]), "shape": {"type": "sphere", "radius": 0.1},
         "pose": {"position": [*PLACES[k], 0.15 + DROP]}}
        for k in range(len(PLACES))
    ]  # fmt: skip
    frames, known = [], {}
    for number in range(round((FALL + APART * (len(PLACES) + 1)) * FRAME_RATE)):
        fallen = number / FRAME_RATE - APART * np.arange(len(PLACES))
        heights = 0.15 + np.where(
            fallen < FALL, DROP - 9.81 / 2 * np.maximum(fallen, 0.0) ** 2, 0.0
        )
        poses = {
            f"ball {k}": [*PLACES[k], round(float(z), 5), 1, 0, 0, 0] for k, z in enumerate(heights)
        }
        frames.append(
            {
                "frame": number,
                "poses": {name: pose for name, pose in poses.items() if known.get(name) != pose},
            }
        )
        known = poses
    return {
        "format": "haptic-scene",
        "version": "1.1",
        "rules": {"templates": "by_material", "impact_table": [rule]},
        "objects": [{**item, "impact_material": material} for item in (slab, *balls)],
        "listeners": [
            {"name": name, "object": "slab", "position": place} for name, place in LISTENERS.items()
        ],
        "frame_rate": FRAME_RATE,
        "frames": frames,
    }


def blows(material, rule, folder):
    """What the nearest listener feels of each blow, from its beginning to the next one."""
    path = folder / f"{material}.json"
    path.write_text(json.dumps(scene_document(material, rule)))
    export, recorder, onsets = read_export(path), TrackRecorder(), {}
    for result in traced(export.scene, export.recording):
        recorder.add(result)
        onsets |= {source.name: source.onset for source in result.sources}
    write_wav(recorder.tracks(), folder / f"{material}.wav")
    rate, samples = wavfile.read(folder / f"{material}.wav")
    assert len(onsets) == len(PLACES)
    for (x, y), onset in zip(PLACES, sorted(onsets.values()), strict=True):
        near = min(
            range(len(LISTENERS)),
            key=lambda k: np.hypot(*(np.array(list(LISTENERS.values())[k][:2]) - (x, y))),
        )
        first = round(onset * rate) - round(recorder.tracks().start * rate)
        yield samples[first : first + round(APART * rate), near] / 32768.0, rate


def features(samples, rate):
    """Decibels of each band relative to the whole, and of the time after which a tenth of the
    energy is left, in steps as large."""
    spectrum = np.abs(np.fft.rfft(samples)) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / rate)
    shares = [
        spectrum[(low <= hertz) & (hertz < high)].sum() / spectrum.sum()
        for low, high in pairwise(BANDS)
    ]
    energy = np.cumsum(samples**2)
    lasts = np.searchsorted(energy, 0.9 * energy[-1]) / rate
    return [*(10 * np.log10(np.maximum(shares, 1e-4))), 20 * np.log10(lasts)]


@pytest.fixture(scope="module")
def heard(tmp_path_factory):
    """Features (materials, blows, n)."""
    variation = SAMPLES["pile"].variation
    rule = {"brightness": [materials.WEAK_BRIGHTNESS, 1.0], "variation": variation}
    folder = tmp_path_factory.mktemp("blows")
    return np.array(
        [[features(*blow) for blow in blows(name, rule, folder)] for name in substances()]
    )


@pytest.mark.slow
def test_nine_of_ten_blows_name_their_material(heard):
    taught = np.arange(len(PLACES)) % len(ENERGIES) % 2 == 0
    labels = np.repeat(np.arange(len(heard)), taught.sum())
    _, nearest = spatial.cKDTree(heard[:, taught].reshape(len(labels), -1)).query(heard[:, ~taught])
    right = labels[nearest] == np.arange(len(heard))[:, None]
    assert len(heard) >= 8
    assert right.mean() >= 0.9, dict(zip(substances(), right.mean(axis=1).tolist(), strict=True))


@pytest.mark.slow
def test_no_two_blows_of_a_material_are_alike(heard):
    for blows_of in heard:
        assert spatial.distance.pdist(blows_of).min() > 1e-3


def test_every_object_of_every_sample_that_can_be_hit_has_a_template(build):
    from haptic_tracing.addon.scene_reader.objects import read_impact_material

    for name in ("hammer_nail", "rails"):
        scene = build(name)
        solid = [obj for obj in scene.objects if obj.haptics.enabled and not obj.haptics.medium]
        assert solid and all(read_impact_material(obj) for obj in solid)
        assert {obj.haptics.material.name for obj in solid} <= set(
            scene.haptics.materials.items.keys()
        )
