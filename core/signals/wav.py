"""WAV files as signals (RIFF WAVE: PCM of 8 to 32 bits, IEEE float of 32 and 64, plain or WAVE_FORMAT_EXTENSIBLE)."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .interpolation import resample
from .sampled import MAX_SAMPLES, Sampled

MAX_BYTES = 1 << 30
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE


def read_wav(path: str | Path, sample_rate: float = 8000.0) -> Sampled:
    """Return the recording in a WAV file, its channels averaged, at `sample_rate` (hertz), full scale being 1.

    Raises OSError if the file cannot be read, ValueError that names the file if it is no such WAV file, longer than 4,000,000 samples at
    `sample_rate`, or has samples that are not finite.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ValueError("larger than 1 GiB")
        samples, rate = decoded_wav(path.read_bytes())
        if len(samples) * sample_rate / rate > MAX_SAMPLES:
            raise ValueError(f"longer than {MAX_SAMPLES / sample_rate:g} seconds")
        if not np.isfinite(samples).all():
            raise ValueError("has samples that are not finite")
        return Sampled(resample(samples, rate, sample_rate), sample_rate)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def decoded_wav(data: bytes) -> tuple[FloatArray, float]:
    """Return the samples, shape (n,) with n >= 1, channels averaged, and the sample rate of a WAV file's bytes.

    Raises ValueError if they are broken or of another encoding.
    """
    channels, rate = wav_channels(data)
    return np.asarray(channels.mean(axis=1)), rate


def wav_channels(data: bytes) -> tuple[FloatArray, float]:
    """Return the samples, shape (n, channels) with n >= 1, and the sample rate of a WAV file's bytes. Raises ValueError."""
    if len(data) < 12 or data[:4] != b"RIFF" or data[8:12] != b"WAVE":
        raise ValueError("not a WAV file")
    form: bytes | None = None
    place = 12
    while place + 8 <= len(data):
        name, size = data[place : place + 4], int.from_bytes(data[place + 4 : place + 8], "little")
        body = data[place + 8 : place + 8 + size]
        if name == b"fmt ":
            form = body
        if name == b"data":
            if form is None:
                raise ValueError("broken WAV file: no format before the samples")
            return _decoded(form, body)
        place += 8 + size + size % 2
    raise ValueError("broken WAV file: no samples")


def _decoded(form: bytes, body: bytes) -> tuple[FloatArray, float]:
    if len(form) < 16:
        raise ValueError("broken WAV file: format too short")
    tag, channels, rate, _, frame_size, _ = struct.unpack_from("<HHIIHH", form)
    if tag == _EXTENSIBLE and len(form) >= 26:
        tag = int.from_bytes(form[24:26], "little")
    if channels == 0 or frame_size % channels or not 1000 <= rate <= 192_000:
        raise ValueError(f"broken WAV file: {channels} channels of {frame_size} bytes at {rate} Hz")
    width = frame_size // channels
    frames = len(body) // frame_size if frame_size else 0
    if frames == 0:
        raise ValueError("WAV file without samples")
    raw = np.frombuffer(body, dtype=np.uint8, count=frames * frame_size).reshape(frames, channels, width)
    return _numbers(tag, width, raw), float(rate)


def _numbers(tag: int, width: int, raw: NDArray[np.uint8]) -> FloatArray:
    """Return little-endian samples, shape (frames, channels, width) of bytes, as numbers, shape (frames, channels)."""
    if tag == _PCM and width == 1:
        return np.asarray((raw[..., 0].astype(np.float64) - 128.0) / 128.0)
    if tag == _PCM and width in (2, 3, 4):
        # In the upper bytes of 32 bits, every width has the same sign bit and the same full scale.
        wide = np.zeros((*raw.shape[:2], 4), dtype=np.uint8)
        wide[..., 4 - width :] = raw
        return np.asarray(wide.view("<i4")[..., 0] / 2.0**31)
    if tag == _FLOAT and width in (4, 8):
        return np.asarray(raw.view(f"<f{width}")[..., 0], dtype=np.float64)
    raise ValueError(f"WAV encoding {tag} with {8 * width} bits is not supported: use PCM or float")
