"""Decoding wavelet bands of MPEG haptics: arithmetic decoding, SPIHT and the inverse wavelet
transform.

The bits of a block are coded by an adaptive binary arithmetic code with seven contexts. They
describe integer wavelet coefficients by set partitioning in hierarchical trees (Said and Pearlman,
1996) in one dimension, bit plane by bit plane. The transform is that of the biorthogonal 9/7
filters (Cohen, Daubechies and Feauveau, 1992) with symmetric extension.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Sequence

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.frozen import frozen
from ...core.signals.interpolation import resample

SMALLEST = 8
LARGEST = 2**14
"""Samples of a block, a power of two."""

_SYNTHESIS_LOW = np.array(
    [
        -0.064538882628938,
        -0.040689417609559,
        0.418092273222212,
        0.788485616405665,
        0.418092273222212,
        -0.040689417609559,
        -0.064538882628938,
    ]
)
_SYNTHESIS_HIGH = np.array(
    [
        -0.037828455506995,
        -0.02384946501938,
        0.110624404418423,
        0.377402855612654,
        -0.852698679009404,
        0.377402855612654,
        0.110624404418423,
        -0.02384946501938,
        -0.037828455506995,
    ]
)

_CONTEXTS = 7
_HEAD, _SIGN, _SINGLE, _CHILDREN, _CHILD, _GRANDCHILDREN, _REFINEMENT = range(_CONTEXTS)


@frozen(eq=False)
class WaveletBand:
    """A decoded band: ``samples`` (n,) from time 0 at ``rate`` hertz."""

    samples: FloatArray
    rate: float

    @property
    def end(self) -> float:
        """Seconds."""
        return len(self.samples) / self.rate

    @classmethod
    def decoded(
        cls,
        blocks: Sequence[tuple[float, str]],
        seconds: float,
        rate: int,
        gain: float,
        take: Callable[[float], None],
    ) -> WaveletBand:
        """Decode a band. Raises ValueError.

        Args:
            blocks: time [s], and bits in base64.
            seconds: duration of each block.
            rate: samples per second.
            gain: of the band.
            take: is called with the number of bytes that the samples need before they are
                allocated.
        """
        size = round(seconds * rate)
        if not SMALLEST <= size <= LARGEST or size & (size - 1):
            raise ValueError(
                f"a wavelet block must have a power of 2 from {SMALLEST} to {LARGEST} samples, "
                f"not {seconds * rate:g}"
            )
        streams = [(round(time * rate), _bits(text)) for time, text in blocks]
        count = max((first for first, _ in streams), default=-size) + size
        take(8 * count)
        samples = np.zeros(count)
        for first, bits in streams:
            if len(bits):
                samples[first : first + size] += gain * decoded_block(bits, size)
        return cls(samples, float(rate))

    @staticmethod
    def summed(
        bands: Sequence[WaveletBand], take: Callable[[float], None]
    ) -> tuple[FloatArray, float]:
        """The sum of bands, and its sample rate, the highest of the bands'. take: is called with
        the number of bytes that the sum needs before they are allocated."""
        rate = max(band.rate for band in bands)
        for band in bands:
            take(16 * band.end * rate)
        parts = [resample(band.samples, band.rate, rate) for band in bands]
        result = np.zeros(max(map(len, parts)))
        for part in parts:
            result[: len(part)] += part
        return result, rate


def _bits(text: str) -> bytes:
    """The bits of a base64 text without padding, one per byte. Raises ValueError."""
    try:
        data = (
            base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
            if len(text) % 4 != 1
            else base64.b64decode(text + "A==")
        )
    except ValueError:
        raise ValueError("wavelet_stream is not base64") from None
    return np.unpackbits(np.frombuffer(data, dtype=np.uint8)).tobytes()


def decoded_block(bits: bytes, size: int) -> FloatArray:
    """The samples (size,) of a block from its coded bits, one per byte."""
    read = _arithmetic_decoder(bits)
    planes = sum(read(_HEAD) << k for k in range(4))
    is_large = read(_HEAD)
    value = sum(read(_HEAD) << k for k in range(7))
    largest = value / 8 + 1 if is_large else value / 128
    return _inverse_transform(_coefficients(read, planes, size) * (largest / 2**planes))


def _arithmetic_decoder(bits: bytes) -> Callable[[int], int]:
    """A function that returns the next symbol, 0 or 1, in a context. Beyond the end the coded bits
    are 0."""
    zeros = [8] * _CONTEXTS
    total = [16] * _CONTEXTS
    low, high, position = 0, 1024, 10
    code = (
        int.from_bytes(
            np.packbits(np.frombuffer(bits[:10].ljust(16, b"\0"), dtype=np.uint8)).tobytes(), "big"
        )
        >> 6
    )
    count = len(bits)

    def read(context: int) -> int:
        nonlocal low, high, code, position
        width = high - low
        split = width * ((2048 * zeros[context] + total[context]) // (2 * total[context])) // 1024
        split = low + min(max(split, 1), width - 1)
        total[context] += 1
        if code < split:
            symbol, high = 0, split
            zeros[context] += 1
        else:
            symbol, low = 1, split
        while True:
            if high <= 512:
                offset = 0
            elif low >= 512:
                offset = 512
            elif low >= 256 and high <= 768:
                offset = 256
            else:
                return symbol
            low = (low - offset) << 1
            high = (high - offset) << 1
            code = ((code - offset) << 1) + (bits[position] if position < count else 0)
            position += 1

    return read


def _coefficients(read: Callable[[int], int], planes: int, size: int) -> IntArray:
    """The wavelet coefficients (size,) by set partitioning, from bit plane ``planes`` down to 0."""
    values = [0] * size
    single = list(range(8))
    sets = [(root, False) for root in range(4, 8) if 2 * root < size]
    found: list[int] = []

    def begins(index: int, context: int, step: int) -> bool:
        """Whether the coefficient has its first bit in this plane, and so its sign."""
        is_set = bool(read(context))
        if is_set:
            values[index] = step if read(_SIGN) else -step
            found.append(index)
        return is_set

    for plane in range(planes, -1, -1):
        step = 1 << plane
        known = len(found)
        single = [index for index in single if not begins(index, _SINGLE, step)]
        waiting: list[tuple[int, bool]] = []
        for root, beyond_children in sets:  # grows while it is walked
            if not read(_GRANDCHILDREN if beyond_children else _CHILDREN):
                waiting.append((root, beyond_children))
                continue
            if beyond_children:
                sets += [(2 * root, False), (2 * root + 1, False)]
                continue
            single += [
                index for index in (2 * root, 2 * root + 1) if not begins(index, _CHILD, step)
            ]
            if 4 * root + 3 < size:
                sets.append((root, True))
        sets = waiting
        for index in found[:known]:
            if read(_REFINEMENT):
                values[index] += step if values[index] > 0 else -step
    return np.array(values, dtype=np.int64)


def _inverse_transform(coefficients: FloatArray) -> FloatArray:
    """The signal of a wavelet transform whose lowest band has 4 coefficients."""
    signal = coefficients.astype(np.float64)
    length = 2 * 4
    for _ in range(round(math.log2(len(signal) / 4))):
        low = np.zeros(length)
        high = np.zeros(length)
        low[::2] = signal[: length // 2]
        high[1::2] = signal[length // 2 : length]
        signal[:length] = _convolved(low, _SYNTHESIS_LOW) + _convolved(high, _SYNTHESIS_HIGH)
        length *= 2
    return signal


def _convolved(signal: FloatArray, kernel: FloatArray) -> FloatArray:
    """Convolution with an odd kernel; the signal is mirrored at its first and last sample."""
    return np.convolve(np.pad(signal, len(kernel) // 2, mode="reflect"), kernel, "valid")
