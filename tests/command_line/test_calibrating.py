"""The full scale that is found in a recording against the response of the filter that made it."""

import json
import math

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.command_line.calibrating import measured_full_scale, sweep
from haptic_tracing.core.devices.profile_files import BUILT_IN
from haptic_tracing.core.run_time import load
from scipy import signal
from scipy.io import wavfile

RATE = 8000
RESONANCE = signal.iirpeak(170.0, 3.0, fs=RATE)
SCENE = {
    "format": "haptic-scene",
    "version": "1.1",
    "objects": [{"name": "pad", "kappa": 0.1, "rho": 0.9}],
    "listeners": [{"name": "hand", "object": "pad", "position": [0, 0, 0]}],
}


def recorded(played, noise=0.0, overtone=0.0):
    """What an accelerometer on a resonant actuator records, from 0.4 s before to 0.6 s after: up
    to 30 m/s^2 at full scale."""
    moved = signal.lfilter(*RESONANCE, np.pad(played + overtone * played**3, (3200, 4800)))
    return 30.0 * moved + noise * np.random.default_rng(1).normal(size=len(moved))


@pytest.mark.parametrize(("noise", "overtone"), [(0.0, 0.0), (0.02, 0.0), (0.0, 0.2)])
def test_the_response_of_an_actuator_is_found_within_half_a_decibel(noise, overtone):
    played = sweep(3.0, RATE)
    found = measured_full_scale(played, recorded(played, noise, overtone), RATE)
    assert found[0][0] < 35 and found[-1][0] > 350
    for hertz, value in found[1:-1]:
        inside = np.geomspace(hertz * 2 ** (-1 / 6), hertz * 2 ** (1 / 6), 50)
        expected = 30 * math.sqrt(
            (np.abs(signal.freqz(*RESONANCE, inside, fs=RATE)[1]) ** 2).mean()
        )
        # Of a cube, 3/4 of the amplitude squared adds to the fundamental.
        fundamental = 1 + 0.75 * overtone * 0.6**2
        assert 20 * math.log10(value / expected / fundamental) == pytest.approx(0, abs=0.5), hertz


def test_what_noise_covers_is_left_out():
    played = sweep(3.0, RATE)
    everything = measured_full_scale(played, recorded(played), RATE)
    loud = measured_full_scale(played, recorded(played, noise=20.0), RATE)
    assert 0 < len(loud) < len(everything)
    with pytest.raises(ValueError, match="no frequency of what was played"):
        measured_full_scale(played, recorded(0 * played, noise=1.0), RATE)


def test_the_command_writes_the_calibration_into_a_scene(tmp_path, capsys):
    recording, scene = tmp_path / "thumb.wav", tmp_path / "scene.json"
    scene.write_text(json.dumps(SCENE))
    wavfile.write(recording, RATE, (recorded(sweep(2.0, RATE)) / 50).astype(np.float32))
    asked = ["devices", "calibrate", str(recording), "--unit", "50", "--seconds", "2"]
    assert main([*asked, "--scene", str(scene), "--listener", "hand"]) == 0
    (hand,) = load(scene).content.listeners
    assert hand.device is not None and hand.full_scale_source == "measured, thumb.wav"
    assert float(hand.device.acceleration(160.0)) == pytest.approx(28, rel=0.1)
    assert "Full Scale: 31.25 " in capsys.readouterr().out
    assert main([*asked, "--scene", str(scene), "--listener", "foot"]) == 2
    assert "listener 'foot' is unknown: use one of hand" in capsys.readouterr().err


def test_the_command_takes_the_values_of_a_profile(tmp_path, capsys):
    profile = json.loads((BUILT_IN / "dualsense.json").read_text())
    assert main(["devices", "calibrate", "--device", "dualsense"]) == 0
    said = capsys.readouterr().out  # its own profile has none: those of its kind, marked
    assert "Calibrated By: DualSense: estimate" in said
    profile["actuators"][0] |= {"full_scale": [[60, 4], [170, 22]], "full_scale_source": "lab"}
    (tmp_path / "dualsense.json").write_text(json.dumps(profile))
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(SCENE))
    own = ["devices", "--profiles", str(tmp_path), "calibrate", "--device", "dualsense"]
    assert main([*own, "--scene", str(scene), "--listener", "hand"]) == 0
    (hand,) = load(scene).content.listeners
    assert hand.full_scale == ((60, 4), (170, 22))
    assert hand.full_scale_source == "DualSense: lab"
