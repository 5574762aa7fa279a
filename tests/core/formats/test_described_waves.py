"""The side-car of a WAV file: where it is damaged, the wave plays without it."""

import json

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks

TIME = np.arange(8000) / 8000


@pytest.mark.parametrize("damage", ["not JSON", "names", "full_scale"])
def test_a_wave_with_a_damaged_description_plays(tmp_path, damage):
    tracks = Tracks((ListenerTrack("hand", "hand.L"),), 8000, 0.5 * np.sin(500 * TIME)[None])
    registry.write("wav", Export("one", tracks=tracks), tmp_path)
    beside = tmp_path / "one.wav.json"
    document = json.loads(beside.read_text())
    if damage == "names":
        del document["listeners"][0]["name"]
    else:
        document["listeners"][0]["full_scale"] = [[-1, "loud"]]
    beside.write_text("{" if damage == "not JSON" else json.dumps(document))
    reading = registry.read(tmp_path / "one.wav")
    (loss,) = reading.losses
    assert loss.startswith("one.wav.json is not used: ")
    assert reading.channels[0].name == "one" and reading.channels[0].device is None
    np.testing.assert_allclose(reading.channels[0].at_rate(8000), tracks.samples[0], atol=2e-5)
