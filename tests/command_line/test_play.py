"""``haptic-tracing play`` on a pad that umockdev makes up: what is felt when, and the keys."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from bounded_program import run as run_bounded
from haptic_tracing.command_line import main
from scipy.io import wavfile

DEVICES = Path(__file__).parents[1] / "core" / "devices"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
]


@pytest.fixture
def buzz(tmp_path):
    """Two seconds of 60 Hz: half a second of rest, then one of vibration, then rest."""
    times = np.arange(16_000) / 8000
    wave = np.where((times >= 0.5) & (times < 1.5), 0.8 * np.sin(2 * np.pi * 60 * times), 0.0)
    wavfile.write(tmp_path / "buzz.wav", 8000, wave.astype(np.float32))
    return tmp_path / "buzz.wav"


def played(folder, file, *keys):
    """Exit code, seconds at which keys were pressed and at which the command ended, seconds (n,)
    and strengths (n,) of the reports."""
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")
    sys.path.insert(0, str(DEVICES))
    from made_up_devices import XBOX_BT, describe

    script = Path(__file__).parent / "serve" / "play_on_a_pad.py"
    command = ["umockdev-run", *describe(folder, [XBOX_BT]), "--", sys.executable, str(script)]
    done = run_bounded([*command, str(folder), str(file), *keys])
    assert done.returncode == 0, done.stderr
    code, pressed, ended, reports = json.loads(done.stdout.splitlines()[-1])
    times = np.array([seconds for seconds, _ in reports])
    strengths = np.array([max(bytes.fromhex(report)[2:6]) for _, report in reports])
    return code, pressed, ended, times, strengths


def test_a_file_is_felt_as_long_as_it_lasts(tmp_path, buzz):
    code, _, _, times, strengths = played(tmp_path, buzz)
    felt = times[strengths > 0]
    assert code == 0 and felt[-1] - felt[0] == pytest.approx(1.0, abs=0.25)
    assert strengths[-1] == 0


def test_space_pauses_and_q_stops(tmp_path, buzz):
    code, (pause, go_on, stop), ended, times, strengths = played(
        tmp_path, buzz, " ", "0.9", " ", "1.9", "q", "2.2"
    )
    paused = (times > pause + 0.2) & (times < go_on)
    again = (times > go_on + 0.1) & (times < stop)
    assert code == 0 and not strengths[paused].any() and strengths[again].any()
    assert strengths[-1] == 0 and ended - stop < 1.0


def test_without_a_device_it_says_so_and_what_is_not_read(buzz, capsys):
    buzz.with_name("buzz.wav.json").write_text("{")
    assert main(["play", str(buzz), "--device", "no such pad"]) == 2
    said = capsys.readouterr().err
    assert "device 'no such pad' is not connected" in said
    assert "buzz.wav: buzz.wav.json is not used: not JSON" in said
