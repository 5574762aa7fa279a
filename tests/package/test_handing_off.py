"""The listings of docs/handing_off.md, run as they stand."""

import re
import wave

import haptic_tracing as ht
import numpy as np
import pytest
from haptic_tracing.command_line.serve.conversation import Conversation
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks

TIME = np.arange(4800) / 48000
TONES = {"seat": 0.5 * np.sin(2 * np.pi * 40 * TIME), "hand": 1.2 * np.sin(2 * np.pi * 90 * TIME)}


@pytest.fixture
def listings(root, tmp_path, monkeypatch):
    """The Python of the page, in a folder with an export."""
    listeners = tuple(ListenerTrack(name) for name in TONES)
    tracks = Tracks(listeners, 48000, np.array(list(TONES.values())))
    registry.write("wav", Export("bench", tracks=tracks), tmp_path)
    monkeypatch.chdir(tmp_path)
    page = (root / "docs" / "handing_off.md").read_text("utf-8")
    return re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)


def samples_of(path):
    with wave.open(str(path), "rb") as file:
        assert (file.getsampwidth(), file.getframerate()) == (2, 48000)
        data = np.frombuffer(file.readframes(file.getnframes()), "<i2")
        return data.reshape(-1, file.getnchannels()) / 32768


def test_each_listener_becomes_a_file(listings, tmp_path):
    exec(listings[0], {})
    for name, tone in TONES.items():
        (samples,) = samples_of(tmp_path / f"{name}.wav").T
        np.testing.assert_allclose(samples, np.clip(tone, -1, 1), atol=1e-4)


def test_the_seat_is_the_last_channel_of_the_sound_track(listings, tmp_path):
    sound = (np.sin(np.arange(12000)) * 3000).astype("<i2").reshape(6000, 2)
    with wave.open(str(tmp_path / "sound_track.wav"), "wb") as file:
        file.setparams((2, 2, 48000, 0, "NONE", ""))
        file.writeframes(sound.tobytes())
    exec(listings[1], {})
    left, right, seat = samples_of(tmp_path / "with_seat.wav").T
    np.testing.assert_array_equal(np.column_stack([left, right]) * 32768, sound)
    np.testing.assert_allclose(seat[:4800], TONES["seat"], atol=1e-4)
    assert not seat[4800:].any()


def written_in(root, language):
    page = (root / "docs" / "handing_off.md").read_text("utf-8")
    (listing,) = re.findall(rf"```{language}\n(.*?)```", page, flags=re.DOTALL)
    return listing


def test_what_unreal_says_is_answered_in_its_axes_and_unit(root):
    scene = ht.Scene(
        objects=[{"name": "crate", "kappa": 0.1, "rho": 0.9}],
        sources=[{"name": "motor", "object": "crate", "position": [0, 0, 0]}],
        listeners=[{"name": "chest", "object": "crate", "position": [0, 0, 1]}],
    )
    conversation = Conversation(scene, None)
    answers = [conversation.answer(line)[0] for line in written_in(root, "json").splitlines()]
    assert [answer["type"] for answer in answers] == ["scene", "frame", "frame"]
    assert answers[2]["levels"]["chest"]["level"] == pytest.approx(
        20 * np.log10(answers[2]["levels"]["chest"]["gains"]["motor"] / np.sqrt(2)), abs=0.3
    )


@pytest.mark.parametrize(
    "language, client, called, declared",
    [
        ("gdscript", "godot/addons/haptic_tracing/haptic_tracing.gd", "haptics", "(?:signal|func) {}[(]"),
        ("csharp", "csharp/HapticTracing.cs", "client", "public [^(]* {}(?:[(]|;)"),
    ],
)  # fmt: skip
def test_listings_call_what_clients_have(root, language, client, called, declared):
    source = (root / "clients" / client).read_text("utf-8")
    names = re.findall(rf"\b{called}\.(\w+)", written_in(root, language))
    assert names
    for name in names:
        assert re.search(declared.format(name), source), name
