"""Tracks to write and to compare, as the listeners of scenes feel them."""

import math

import numpy as np
import pytest
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.body import PAPER_LISTENERS

RATE = 8000


def jackhammer(seconds, frequency=25.0, duty=0.1):
    """Blows of a jackhammer: the pulse train of the sample scene."""
    time = np.arange(round(seconds * RATE)) / RATE
    return ((time * frequency) % 1.0 < duty).astype(np.float64)


def impact_samples(seconds, times, frequency=150.0, decay=0.03):
    """Decaying sines at ``times``."""
    time = np.arange(round(seconds * RATE)) / RATE
    samples = np.zeros(len(time))
    for begin in times:
        since = time - begin
        samples += np.where(
            since >= 0,
            np.exp(-np.maximum(since, 0) / decay) * np.sin(2 * math.pi * frequency * since),
            0.0,
        )
    return samples


def study_tracks(seconds=5.0):
    """Ten listeners on a bench: a jackhammer through the ground, and crates that fall; each feels
    it as strongly as the way allows."""
    times = [0.5, 0.708, 0.917, 1.125, 1.333]
    hammer, crates = jackhammer(seconds), impact_samples(seconds, times)
    gains = np.geomspace(0.03, 0.4, len(PAPER_LISTENERS))
    listeners = tuple(
        ListenerTrack(name, name, np.column_stack([times, np.full(len(times), gain * 0.8)]))
        for name, gain in zip(PAPER_LISTENERS, gains, strict=True)
    )
    return Tracks(listeners, RATE, gains[:, None] * (0.5 * hammer + 0.8 * crates))


@pytest.fixture(scope="session")
def study():
    """Ten listeners for five seconds."""
    return study_tracks()
