"""Films and tracks of a study with people, rendered from a sample scene."""

import sys

import numpy as np
import pytest
import small_study
from bounded_program import run as run_bounded
from haptic_tracing.command_line import main
from haptic_tracing.core.formats.tracks.wav import read, stored_samples
from haptic_tracing.core.perception import FullScale
from haptic_tracing.study.people.plan import read_form
from haptic_tracing.study.people.plan import stimuli as known

pytestmark = pytest.mark.slow

FORM = (
    small_study.FORM
    + """film_settings = ["scene.render.engine=CYCLES", "scene.cycles.samples=1",
                 "scene.render.resolution_x=32", "scene.render.resolution_y=24"]
[conditions.traced]
settings = ["scene.haptics.mode=HT", 'objects["hand.L"].haptics.listener.full_scale=40 3, 160 14']
[conditions.everywhere]
settings = ["scene.haptics.mode=MN"]
[scenes.Bench]
sample = "jackhammer_bench"
frames = [1, 6]
"""
)


def test_films_and_tracks_are_rendered_once(tmp_path):
    (tmp_path / "study.toml").write_text(FORM)
    command = ["study", "run", "--participants", "2", "--out", str(tmp_path), "--prepare"]
    program = [sys.executable, "-m", "haptic_tracing", *command]
    assert run_bounded(program, 900).returncode == 0
    stimuli = tmp_path / "stimuli"
    files = known(tmp_path, read_form(tmp_path))
    assert files["Bench", ""].read_bytes()[:4] == bytes.fromhex("1a45dfa3")  # Matroska
    traced, everywhere = (
        stored_samples(files["Bench", name])[0] for name in ("traced", "everywhere")
    )
    # By definition the mode MN is the same at all listeners; HT is not.
    assert np.ptp(everywhere, axis=0).max() == 0 and np.abs(everywhere).max() > 0.01
    assert np.ptp(traced, axis=0).max() > 0.01
    channels = read(files["Bench", "traced"]).channels
    parts = {channel.body_part for channel in channels}
    assert "" not in parts and len(parts) == len(traced)
    calibrated = [one.device for one in channels if one.device]
    assert calibrated == [FullScale(((40.0, 3.0), (160.0, 14.0)))]
    before = {path: path.stat().st_mtime_ns for path in stimuli.rglob("*")}
    assert main(command) == 0
    assert {path: path.stat().st_mtime_ns for path in stimuli.rglob("*")} == before
