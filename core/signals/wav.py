"""WAV files as signals (RIFF WAVE, RF64 and BW64: PCM of 8 to 32 bits, IEEE float of 32 and 64,
plain or WAVE_FORMAT_EXTENSIBLE)."""

from __future__ import annotations

import io
import os
import struct
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..regular_file import open_regular
from .interpolation import resample
from .sampled import MAX_SAMPLES, Sampled

MAX_BYTES = 1 << 30
LOWEST_RATE, HIGHEST_RATE = 1000, 192_000
"""Sample rates that are read [Hz]."""
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_LONGEST_FORMAT = 256
_REST_OF_GUID = bytes.fromhex("000000001000800000aa00389b71")
_UNKNOWN = 0xFFFFFFFF
"""Size of a chunk that is not known, or stands in the chunk ds64 of RF64 and BW64."""


def read_wav(path: str | Path, sample_rate: float = 8000.0) -> Sampled:
    """Return the recording in a WAV file, its channels averaged, at `sample_rate` (hertz), full
    scale being 1.

    Raises OSError if the file cannot be read, ValueError that names the file if it is no such WAV
    file, longer than 4,000,000 samples at `sample_rate`, or if it has samples that are not finite.
    """
    path = Path(path)
    try:
        with open_regular(path) as file:
            if os.fstat(file.fileno()).st_size > MAX_BYTES:
                raise ValueError("larger than 1 GiB")
            wav = WavFile(file)
            if wav.count * sample_rate / wav.rate > MAX_SAMPLES:
                raise ValueError(f"longer than {MAX_SAMPLES / sample_rate:g} seconds")
            samples = wav.read(0, wav.count).mean(axis=1)
        if not np.isfinite(samples).all():
            raise ValueError("has samples that are not finite")
        return Sampled(resample(samples, wav.rate, sample_rate), sample_rate)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


class WavFile:
    """The samples of a WAV file, read on demand.

    file: open for reading, seekable; it is read again by every call of `read`. Raises ValueError if
    it is broken or of another encoding. Attributes: ``channels``, ``count`` (samples of each
    channel, at least 1) and ``rate`` (hertz).
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        head = file.read(12)
        if head[:4] not in (b"RIFF", b"RF64", b"BW64") or head[8:12] != b"WAVE":
            raise ValueError("not a WAV file")
        form: bytes | None = None
        long_size = 0
        while len(chunk := file.read(8)) == 8:
            name = chunk[:4]
            size = int.from_bytes(chunk[4:], "little")
            if name == b"data":
                if form is None:
                    raise ValueError("broken WAV file: no format before the samples")
                self._start = file.tell()
                left = file.seek(0, io.SEEK_END) - self._start
                size = long_size if size == _UNKNOWN else size
                # Programs that write into a stream leave 0: the samples reach to the end.
                self._set_format(form, min(size or left, left))
                return
            end = file.tell() + size + size % 2
            if name == b"fmt ":
                form = file.read(min(size, _LONGEST_FORMAT))
            elif name == b"ds64":
                long_size = int.from_bytes(file.read(16)[8:], "little")
            file.seek(end)
        raise ValueError("broken WAV file: no samples")

    def _set_format(self, form: bytes, size: int) -> None:
        if len(form) < 16:
            raise ValueError("broken WAV file: format too short")
        tag, channels, rate, _, frame_size, _ = struct.unpack_from("<HHIIHH", form)
        if tag == _EXTENSIBLE and len(form) >= 40:
            if form[26:40] != _REST_OF_GUID:
                raise ValueError("WAV encoding of another vendor: use PCM or float")
            tag = int.from_bytes(form[24:26], "little")
        if tag not in (_PCM, _FLOAT):
            raise ValueError(f"compressed WAV file (encoding {tag}): save it as PCM or float")
        if channels == 0 or frame_size % channels:
            raise ValueError(f"broken WAV file: {channels} channels of {frame_size} bytes")
        if not LOWEST_RATE <= rate <= HIGHEST_RATE:
            raise ValueError(
                f"WAV file at {rate} Hz: only {LOWEST_RATE} to {HIGHEST_RATE} Hz are read"
            )
        self.channels = channels
        self.rate = float(rate)
        self.count = size // frame_size if frame_size else 0
        self._tag = tag
        self._width = frame_size // channels
        if self.count == 0:
            raise ValueError("WAV file without samples")
        _numbers(tag, self._width, np.zeros((1, 1, self._width), dtype=np.uint8))

    def read(self, first: int, last: int) -> FloatArray:
        """Return the samples from index ``first`` to before ``last``, shape (last - first,
        channels), full scale being 1."""
        frame_size = self.channels * self._width
        self._file.seek(self._start + first * frame_size)
        raw = np.frombuffer(self._file.read((last - first) * frame_size), dtype=np.uint8)
        return _numbers(self._tag, self._width, raw.reshape(-1, self.channels, self._width))


def _numbers(tag: int, width: int, raw: NDArray[np.uint8]) -> FloatArray:
    """Return little-endian samples, shape (frames, channels, width) of bytes, as numbers, shape
    (frames, channels)."""
    if tag == _PCM and width == 1:
        return (raw[..., 0].astype(np.float64) - 128.0) / 128.0
    if tag == _PCM and width in (2, 3, 4):
        # In the upper bytes of 32 bits, every width has the same sign bit and the same full scale.
        wide = np.zeros((*raw.shape[:2], 4), dtype=np.uint8)
        wide[..., 4 - width :] = raw
        return wide.view("<i4")[..., 0] / 2.0**31
    if tag == _FLOAT and width in (4, 8):
        return np.asarray(raw.view(f"<f{width}")[..., 0], dtype=np.float64)
    raise ValueError(f"WAV samples of {8 * width} bits are not supported: use PCM or float")
