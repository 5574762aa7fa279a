"""Where tracing takes long, touch does not wait for it, and misses nothing."""

import time
from dataclasses import replace

import bpy
import numpy as np
import pytest
from fake_hid import until
from haptic_tracing.addon.live_output import handlers, outputs, player
from haptic_tracing.addon.session import session
from haptic_tracing.core.render.renderer import sample_index
from haptic_tracing.core.tracer import Tracer

pytestmark = pytest.mark.usefixtures("as_events")

RATE = 8000


@pytest.fixture
def slow(monkeypatch):
    """Every frame takes 40 ms to trace."""
    step = Tracer.step

    def slow_step(self, frame):
        result = step(self, frame)
        time.sleep(0.04)
        return replace(result, milliseconds={**result.milliseconds, "narrow": 40.0})

    monkeypatch.setattr(Tracer, "step", slow_step)


@pytest.fixture
def uncorrected(monkeypatch):
    """What goes ahead stays as it is."""
    monkeypatch.setattr(player, "correct", lambda result: None)


@pytest.mark.slow
def test_blocks_follow_each_other_while_frames_are_still_being_traced(
    felt, plug, connect, slow, uncorrected
):
    plug()
    connect()
    sent, waited = [], []
    outputs.running()["dualsense"].send = lambda block, at=None: sent.append(block) or 0.0
    handlers.animation_playback_pre(felt)
    for frame in range(2, 30):
        felt.frame_set(frame)
        waited.append(session.of(felt).begun is None)
    assert waited[0] and not any(waited[4:]), "the first frames are waited for, then none is"
    seconds = handlers.frame_seconds(felt)
    samples = np.concatenate(sent, axis=1)
    assert samples.shape[1] == sample_index(28 * seconds, RATE), (
        "no sample is left out or played twice"
    )
    gain = session.result_of(felt).amplitudes[0, 0]
    expected = gain * np.sin(2 * np.pi * 150.0 * np.arange(samples.shape[1]) / RATE)
    begin = sample_index(seconds, RATE)
    assert np.abs(samples[0] - expected)[begin:].max() < 1e-9
    handlers.animation_playback_post(felt)


@pytest.mark.slow
def test_gains_come_a_frame_later(felt, plug, connect, slow, uncorrected):
    plug()
    connect()
    source = bpy.data.objects["box"].haptics.source
    for frame, amplitude in ((1, 0.2), (19, 0.2), (20, 0.9), (40, 0.9)):
        source.amplitude = amplitude
        source.keyframe_insert("amplitude", frame=frame)
    felt.frame_set(1)
    sent = []
    outputs.running()["dualsense"].send = lambda block, at=None: sent.append(block) or 0.0
    handlers.animation_playback_pre(felt)
    for frame in range(2, 26):
        begun = session.of(felt).begun
        until(lambda begun=begun: begun is None or begun.done())
        felt.frame_set(frame)
    # The block that ends at frame 2 comes first.
    levels = [float(np.abs(block[0]).max()) for block in sent]
    gain = session.result_of(felt).amplitudes[0, 0] / 0.9
    assert max(levels[:18]) == pytest.approx(0.2 * gain, rel=1e-3), (
        "up to the block that ends at frame 19"
    )
    assert levels[18] == pytest.approx(0.2 * gain, rel=1e-3), (
        "frame 20 is felt with what frame 19 said"
    )
    assert levels[20] == pytest.approx(0.9 * gain, rel=1e-3)
    handlers.animation_playback_post(felt)


def test_a_frame_that_went_ahead_is_corrected_when_it_has_been_traced(felt, plug, connect, slow):
    plug()
    connect()
    source = bpy.data.objects["box"].haptics.source
    for frame, amplitude in ((1, 0.2), (19, 0.2), (20, 0.9), (40, 0.9)):
        source.amplitude = amplitude
        source.keyframe_insert("amplitude", frame=frame)
    felt.render.fps = 4  # a frame lasts longer than its trace, even on a machine that is busy
    felt.frame_set(16)
    sent = []
    outputs.running()["dualsense"].send = lambda block, at=None: sent.append((block, at)) or 0.0
    handlers.animation_playback_pre(felt)
    for frame in range(17, 21):
        felt.frame_set(frame)
        begun = session.of(felt).begun
        until(lambda begun=begun: begun is None or begun.done())
    until(lambda: len(sent) == 5)
    (ahead, begun_at), (corrected, corrected_at) = sent[-2:]
    elapsed = corrected_at - begun_at
    assert 0.03 < elapsed < 0.25, "from the moment on that the trace was done"
    assert corrected.shape[1] == pytest.approx(ahead.shape[1] - elapsed * RATE, abs=2)
    gain = session.result_of(felt).amplitudes[0, 0] / 0.9
    assert np.abs(ahead[0]).max() == pytest.approx(0.2 * gain, rel=1e-3)
    assert np.abs(corrected[0, -200:]).max() > 0.7 * gain
    handlers.animation_playback_post(felt)
