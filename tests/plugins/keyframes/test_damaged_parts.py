"""An import keeps what it can and says what it can't: one damaged part of a file, in every
format that has parts, and what the file plays without it."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.plugins.keyframes.left_out import MOST

CORPUS = Path(__file__).parents[2] / "core" / "formats" / "corpus"
TIME = np.arange(8000) / 8000
PARTS = {
    "good.tact": ("project", "tracks", 0, "effects", 0),
    "good.hjif": ("perceptions", 0, "channels", 0, "bands", 0, "effects", 0),
    "good.haps": ("m_vibration", "m_melodies", 0, "m_notes", 0),
    "good-version-6.haps": ("vibration", "melodies", 0, "notes", 0),
    "good.ahap": ("Pattern", 0),
}


def held(document, place):
    for key in place:
        document = document[key]
    return document


def played(reading):
    return [channel.at_rate(8000) for channel in reading.channels]


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("at", [0, 1])
def test_a_damaged_part_is_left_out_and_named(tmp_path, name, at):
    """Before or behind the good one, which then plays as in a file without the damaged one."""
    document = json.loads((CORPUS / name).read_bytes())
    path = tmp_path / name
    path.write_text(json.dumps(document))
    expected = played(registry.read(path))
    *holder, last = PARTS[name]
    held(document, holder).insert(last + at, "damaged")
    path.write_text(json.dumps(document))
    reading = registry.read(path)
    place = "".join(f"/{key}" for key in (*holder, last + at))
    assert any(loss.startswith(f"{place} is left out: ") for loss in reading.losses)
    for samples, other in zip(played(reading), expected, strict=True):
        np.testing.assert_array_equal(samples, other)


@pytest.mark.parametrize("name", PARTS)
def test_two_damaged_parts_have_the_places_that_they_have_in_the_file(tmp_path, name):
    document = json.loads((CORPUS / name).read_bytes())
    *holder, last = PARTS[name]
    held(document, holder)[last:last] = ["damaged", "damaged"]
    (tmp_path / name).write_text(json.dumps(document))
    losses = " ".join(registry.read(tmp_path / name).losses)
    for number in (last, last + 1):
        assert "".join(f"/{key}" for key in (*holder, number)) + " is left out" in losses


@pytest.mark.parametrize("name", PARTS)
def test_a_file_of_nothing_but_damage_is_refused(tmp_path, name):
    document = json.loads((CORPUS / name).read_bytes())
    *holder, last = PARTS[name]
    held(document, holder)[last:last] = ["damaged"] * (MOST + 1)
    (tmp_path / name).write_text(json.dumps(document))
    with pytest.raises(FormatError):
        registry.read(tmp_path / name)


@pytest.mark.parametrize("name", ["good-reference.hjif", "good-wavelet.hjif"])
def test_effects_and_bands_that_cannot_be_decoded_are_left_out(tmp_path, name):
    """A reference to an effect that the library lacks, and a block of a length that is no power of
    two."""
    document = json.loads((CORPUS / name).read_bytes())
    for perception in document["perceptions"]:
        for channel in perception["channels"]:
            for band in channel["bands"]:
                if "block_length" in band:
                    band["block_length"] += 1
    (tmp_path / name).write_text(json.dumps(document))
    reading = registry.read(tmp_path / name)
    assert any(" is left out: " in loss for loss in reading.losses) and reading.channels


def test_a_clip_without_its_damaged_frequencies_plays_its_amplitudes(tmp_path):
    shutil.copy(CORPUS / "good.acf", tmp_path / "clip.acf")
    document = json.loads((CORPUS / "good.haptic").read_bytes())
    envelopes = document["signals"]["continuous"]["envelopes"]
    envelopes["frequency"][0]["time"] = "damaged"
    point = next(point for point in envelopes["amplitude"] if "emphasis" in point)
    point["emphasis"]["frequency"] = 7
    (tmp_path / "clip.haptic").write_text(json.dumps(document))
    reading = registry.read(tmp_path / "clip.haptic")
    (carrier,) = reading.channels[0].carriers
    assert carrier.amplitudes.tolist() == [point["amplitude"] for point in envelopes["amplitude"]]
    assert [loss.split(" is left out")[0].rsplit("/", 1)[1] for loss in reading.losses] == [
        "emphasis",
        "frequency",
    ]
