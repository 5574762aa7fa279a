"""Conversion of samples to the drive of actuators.

Devices driven by samples get them at their own rate, without their steady part. All others get
values from a short-time spectrum every 10 ms: for each channel the amplitude of its part of the
signal (a full-scale sine is 1) and, if the device can reproduce it, its frequency.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..frozen import frozen
from .families.family import RumbleFamily
from .high_pass import HighPass
from .profiles import Actuator, Calibration, Profile
from .report import Tones
from .resampling import Resampler

HOP = 0.010
"""Seconds between two steps: two thirds of the 15 ms by which touch may lead the picture."""

# The window rises for 32 ms, long enough to tell frequencies 25 Hz apart, and falls within 8 ms, so
# that an impact is detected at once.
_RISE, _FALL = 0.032, 0.008
# A spectrum with this share of its power so near its peak is one tone, and goes to one channel:
# split, its halves would beat.
_TONE_SHARE, _TONE_HALF_WIDTH = 0.97, 60.0
# -54 dB: what is weaker stays silent, so that a calibration's floor does not make a device hum.
_SILENT = 0.002


@frozen
class DriveStep:
    """Drive values from ``offset`` seconds after the start of the block on."""

    offset: float
    tones: Tones


def calibrated(amplitude: FloatArray, calibration: Calibration) -> FloatArray:
    """``floor + (1 - floor) min(gain a, 1)^exponent``, and 0 for the amplitude 0. amplitude: any
    shape, 0 or more."""
    driven = np.minimum(calibration.gain * amplitude, 1.0)
    curve = calibration.floor + (1.0 - calibration.floor) * driven**calibration.exponent
    return np.where(driven < _SILENT, 0.0, curve)


class SpectralDescription:
    """Amplitude and frequency per band, every ``HOP`` seconds, of signals that arrive block by
    block. hop: samples between two steps."""

    def __init__(self, rate: int, bands: list[list[tuple[float, float]]]) -> None:
        """rate: samples per second. bands: for each signal, the (low, high) limits in Hz of each of
        its channels."""
        self.hop = max(round(HOP * rate), 1)
        self._rate = rate
        rise = round(_RISE * rate)
        fall = max(round(_FALL * rate), 1)
        self._window = np.concatenate(
            [
                np.sin(0.5 * np.pi * (np.arange(rise) + 0.5) / rise) ** 2,
                np.cos(0.5 * np.pi * (np.arange(fall) + 0.5) / fall) ** 2,
            ]
        )
        self._size = 1 << (2 * len(self._window) - 1).bit_length()
        self._frequencies = np.fft.rfftfreq(self._size, 1.0 / rate)
        # Parseval: the bins' sum is the mean square under the window; a full-scale sine has 1/2.
        self._scale = 2.0 * 2.0 / (self._size * np.sum(self._window**2))
        self._masks = [
            np.array(
                [(low <= self._frequencies) & (self._frequencies < high) for low, high in limits]
            )
            for limits in bands
        ]
        self.reset()

    @property
    def pending(self) -> float:
        """Seconds of input that are not yet part of a complete step."""
        return (self._history.shape[1] - (len(self._window) - self.hop)) / self._rate

    def reset(self) -> None:
        """Reset to silence."""
        self._history = np.zeros((len(self._masks), len(self._window) - self.hop))

    def process(self, block: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """For each signal, amplitudes and frequencies [Hz], both (steps, channels). block:
        (signals, n)."""
        samples = np.concatenate([self._history, block], axis=1)
        width = len(self._window)
        count = max((samples.shape[1] - width) // self.hop + 1, 0)
        self._history = samples[:, count * self.hop :]
        if count == 0:
            return [(np.zeros((0, len(masks))),) * 2 for masks in self._masks]
        windows = np.stack(
            [samples[:, begin : begin + width] for begin in range(0, count * self.hop, self.hop)],
            axis=1,
        )
        power = self._scale * np.abs(np.fft.rfft(windows * self._window, self._size, axis=2)) ** 2
        return [
            self._describe(signal, masks) for signal, masks in zip(power, self._masks, strict=True)
        ]

    def _describe(self, power: FloatArray, masks: BoolArray) -> tuple[FloatArray, FloatArray]:
        """power: (steps, bins); masks: (channels, bins)."""
        taken = power * (masks[0] if len(masks) == 1 else masks.any(axis=0))
        peak = self._frequencies[taken.argmax(axis=1)][:, None]
        near = np.where(np.abs(self._frequencies - peak) <= _TONE_HALF_WIDTH, taken, 0.0)
        total = taken.sum(axis=1)
        is_tone = near.sum(axis=1) >= _TONE_SHARE * total
        # (steps, channels, bins): a tone goes entirely to the channel with its peak, any other
        # spectrum is divided by bins.
        shares = taken[:, None, :]
        if len(masks) > 1:
            # (steps, channels).
            holds: BoolArray = masks[:, np.searchsorted(self._frequencies, peak[:, 0])].T
            shares = np.where(
                is_tone[:, None, None], shares * holds[:, :, None], power[:, None, :] * masks
            )
        sums = shares.sum(axis=2)
        weights = np.where(is_tone[:, None, None], np.minimum(shares, near[:, None, :]), shares)
        divisor = weights.sum(axis=2)
        centroids = np.divide(
            weights @ self._frequencies, divisor, out=np.zeros_like(divisor), where=divisor > 0.0
        )
        return np.sqrt(sums), centroids


class ToneActuation:
    """Blocks of samples, one row per actuator, to steps of amplitude and frequency for a rumble
    family."""

    def __init__(self, profile: Profile, family: RumbleFamily, rate: int) -> None:
        self._actuators = profile.actuators
        self.calibrate({})
        self._rest = family.silence()
        self._has_tones = family.has_tones
        self._places = [
            [family.channels.index(channel.name) for channel in actuator.channels]
            for actuator in profile.actuators
        ]
        self._description = SpectralDescription(
            rate,
            [[channel.takes for channel in actuator.channels] for actuator in profile.actuators],
        )
        self.rate, self.hop = rate, self._description.hop

    def calibrate(self, calibrations: Mapping[str, Calibration]) -> None:
        """Use these calibrations by actuator, in place of the profile's, from the next block on."""
        self._calibrations = [
            calibrations.get(actuator.name, actuator.calibration) for actuator in self._actuators
        ]

    def process(self, block: FloatArray) -> list[DriveStep]:
        """Steps of a block, in order; silence has the frequencies at rest. block: (actuators, n).

        The first offset is below 0 if the last block ended inside a step.
        """
        start = -self._description.pending
        described = self._description.process(block)
        count = described[0][0].shape[0]
        amplitudes, frequencies = (
            np.full((count, len(values)), values)
            for values in (self._rest.amplitudes, self._rest.frequencies)
        )
        for actuator, calibration, places, (amplitude, frequency) in zip(
            self._actuators, self._calibrations, self._places, described, strict=True
        ):
            amplitudes[:, places] = calibrated(amplitude, calibration)
            if self._has_tones:
                driven = amplitudes[:, places] > 0.0
                frequencies[:, places] = np.where(
                    driven, np.clip(frequency, *actuator.band), frequencies[:, places]
                )
        tones = (
            Tones(tuple(row), tuple(hz))
            for row, hz in zip(amplitudes.tolist(), frequencies.tolist(), strict=True)
        )
        return [DriveStep(start + i * self.hop / self.rate, tone) for i, tone in enumerate(tones)]

    def reset(self) -> None:
        """Forget the samples so far."""
        self._description.reset()


class SampleActuation:
    """Blocks of samples, one row per actuator, to samples of a device's channels at its rate.
    ``delay``: by which these lag [s]."""

    def __init__(
        self, actuators: Sequence[Actuator], channels: Sequence[str], rate: int, device_rate: int
    ) -> None:
        """The actuators, each with one of these channels, and the rates of blocks and device."""
        self._actuators = actuators
        self.calibrate({})
        self._places = [channels.index(actuator.channels[0].name) for actuator in actuators]
        self._channels = len(channels)
        self._high_pass = HighPass(len(actuators), rate)
        self._resampler = Resampler(len(actuators), rate, device_rate)
        self.rate, self.delay = rate, self._resampler.delay
        self.hop = round(HOP * rate)

    def calibrate(self, calibrations: Mapping[str, Calibration]) -> None:
        """Use the gains of these calibrations by actuator, in place of the profile's, from the next
        block on."""
        self._gains = np.array(
            [
                [calibrations.get(actuator.name, actuator.calibration).gain]
                for actuator in self._actuators
            ]
        )

    def process(self, block: FloatArray) -> FloatArray:
        """(actuators, n) at the input rate -> (channels, m) at the device's. Only the calibration's
        gain applies to samples."""
        resampled = self._gains * self._resampler.process(self._high_pass.process(block))
        samples = np.zeros((self._channels, resampled.shape[1]))
        samples[self._places] = resampled
        return samples

    def reset(self) -> None:
        """Forget the samples so far."""
        self._high_pass.reset()
        self._resampler.reset()


def checked_block(block: FloatArray, actuators: int) -> FloatArray:
    """A private float64 copy of a block; raises ValueError unless it is (actuators, n) and
    finite."""
    copy = np.array(block, dtype=np.float64)
    if copy.ndim != 2 or copy.shape[0] != actuators:
        raise ValueError(f"block has the shape {copy.shape}, not ({actuators}, n)")
    if not np.isfinite(copy).all():
        raise ValueError("block has a sample that is not finite")
    return copy
