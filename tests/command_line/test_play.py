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


def buzzing(folder, seconds):
    """A file of 60 Hz between two rests of half a second."""
    times = np.arange(round(8000 * (seconds + 1))) / 8000
    sounds = (times >= 0.5) & (times < 0.5 + seconds)
    wave = np.where(sounds, 0.8 * np.sin(2 * np.pi * 60 * times), 0.0)
    wavfile.write(folder / "buzz.wav", 8000, wave.astype(np.float32))
    return folder / "buzz.wav"


@pytest.fixture
def buzz(tmp_path):
    return buzzing(tmp_path, 1.0)


def played(folder, file, *keys):
    """Exit code, seconds at which keys were pressed and at which the command ended, seconds (n,)
    and strengths (n,) of the reports, and what was said."""
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
    return code, pressed, ended, times, strengths, done.stderr


def test_a_file_is_felt_as_long_as_it_lasts(tmp_path, buzz):
    code, _, _, times, strengths, _ = played(tmp_path, buzz)
    felt = times[strengths > 0]
    assert code == 0 and felt[-1] - felt[0] == pytest.approx(1.0, abs=0.25)
    assert strengths[-1] == 0


def test_space_pauses_and_q_stops(tmp_path, buzz):
    code, (pause, go_on, stop), ended, times, strengths, _ = played(
        tmp_path, buzz, " ", "0.9", " ", "1.9", "q", "2.2"
    )
    paused = (times > pause + 0.2) & (times < go_on)
    again = (times > go_on + 0.1) & (times < stop)
    assert code == 0 and not strengths[paused].any() and strengths[again].any()
    assert strengths[-1] == 0 and ended - stop < 1.0


def test_keys_pressed_at_once_all_count(tmp_path, buzz):
    code, (stop,), ended, _, _, _ = played(tmp_path, buzz, "  q", "0.9")
    assert code == 0 and ended - stop < 1.0


@pytest.mark.parametrize("how", ["SIGKILL", "SIGSTOP"])
def test_a_guard_that_fails_is_told_of_and_the_pad_plays_again(tmp_path, how):
    """Silenced first, then driven again while the file goes on; how soon is judged in
    `test_guard_against_signals`."""
    code, (failed,), _, times, strengths, said = played(tmp_path, buzzing(tmp_path, 6), how, "1.0")
    silent = times[(times > failed) & (strengths == 0)][0]
    again = times[(times > silent) & (strengths > 0)]
    assert code == 0 and again.size and strengths[-1] == 0
    print(how, f"silent after {silent - failed:.2f} s, again after {again[0] - failed:.2f} s")
    lines = said.splitlines()
    lost, back = ([line for line in lines if text in line] for text in ("has ended", "plays again"))
    assert len(lost) == len(back) == 1


def test_without_a_device_it_says_so_and_what_is_not_read(buzz, capsys):
    buzz.with_name("buzz.wav.json").write_text("{")
    assert main(["play", str(buzz), "--device", "no such pad"]) == 2
    said = capsys.readouterr().err
    assert "device 'no such pad' is not connected" in said
    assert "buzz.wav: buzz.wav.json is not used: not JSON" in said
