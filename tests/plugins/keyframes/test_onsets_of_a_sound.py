"""A click and a thump that *Sound to Vibration* finds are transients in the files of players."""

import json
import wave

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.signals.felt_sound import Feel, vibration
from haptic_tracing.core.signals.sound import Clip, heard, mixed, outcome
from haptic_tracing.core.signals.wav import WavFile

RATE, SOUND_RATE = 8000, 48_000
CLICK, THUMP = 0.5, 1.2


def click_and_thump(path):
    """Noise that decays within milliseconds, and a drum of 60 Hz."""
    samples = np.zeros(2 * SOUND_RATE)
    times = np.arange(SOUND_RATE // 2) / SOUND_RATE
    noise = np.random.default_rng(0).standard_normal(len(times))
    for begin, sound in (
        (CLICK, 0.5 * noise * np.exp(-times / 0.00125) * (times < 0.005)),
        (THUMP, 0.9 * np.sin(2 * np.pi * 60 * times) * np.exp(-times / 0.06)),
    ):
        first = round(begin * SOUND_RATE)
        samples[first : first + len(sound)] += sound
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, SOUND_RATE, 0, "NONE", ""))
        file.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def transients(files):
    """Times of the emphases, or of the `HapticTransient`s, in files."""
    for path in files:
        document = json.loads(path.read_text())
        if path.suffix == ".haptic":
            points = document["signals"]["continuous"]["envelopes"]["amplitude"]
            yield from (point["time"] for point in points if "emphasis" in point)
        elif path.suffix == ".ahap":
            events = [entry.get("Event", {}) for entry in document["Pattern"]]
            yield from (
                event["Time"] for event in events if event.get("EventType") == "HapticTransient"
            )


@pytest.mark.plugins
@pytest.mark.parametrize("name", ["haptic", "ahap"])
def test_onsets_of_a_sound_are_transients(tmp_path, name):
    click_and_thump(tmp_path / "sound.wav")
    with (tmp_path / "sound.wav").open("rb") as file:
        found = outcome(heard(outcome(mixed((Clip(WavFile(file)),)))))
    samples = vibration(found, Feel()).sample(0, 2 * RATE, RATE)
    export = Export("sound", tracks=Tracks((ListenerTrack("hand"),), RATE, samples[None]))
    files = registry.write(name, export, tmp_path).files
    assert list(transients(files)) == pytest.approx([CLICK, THUMP], abs=0.005)


@pytest.mark.plugins
@pytest.mark.parametrize("name", ["haptic", "ahap"])
def test_a_tone_that_begins_suddenly_has_none(tmp_path, name):
    times = np.arange(2 * RATE) / RATE
    tone = np.where(times >= 0.5, 0.5 * np.sin(2 * np.pi * 90 * times), 0.0)
    export = Export("tone", tracks=Tracks((ListenerTrack("hand"),), RATE, tone[None]))
    assert not list(transients(registry.write(name, export, tmp_path).files))
