"""Clips as other tools write them, against their closed forms: .haps of version 6, and HJIF with
amplitudes beyond 1."""

import json

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.io.error import FormatError

RATE = 8000


def curve(*keys, gain=1, kind="Linear"):
    return {
        "gain": gain,
        "interpolation_function": kind,
        "keyframes": [{"position": t, "slope": 0.0, "value": v} for t, v in keys],
    }


def clip(**changes):
    """Half a second whose amplitude falls and whose pitch rises from 20 to 60 Hz, a quarter of a
    second after the start."""
    note = {
        "amplitude": curve((0.0, 1.0), (0.5, 0.2), gain=0.5),
        "pitch": curve((0.0, 0.02), (0.5, 0.06)),
        "length": 0.5,
        "position": 0.25,
        "m_gain": 0.8,
        **changes,
    }
    silent = {"gain": 1.0, "mute": True, "notes": [note]}
    vibration = {
        "frequency_range": {"min": 0.0, "max": 1000.0},
        "gain": 0.5,
        "loop": False,
        "melodies": [silent, {"gain": 1.0, "mute": False, "notes": [note]}],
        "transients": [],
    }
    return {"description": "falling", "gain": 1.0, "version": "6", "vibration": vibration}


def written(tmp_path, document, suffix):
    path = tmp_path / f"clip{suffix}"
    path.write_text(json.dumps(document))
    return path


def test_haps_of_version_6(tmp_path):
    reading = registry.read(written(tmp_path, clip(), ".haps"))
    (channel,) = reading.channels
    since = np.arange(RATE // 2) / RATE
    phase = 2 * np.pi * (20 * since + 40 * since**2)  # the integral of 20 + 80 t
    expected = 0.5 * 0.8 * 0.5 * (1.0 - 1.6 * since) * np.sin(phase)
    assert (channel.name, channel.duration, reading.losses) == ("falling", 0.75, ())
    np.testing.assert_allclose(channel.at_rate(RATE)[RATE // 4 :], expected, atol=1e-9)
    assert not channel.at_rate(RATE)[: RATE // 4].any()


def test_what_is_not_read_of_version_6_is_said(tmp_path):
    document = clip(pitch=curve((0.0, 0.02), kind="Cubic"))
    document["vibration"]["transients"] = [{"position": 0.0}]
    losses = registry.read(written(tmp_path, document, ".haps")).losses
    assert any("transients" in loss for loss in losses) and any(
        loss.startswith("Cubic curves") for loss in losses
    )


@pytest.mark.parametrize(
    ("version", "reason"), [("7", "versions 5 and 6"), ("6", "/vibration/melodies: is required")]
)
def test_other_versions_and_faults_are_named(tmp_path, version, reason):
    document = {**clip(), "version": version}
    del document["vibration"]["melodies"]
    with pytest.raises(FormatError, match=reason):
        registry.read(written(tmp_path, document, ".haps"))


def test_amplitudes_beyond_1_are_clipped_and_keyframes_sorted(tmp_path):
    keys = [(0, 0.5), (100, 1.25), (200, -1.5)]
    frames = [
        {"relative_position": t, "amplitude_modulation": a, "frequency_modulation": 100}
        for t, a in keys
    ]
    effect = {
        "effect_type": "Basis",
        "position": 0,
        "phase": 0,
        "base_signal": "Sine",
        "keyframes": frames,
    }
    band = {
        "band_type": "VectorialWave",
        "lower_frequency_limit": 0,
        "upper_frequency_limit": 1000,
        "effects": [effect],
    }
    channel = {
        "id": 0,
        "description": "hand",
        "gain": 1,
        "mixing_coefficient": 1,
        "body_part_mask": 0,
        "bands": [band],
    }
    perception = {
        "id": 0,
        "avatar_id": 0,
        "description": "",
        "perception_modality": "Vibrotactile",
        "effect_library": [],
        "channels": [channel],
    }
    head = {
        "version": "2023",
        "profile": "Main",
        "level": 1,
        "date": "2026-01-01",
        "description": "",
        "timescale": 1000,
    }
    document = {
        **head,
        "avatars": [],
        "perceptions": [{**perception, "channels": [channel]}],
        "syncs": [],
    }
    reading = registry.read(written(tmp_path, document, ".hjif"))
    (carrier,) = reading.channels[0].carriers
    assert carrier.amplitudes.tolist() == [0.5, 1.0, -1.0] and reading.losses == (
        "amplitudes beyond 1 are clipped",
    )
    frames[1]["amplitude_modulation"], frames[2]["amplitude_modulation"] = 1, -1
    assert registry.read(written(tmp_path, document, ".hjif")).losses == ()
    frames.reverse()
    reading = registry.read(written(tmp_path, document, ".hjif"))
    (carrier,) = reading.channels[0].carriers
    assert carrier.amplitude_times.tolist() == pytest.approx([0.0, 0.1, 0.2])
    assert carrier.amplitudes.tolist() == [0.5, 1.0, -1.0] and carrier.end == pytest.approx(0.2)
    assert reading.losses == ("keyframes that are not in the order of time are sorted",)
