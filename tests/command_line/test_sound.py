"""``haptic-tracing convert`` of a sound: a WAV file as the signal of a source."""

import json
import wave

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.signals import signal_from_dict
from made_sounds import knocks


@pytest.fixture
def sound(tmp_path):
    samples, rate, onsets = knocks()
    with wave.open(str(tmp_path / "knocks.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((samples * 32767).astype("<i2").tobytes())
    return tmp_path / "knocks.wav", onsets


def test_a_sound_becomes_the_signal_of_a_source(sound, tmp_path, capsys):
    path, onsets = sound
    assert main(["convert", str(path), str(tmp_path / "signal.json"), "--carrier", "200"]) == 0
    assert f"{len(onsets)} onsets" in capsys.readouterr().err
    carrier, bursts = signal_from_dict(json.loads((tmp_path / "signal.json").read_text())).of
    assert carrier.of[1].frequency == 200.0
    starts = np.unique(bursts.of[0].automation.times)
    assert np.abs(starts[:, None] - onsets).min(axis=0).max() <= 0.010


def test_the_carrier_may_be_the_pitch_or_that_of_a_device(sound, tmp_path):
    path, _ = sound
    for carrier, burst in (("pitch", 160.0), ("xbox", 250.0)):
        assert (
            main(["convert", str(path), str(tmp_path / "signal.json"), "--carrier", carrier]) == 0
        )
        signal = signal_from_dict(json.loads((tmp_path / "signal.json").read_text()))
        assert burst in signal.of[1].of[1].frequency.values


def test_what_is_wrong_is_said(sound, tmp_path, capsys):
    path, _ = sound
    for arguments, fault in (
        (["knocks.wav", "signal.json", "--carrier", "none"], "none"),
        (["knocks.wav", "signal.json", "--gate", "0"], "louder than the gate"),
        (["missing.wav", "signal.json"], "missing.wav"),
        (["knocks.wav", "knocks.hjif", "--gain", "2"], "--gain: only where a sound"),
    ):
        files = [str(path.with_name(name)) for name in arguments[:2]]
        assert main(["convert", *files, *arguments[2:]]) == 2
        assert fault in capsys.readouterr().err
    assert not (tmp_path / "signal.json").exists()
