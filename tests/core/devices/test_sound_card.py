"""Sound cards with a made-up PortAudio: which channels are felt where, samples without a gap, and
errors in words."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from fake_hid import until
from haptic_tracing.core.devices.connection import DeviceError
from haptic_tracing.core.devices.mapping import Place, map_listeners
from haptic_tracing.core.devices.profiles import Adjustment, Calibration
from haptic_tracing.core.devices.sound_card import SoundCardWriter, sound_cards, sound_module

RATE = 8000


class PortAudioError(Exception):
    pass


class Stream:
    """An open stream: the test asks for samples in PortAudio's place."""

    def __init__(self, module, options):
        self.module, self.options, self.latency = module, options, 0.01

    def __enter__(self):
        if self.module.broken:
            raise PortAudioError("Device unavailable")
        self.module.streams.append(self)
        return self

    def __exit__(self, *_):
        self.module.closed += 1

    def heard(self, frames):
        out = np.full((frames, self.options["channels"]), np.nan, dtype=np.float32)
        self.options["callback"](out, frames, None, None)
        return out


class PortAudio:
    """python-sounddevice with some cards."""

    PortAudioError = PortAudioError

    def __init__(self, *cards, rate=48_000.0, hosts=("ALSA",)):
        self.cards = [
            {
                "name": name,
                "hostapi": host,
                "max_output_channels": channels,
                "default_samplerate": rate,
            }
            for name, channels, host in cards
        ]
        self.hosts, self.streams, self.closed, self.broken = hosts, [], 0, False

    def query_hostapis(self):
        return [{"name": name} for name in self.hosts]

    def query_devices(self):
        return self.cards

    def OutputStream(self, **options):
        return Stream(self, options)


@pytest.fixture
def started():
    outputs = []

    def start(module, number=0, **options):
        output = SoundCardWriter(sound_cards(module)[number], module=module, **options)
        outputs.append(output)
        output.start()
        until(lambda: output.status.state == "open")
        return output

    yield start
    assert all(output.stop(5.0) for output in outputs)


def test_each_card_is_listed_once_and_a_dualsense_knows_its_grips():
    module = PortAudio(
        ("Speakers", 2, 0),
        ("Speakers", 2, 1),
        ("DualSense Wireless Controller", 4, 1),
        ("Microphone", 0, 1),
        hosts=("MME", "Windows WASAPI"),
    )
    cards = sound_cards(module)
    assert [
        (card.title, card.index, [actuator.name for actuator in card.actuators]) for card in cards
    ] == [
        ("Speakers", 1, ["channel 1", "channel 2"]),
        ("DualSense Wireless Controller", 2, ["left grip", "right grip"]),
    ]
    mapping = map_listeners(
        {"L": "hand.L", "R": "hand.R", "seat": ""},
        {"pad": cards[1], "cushion": cards[0]},
        chosen={"seat": [Place("cushion", "channel 2")]},
    )
    assert mapping.weights["pad"].tolist() == [[1, 0, 0], [0, 1, 0]]
    assert mapping.weights["cushion"].tolist() == [[0, 0, 0], [0, 0, 1]]
    assert mapping.losses == ()


def test_a_tone_comes_out_of_channels_3_and_4_without_a_gap(started):
    module = PortAudio(("DualSense Wireless Controller", 4, 0))
    output = started(module)
    (stream,) = module.streams
    assert stream.options["channels"] == 4 and stream.options["samplerate"] == 48_000
    tone = 0.3 * np.sin(2 * np.pi * 150 * np.arange(RATE // 2) / RATE)
    parts = []
    for start in range(0, len(tone), 400):
        block = tone[start : start + 400]
        output.send(np.stack([block, -block]))
        parts.append(stream.heard(2400))
    heard = np.concatenate(parts)
    assert not heard[:, :2].any()
    assert np.array_equal(heard[:, 2], -heard[:, 3])
    felt = np.flatnonzero(np.abs(heard[:, 2]) > 1e-4)
    steady = heard[felt[0] + 3000 : felt[-1] - 3000, 2]
    assert len(steady) > 14_000
    assert np.abs(steady).max() == pytest.approx(0.3, rel=0.02)
    assert np.abs(np.diff(steady)).max() <= 1.05 * 0.3 * 2 * np.pi * 150 / 48_000
    assert output.status.delay == pytest.approx(0.015, abs=0.003)


def test_without_a_fresh_block_it_is_silent_by_itself_and_rest_is_silence_at_once(started):
    module = PortAudio(("Cushion", 1, 0), rate=8000.0)
    output = started(module)
    (stream,) = module.streams
    output.send(np.full((1, 800), 0.5))
    heard = stream.heard(2000)[:, 0]
    assert heard[600] > 0.3 and not heard[1000:].any()
    output.send(np.full((1, 800), 0.5))
    stream.heard(400)
    output.rest()
    assert not stream.heard(100)[8:].any()


def test_gain_ceiling_and_full_drive_are_limited(started):
    module = PortAudio(("Cushion", 1, 0), rate=8000.0)
    output = started(
        module, adjustment=Adjustment({"channel 1": Calibration(gain=4.0)}, ceiling=0.25)
    )
    (stream,) = module.streams
    # Of 2 kHz: a steady value would not be played.
    square = np.tile([1.0, 1.0, -1.0, -1.0], 84)[None]
    for _ in range(40):
        output.send(square)
        heard = stream.heard(336)
    assert np.abs(heard).max() == pytest.approx(0.25)
    output.adjust(Adjustment())
    loudest = []
    for _ in range(24 * 60):
        output.send(square)
        loudest.append(float(stream.heard(336).max()))
    assert max(loudest) == pytest.approx(1.0) and loudest[-1] == pytest.approx(0.7, abs=0.01), (
        "0.7 for as long as it lasts"
    )


@pytest.mark.slow
def test_a_card_that_goes_away_or_can_not_be_opened_is_said_and_tried_again(started):
    module = PortAudio(("Cushion", 1, 0))
    output = started(module)
    module.broken = True
    module.streams[0].options["finished_callback"]()
    until(lambda: "Device unavailable" in output.status.message)
    assert output.status.losses == 1 and output.status.state == "searching"
    output.send(np.zeros((1, 10)))
    assert output.status.dropped_blocks == 1
    module.broken = False
    until(lambda: output.status.state == "open")


def test_a_missing_package_and_a_missing_library_are_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(DeviceError, match="package sounddevice"):
        sound_module()
    monkeypatch.delitem(sys.modules, "sounddevice")

    class Finder:
        def find_spec(self, name, *_):
            if name == "sounddevice":
                raise OSError("PortAudio library not found")

    monkeypatch.setattr(sys, "meta_path", [Finder(), *sys.meta_path])
    with pytest.raises(DeviceError, match="libportaudio2"):
        sound_module()


def test_a_system_whose_audio_does_not_answer_is_said():
    def fail():
        raise PortAudioError("no host")

    with pytest.raises(DeviceError, match="can't be listed: no host"):
        sound_cards(SimpleNamespace(PortAudioError=PortAudioError, query_hostapis=fail))
