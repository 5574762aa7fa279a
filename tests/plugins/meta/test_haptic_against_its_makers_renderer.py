"""``.haptic`` clips against what the renderer of the format's maker plays for them, with the actuator
of Quest controllers: root mean square of each 10 ms and largest sample, at 8 kHz."""

import json
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.plugins.keyframes.carrier import rendered
from haptic_tracing.plugins.meta import haptic

RATE = 8000
CLIPS = json.loads(Path(__file__).with_name("haptic_renderer.json").read_text())["clips"]


@pytest.mark.parametrize("clip", CLIPS, ids=[clip["name"] for clip in CLIPS])
def test_clips_are_played_as_their_maker_plays_them(clip, tmp_path):
    path = tmp_path / "clip.haptic"
    path.write_text(json.dumps(clip["haptic"]))
    (channel,) = haptic.read(path).channels
    expected = np.array(clip["rms_10_ms"])
    samples = rendered(list(channel.carriers), 0, 80 * len(expected), RATE)
    windows = np.sqrt(np.mean(samples.reshape(-1, 80) ** 2, axis=1))

    def decibels(value, other):
        return 20 * np.log10(value / other)

    assert abs(decibels(np.sqrt(np.mean(windows**2)), np.sqrt(np.mean(expected**2)))) < 0.5
    loud = expected > 0.01
    # Theirs ends an emphasis on a whole sample: one sample more or less, of 80.
    sample = clip["peak"] ** 2 / 80
    one_decibel = 10**0.1
    assert np.all(windows[loud] ** 2 < one_decibel * expected[loud] ** 2 + sample)
    assert np.all(windows[loud] ** 2 > expected[loud] ** 2 / one_decibel - sample)
    assert np.all(windows[~loud] < 0.02)
    assert abs(decibels(np.max(np.abs(samples)), clip["peak"])) < 0.1
