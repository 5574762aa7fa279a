"""Samples give what they gave, in every version of Blender; and the whole way from building one to
the files of all formats works.

Stored values were computed once (`short_parts.py`) with Blender 5.2: gains and levels by
`level_reference`, from what touches what. Blender keeps transforms in single precision, so that
positions of some metres are known to a few tenths of a micrometre and gains to about 1e-7; the
largest difference between Blender 4.2, 4.5, 5.0 and 5.2 was 8e-8. Another processor may round a
simulation differently: until one collision leads to the next that stays below a hundredth of a
millimetre, so gains may differ by `TOLERANCE`, and energies by a thousandth.
"""

import importlib.util
import json
from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.io.catalogue import named
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.sample_scenes import SAMPLES
from scipy.io import wavfile

_specification = importlib.util.spec_from_file_location(
    "short_parts", Path(__file__).with_name("short_parts.py")
)
short_parts = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(short_parts)

TOLERANCE = 1e-5
ENERGY_TOLERANCE = 1e-3
LEVEL_TOLERANCE = 0.01
"""A tenth of a decibel: the reference does not round the corners of gains that change from frame to
frame."""
SHARES = 4
STORED = json.loads(short_parts.STORED.read_text(encoding="utf-8"))


def test_every_sample_has_stored_values():
    assert set(STORED) == set(short_parts.PARTS) == set(SAMPLES)


def left_out(scene, levels, expected):
    """Which listeners are silent because all that arrives lies 20 dB under the threshold of feeling
    the tones of a scene."""
    sources = [obj.haptics.source for obj in scene.objects if obj.haptics.source.enabled]
    highest = max((float(threshold_level(item.frequency)) for item in sources), default=-np.inf)
    return (levels == 0) & (np.sqrt(2) * expected < 10 ** ((highest - 20) / 20))


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_gains_tracks_and_impacts_are_the_stored_ones(build, name):
    scene = build(name, short_parts.PARTS[name][2])
    found, stored = short_parts.digest(scene, short_parts.played(name, scene)), STORED[name]
    assert found["listeners"] == stored["listeners"]
    assert found["contacts"] == stored["contacts"]
    assert sorted(impact[:3] for impact in found["impacts"]) == sorted(
        impact[:3] for impact in stored["impacts"]
    )
    energies, expected = (
        [impact[3] for impact in sorted(values["impacts"])] for values in (found, stored)
    )
    assert energies == pytest.approx(expected, rel=ENERGY_TOLERANCE)
    levels, expected = np.array(found["levels"]), np.array(stored["levels"])
    expected[left_out(scene, levels, expected)] = 0
    assert levels == pytest.approx(expected, rel=LEVEL_TOLERANCE)
    assert found["gains"].keys() == stored["gains"].keys()
    for frame, rows in stored["gains"].items():
        # Impacts of one frame may come in another order, if they come at the same time.
        ours = sorted(found["gains"][frame])
        assert [row[0] for row in ours] == [row[0] for row in sorted(rows)]
        assert np.array([row[1:] for row in ours]) == pytest.approx(
            np.array([row[1:] for row in sorted(rows)]), abs=TOLERANCE
        )
        assert np.max([row[1:] for row in rows]) > 20 * TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_from_building_to_the_files_of_all_formats(build, tmp_path, name):
    """Each sample has its share of the formats, so that each format has several samples."""
    first, last, count = short_parts.PARTS[name]
    scene = build(name, count)
    short_parts.use_paper(scene)
    scene.frame_end = last
    assert bpy.ops.haptic.bake() == {"FINISHED"}
    scene.frame_set(last)  # played from what was baked
    path = tmp_path / "scene.json"
    arguments = {"frames": "RANGE", "frame_start": first, "frame_end": last, "tracks": "wav"}
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path), **arguments) == {"FINISHED"}
    export = read_export(path)
    shown = {short_parts.level_reference.owner(item.name) for item in export.scene.objects}
    assert shown == {obj.name for obj in bpy.data.objects if obj.haptics.enabled}
    assert len(export.scene.listeners) == len(STORED[name]["listeners"])
    assert export.recording.frames[0].number == first
    share = list(SAMPLES).index(name) % SHARES
    for kind in {"wav", *list(catalogue.formats())[share::SHARES]} - {"scene"}:
        target = tmp_path / kind / f"{name}{named(kind).suffix}"
        target.parent.mkdir()
        arguments = {"formats": {kind}, "frame_start": first, "frame_end": last, "absolute": True}
        assert bpy.ops.export_scene.haptic_tracks(filepath=str(target), **arguments) == {"FINISHED"}
        files = [file for file in target.parent.rglob("*") if file.is_file()]
        assert files and all(file.stat().st_size for file in files)
    rate, samples = wavfile.read(tmp_path / "wav" / f"{name}.wav")
    assert samples.shape[1] == len(STORED[name]["listeners"])
    until = round((last - first) / scene.render.fps * rate)  # the last frame goes on
    levels = np.sqrt(((samples[:until] / 32768) ** 2).mean(axis=0))
    expected = np.array(STORED[name]["levels"])
    expected[left_out(scene, levels, expected)] = 0
    # 16 bits: steps of 3e-5, off by half of one at most.
    assert levels == pytest.approx(expected, rel=LEVEL_TOLERANCE, abs=1.6e-5)
