"""Sound cards whose channels are actuators: a DualSense over USB (channels 3 and 4), bass shakers,
cushions and headsets.

Through python-sounddevice, which is PortAudio: its wheels for Windows and macOS contain it; Linux
has a package (libportaudio2). PortAudio requests samples from its own thread; they come from a
queue that runs empty, so the card falls silent if the program hangs.
"""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..forms import Form
from ..frozen import frozen
from .actuation import SampleActuation, checked_block
from .connection import DeviceError, carried_module
from .limits import DriveLimits, SampleLimits
from .pacing import Ahead, SampleQueue, join
from .profiles import Actuator, Adjustment, Calibration, DriveChannel
from .status import ThreadedOutput
from .writer import RESCAN, SAMPLE_RATE

# Recognised cards: name, least number of channels, and the actuators by channel.
_KNOWN: tuple[tuple[str, int, Mapping[int, tuple[str, str]]], ...] = (
    (
        r"DualSense|^Wireless Controller",
        4,
        {2: ("left grip", "hand.L"), 3: ("right grip", "hand.R")},
    ),
)
# Audio systems that offer the same card, the one with the least latency first.
_HOSTS = (
    "Windows WASAPI",
    "Core Audio",
    "PipeWire",
    "PulseAudio",
    "JACK Audio Connection Kit",
    "ALSA",
)
_MOST_CHANNELS = 8
_BAND = (20.0, 1000.0)
_SAFE_MAXIMUM, _SLEW, _SUSTAINED, _SUSTAINED_SECONDS = 1.0, 50.0, 0.7, 10.0
# Seconds that are queued before the first block, so that a frame may be late without a gap, and the
# length to which a longer queue is cut.
_MARGIN, _EARLY = 0.015, 0.030


@frozen
class SoundCard:
    """A sound card. index: PortAudio's number. channels: their number. rate: hertz. actuators:
    those of its used channels, each with the channel's number (from 0) as its channel's name."""

    title: str
    index: int
    channels: int
    rate: int
    actuators: tuple[Actuator, ...]

    plays_frequency: ClassVar[bool] = True
    """Samples carry all frequencies."""


def sound_module() -> Any:
    """python-sounddevice. Raises DeviceError that says how to get it."""
    try:
        return carried_module("sounddevice", "sound cards")
    except DeviceError:
        raise
    except OSError:
        raise DeviceError(
            "sound cards need the library PortAudio (Debian, Ubuntu: libportaudio2; Fedora: "
            "portaudio)"
        ) from None


def sound_cards(module: Any) -> tuple[SoundCard, ...]:
    """The cards with outputs, each once. Raises DeviceError if the audio system is unavailable."""
    try:
        hosts = [host["name"] for host in module.query_hostapis()]
        devices = [dict(device) for device in module.query_devices()]
    except module.PortAudioError as error:
        raise DeviceError(f"sound cards can't be listed: {error}") from None
    wanted = next(
        (
            name
            for name in _HOSTS
            if name in hosts and any(hosts[d["hostapi"]] == name for d in devices)
        ),
        None,
    )
    return tuple(
        SoundCard(
            device["name"],
            number,
            device["max_output_channels"],
            round(device["default_samplerate"]),
            _actuators(device),
        )
        for number, device in enumerate(devices)
        if device["max_output_channels"] > 0 and wanted in (None, hosts[device["hostapi"]])
    )


def _actuators(device: Form) -> tuple[Actuator, ...]:
    channels = device["max_output_channels"]
    used: Mapping[int, tuple[str, str]] = {
        number: (f"channel {number + 1}", "") for number in range(min(channels, _MOST_CHANNELS))
    }
    for pattern, least, known in _KNOWN:
        if channels >= least and re.search(pattern, device["name"]):
            used = known
    return tuple(
        Actuator(
            name,
            (part,) if part else (),
            "PCM",
            _BAND,
            0.005,
            _SAFE_MAXIMUM,
            (DriveChannel(str(number), _BAND),),
            Calibration(),
        )
        for number, (name, part) in used.items()
    )


class SoundCardWriter(ThreadedOutput):
    """A sound card that is fed with blocks of samples, one row per actuator; used like
    `DeviceWriter`."""

    def __init__(
        self,
        card: SoundCard,
        *,
        rate: int = SAMPLE_RATE,
        adjustment: Adjustment | None = None,
        module: Any = None,
    ) -> None:
        """rate: samples per second of the blocks. module: replacement for python-sounddevice."""
        super().__init__(card.title)
        self.profile = card
        self._module = module
        self._rows = len(card.actuators)
        used = [actuator.channels[0].name for actuator in card.actuators]
        self._places = list(map(int, used))
        self._actuation = SampleActuation(card.actuators, used, rate, card.rate)
        self._rate = rate
        ceilings = np.array([actuator.safe_maximum for actuator in card.actuators])
        self._drive = DriveLimits(ceilings, _SLEW, _SUSTAINED, _SUSTAINED_SECONDS, 1.0 / 24.0)
        self._limits = SampleLimits(self._drive, self._rows)
        self._lock = threading.Lock()
        # Guarded by _lock:
        self._queue = SampleQueue(self._rows, self._actuation.hop, self._resampled)
        self._queue.dry = True
        self._sent: float | None = None
        self._end = 0.0
        self._stop = threading.Event()
        self._ended = threading.Event()
        self._latency = 0.0
        self.adjust(adjustment or Adjustment())

    def adjust(self, adjustment: Adjustment) -> None:
        self._adjustment = adjustment
        self._drive.scale_ceilings(adjustment.ceiling)
        self._actuation.calibrate(adjustment.calibrations)

    def send(self, block: ArrayLike, sent: float | None = None) -> float:
        """Play a block after the rest of the one before. (actuators, n) in [-1, 1] at the rate.

        sent: when that was decided, which only distinguishes blocks; None for now. Returns that
        time.
        """
        checked = checked_block(np.asarray(block), self._rows)
        sent = time.perf_counter() if sent is None else sent
        block_seconds = checked.shape[1] / self._rate
        if self._state != "open":
            self._dropped += 1
            return sent
        rate, queue = self.profile.rate, self._queue
        with self._lock:
            begun = queue.ahead.begun
            if begun:  # then the block waits for its turn as long as any other
                queue.fill(round(_MARGIN * rate))
            seam = begun and len(queue) > 0
            samples = self._resampled(checked)
            if len(queue) > _EARLY * rate:
                queue.samples = queue.samples[:, : round(_MARGIN * rate)]
                seam = True
            if seam:
                join(samples, 0, queue.samples[:, -1:])
            if queue.dry:
                queue.append(
                    np.zeros((self._rows, round(max(_MARGIN + self._adjustment.delay, 0.0) * rate)))
                )
            self._delays.append(len(queue) / rate)
            queue.append(samples)
            self._sent = sent
            self._end = sent + block_seconds
            queue.ahead = queue.ahead.after(self._end)
            queue.dry = False
        self._written += 1
        return sent

    def expect(self, ahead: ArrayLike, sent: float) -> None:
        expected = checked_block(np.asarray(ahead), self._rows)
        with self._lock:
            if sent == self._sent:
                self._queue.ahead = Ahead(expected, self._rate, self._end)

    def silence(self) -> None:
        with self._lock:
            self._queue.clear()
            self._sent = None
            self._actuation.reset()

    def rest(self) -> None:
        self.silence()  # a card needs no release

    def request_stop(self) -> None:
        self.silence()
        self._stop.set()

    def _lag(self, delay: float) -> float:
        return delay + self._latency + self._actuation.delay + 0.005

    def fill(self, out: NDArray[np.float32]) -> None:
        """Fill ``out`` (n, channels) with the queued samples, then silence, without a jump."""
        out[:] = 0.0
        with self._lock:
            was_dry = self._queue.dry
            played = self._queue.take(len(out))
            self._queue.dry = self._queue.dry or was_dry  # until the next block
        out[:, self._places] = np.clip(played, -1.0, 1.0).T

    def _resampled(self, samples: FloatArray) -> FloatArray:
        """Samples at the card's rate, with the user's adjustment and within the limits."""
        resampled = self._actuation.process(samples)
        return self._limits.limited(resampled, resampled.shape[1] / self.profile.rate)

    def _run(self) -> None:
        """The thread: keeps the stream open until the end."""
        try:
            module = self._module or sound_module()
        except DeviceError as error:
            self._state = "failed"
            self._message = str(error)
            return
        while not self._stop.is_set():
            try:
                self._play(module)
            except (module.PortAudioError, ValueError) as error:
                self._message = f"{self.profile.title}: {error}"
                self._failed += 1
            if not self._stop.is_set():
                self._state = "searching"
                self._stop.wait(RESCAN)
        self._state = "stopped"

    def _play(self, module: Any) -> None:
        def callback(out: NDArray[np.float32], frames: int, clock: Any, status: Any) -> None:
            self.fill(out)

        self._ended.clear()
        channels = max(self._places) + 1
        with module.OutputStream(
            device=self.profile.index,
            channels=channels if channels <= 2 else self.profile.channels,
            samplerate=self.profile.rate,
            dtype="float32",
            latency="low",
            callback=callback,
            finished_callback=self._ended.set,
        ) as stream:
            self._latency = float(stream.latency)
            self._message = ""
            self._state = "open"
            while not self._stop.is_set() and not self._ended.wait(0.05):
                pass
            if not self._stop.is_set():
                self._losses += 1
                self._message = f"{self.profile.title} is gone"
            else:
                # Let the ramp to zero play.
                self._ended.wait(min(self._latency + 0.02, 0.2))
