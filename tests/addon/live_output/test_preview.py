"""The preview through Blender's audio: without a gap, in stereo, and a clear word where there is no
audio."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.live_output import handlers, preview
from haptic_tracing.core.scene.values import Listener


class Device:
    """A loudspeaker whose clock stands wherever the test puts it."""

    def __init__(self):
        self.handle = self
        self.position = 0.0
        self.volume = 1.0
        self.stopped = False

    def play(self, sequence):
        self.sequence = sequence
        return self

    def stop(self):
        self.stopped = True


@pytest.fixture
def loudspeaker(monkeypatch, scene):
    aud = pytest.importorskip("aud", reason="this bpy is built without audio")
    if bpy.app.version < preview.OLDEST:
        pytest.skip(
            "before Blender 5.2 the preview says that its audio system leaves out short sounds"
        )
    device = Device()
    monkeypatch.setattr(preview, "_audio", lambda: (aud, device))
    preview.switch_on()
    yield device
    preview.switch_off()


def bodies(*parts):
    """Listeners at body parts."""
    return [Listener(part, part, body_part=part, radius=0.0) for part in parts]


def heard(device, seconds):
    """What Blender's sequencer makes of the pieces, (n, 2)."""
    return device.sequence.limit(0, seconds).data()


def test_without_an_audio_device_the_operator_says_so(scene):
    assert bpy.ops.haptic.toggle_preview() == {"CANCELLED"}
    assert not preview.is_on()
    with pytest.raises(
        preview.AudioUnavailable, match=r"no audio device|without audio|needs Blender 5.2"
    ):
        preview.switch_on()


def test_the_operator_switches_on_and_off(loudspeaker):
    assert bpy.ops.haptic.toggle_preview() == {"FINISHED"}
    assert not preview.is_on()
    assert bpy.ops.haptic.toggle_preview() == {"FINISHED"}
    assert preview.is_on()


def test_blocks_of_any_length_follow_each_other_without_a_gap(loudspeaker):
    """A tone cut into frames comes out as the tone, resampled: no piece begins early, late or with
    a click."""
    rate, seconds = 8000, 0.24
    tone = 0.2 * np.sin(2 * np.pi * 150.0 * np.arange(round(rate * seconds)) / rate)
    start = 0
    for end in (*range(333, len(tone), 333), len(tone)):
        preview.play(
            bodies("hand.L", "hand.R"), np.stack([tone[start:end], np.zeros(end - start)]), rate
        )
        start = end
    samples = heard(loudspeaker, 0.5)
    felt = np.flatnonzero(np.abs(samples[:, 0]) > 0.01)
    assert felt[0] / preview.RATE == pytest.approx(preview.LEAD, abs=0.005)
    steady = samples[felt[0] + 100 : felt[-1] - 100, 0]
    steepest = np.tanh(0.2) * 2 * np.pi * 150.0 / preview.RATE
    assert np.abs(np.diff(steady)).max() <= 2 * steepest, (
        "a sample that comes late is a hundredth, no click"
    )
    assert not samples[:, 1].any(), "the right hand feels nothing"
    assert len(steady) > 0.22 * preview.RATE


def test_a_pause_takes_away_what_has_not_been_heard(loudspeaker):
    preview.play(bodies("head"), np.full((1, 8000), 0.5), 8000)
    loudspeaker.position = 0.2
    preview.silence()
    samples = heard(loudspeaker, 1.0)
    assert np.flatnonzero(samples)[-1] / 2 / preview.RATE <= 0.25
    assert not samples[round(0.25 * preview.RATE) :].any()
    preview.play(bodies("head"), np.full((1, 800), 0.5), 8000)
    assert heard(loudspeaker, 1.0)[round(0.27 * preview.RATE) : round(0.33 * preview.RATE)].any()


def test_a_late_frame_starts_afresh_instead_of_catching_up(loudspeaker):
    preview.play(bodies("head"), np.full((1, 800), 0.5), 8000)
    loudspeaker.position = 5.0
    preview.play(bodies("head"), np.full((1, 800), 0.5), 8000)
    samples = heard(loudspeaker, 6.0)
    assert not samples[: round(5.05 * preview.RATE)].any(), "what was heard is forgotten"
    assert samples[round(5.06 * preview.RATE) : round(5.1 * preview.RATE)].any()


def test_sides_are_panned_and_sums_stay_within_full_scale():
    ones = np.ones((4, 3))
    mix = preview.stereo_mix(["hand.L", "hand.R", "belly", ""], ones)
    assert mix.shape == (2, 3)
    assert mix == pytest.approx(np.tanh(1 + 2 * np.sqrt(0.5)))
    assert np.array_equal(preview.stereo_mix(["hand.L"], 0.5 * np.ones((1, 2)))[1], np.zeros(2))
    assert np.abs(preview.stereo_mix(["hand.L"] * 9, np.ones((9, 5)))).max() <= 1.0


def test_nothing_is_heard_by_itself_in_the_background(scene):
    assert not handlers.may_hear()
    handlers.animation_playback_pre(scene)
    assert not handlers.is_wanted(scene) and not preview.is_on()
    handlers.animation_playback_post(scene)
