"""Reading WAV files that the standard library and SciPy wrote, and files that are broken."""

from __future__ import annotations

import io
import struct
import wave
from pathlib import Path

import numpy as np
import pytest
import scipy.io.wavfile
from haptic_tracing.core.signals import read_wav
from haptic_tracing.core.signals.wav import WavFile
from hypothesis import given, settings
from hypothesis import strategies as st

RATE = 8000


def pcm(
    path: Path, width: int, channels: int = 1, rate: int = RATE, count: int = 400
) -> np.ndarray:
    """Write random PCM by the standard library, return its numbers as floats, shape (count,
    channels)."""
    limit = 2 ** (8 * width - 1)
    numbers = np.random.default_rng(width).integers(-limit, limit, (count, channels))
    shifted = numbers + 128 if width == 1 else numbers
    data = b"".join(
        int(value).to_bytes(width, "little", signed=width > 1) for value in shifted.ravel()
    )
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(data)
    return numbers / limit


@pytest.mark.parametrize("width", [1, 2, 3, 4])
@pytest.mark.parametrize("channels", [1, 2, 6])
def test_pcm(tmp_path: Path, width: int, channels: int) -> None:
    numbers = pcm(tmp_path / "a.wav", width, channels)
    signal = read_wav(tmp_path / "a.wav")
    assert np.abs(signal.samples - numbers.mean(axis=1)).max() < 1e-12
    assert signal.rate == RATE


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int16, np.int32, np.uint8])
def test_what_scipy_writes(tmp_path: Path, dtype: type[np.generic]) -> None:
    values = np.random.default_rng(0).uniform(-0.9, 0.9, (300, 2))
    full = {np.int16: 2**15, np.int32: 2**31, np.uint8: 2**7}.get(dtype, 1)  # type: ignore[call-overload]
    scipy.io.wavfile.write(
        tmp_path / "a.wav", RATE, (values * full + (128 if dtype is np.uint8 else 0)).astype(dtype)
    )
    samples = read_wav(tmp_path / "a.wav").samples
    assert np.abs(samples - values.mean(axis=1)).max() < 1.5 / min(full, 1e7) if full > 1 else 1e-6


def test_other_rates_are_resampled(tmp_path: Path) -> None:
    times = np.arange(44_100) / 44_100
    scipy.io.wavfile.write(
        tmp_path / "a.wav", 44_100, (0.5 * np.sin(2 * np.pi * 200 * times)).astype(np.float32)
    )
    signal = read_wav(tmp_path / "a.wav")
    expected = 0.5 * np.sin(2 * np.pi * 200 * np.arange(8000) / 8000)
    assert np.abs(signal.sample(0, 8000, 8000.0) - expected)[100:-100].max() < 1e-4
    assert signal.duration == pytest.approx(1.0)


def riff(*chunks: tuple[bytes, bytes]) -> bytes:
    body = b"".join(
        name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)
        for name, data in chunks
    )
    return b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WAVE" + body


def decoded_wav(data: bytes) -> tuple[np.ndarray, float]:
    wav = WavFile(io.BytesIO(data))
    return wav.read(0, wav.count).mean(axis=1), wav.rate


FORMAT = struct.pack("<HHIIHH", 1, 1, 8000, 16_000, 2, 16)
EXTENSIBLE = struct.pack(
    "<HHIIHHHHIH", 0xFFFE, 1, 8000, 32_000, 4, 32, 22, 32, 0, 3
) + bytes.fromhex("000000001000800000aa00389b71")


def test_extensible_and_unknown_chunks() -> None:
    values = np.array([0.25, -0.5, 1.0], dtype="<f4")
    samples, rate = decoded_wav(
        riff(
            (b"LIST", b"odd"),
            (b"fmt ", EXTENSIBLE),
            (b"fact", b"\0\0\0\0"),
            (b"data", values.tobytes()),
        )
    )
    assert samples.tolist() == [0.25, -0.5, 1.0]
    assert rate == 8000.0


def test_a_recording_that_was_cut_off_is_read_as_far_as_it_goes() -> None:
    whole = riff((b"fmt ", FORMAT), (b"data", np.arange(100, dtype="<i2").tobytes()))
    assert len(decoded_wav(whole[:-21])[0]) == 89


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "not a WAV file"),
        (b"OggS" + b"\0" * 100, "not a WAV file"),
        (b"RIFF\0\0\0\0AVI " + b"\0" * 100, "not a WAV file"),
        (riff((b"fmt ", FORMAT)), "no samples"),
        (riff((b"data", b"\0\0")), "no format"),
        (riff((b"fmt ", FORMAT[:10]), (b"data", b"\0\0")), "format too short"),
        (riff((b"fmt ", FORMAT), (b"data", b"")), "without samples"),
        (
            riff((b"fmt ", struct.pack("<HHIIHH", 1, 0, 8000, 0, 0, 16)), (b"data", b"\0\0")),
            "0 channels",
        ),
        (riff((b"fmt ", struct.pack("<HHIIHH", 1, 1, 0, 0, 2, 16)), (b"data", b"\0\0")), "at 0 Hz"),
        (
            riff((b"fmt ", struct.pack("<HHIIHH", 1, 1, 8000, 0, 0, 16)), (b"data", b"\0\0")),
            "without samples",
        ),
        (
            riff((b"fmt ", struct.pack("<HHIIHH", 85, 1, 8000, 0, 1, 8)), (b"data", b"\0\0")),
            "compressed WAV file .encoding 85.: save it as PCM or float",
        ),
        (  # ADPCM, whose blocks need not be multiples of the channels
            riff((b"fmt ", struct.pack("<HHIIHH", 2, 2, 8000, 0, 257, 4)), (b"data", bytes(257))),
            "compressed WAV file .encoding 2.",
        ),
        (
            riff((b"fmt ", struct.pack("<HHIIHH", 3, 1, 8000, 0, 2, 16)), (b"data", b"\0\0")),
            "of 16 bits are not supported",
        ),
        (
            riff((b"fmt ", EXTENSIBLE), (b"data", np.array([np.nan, 1], dtype="<f4").tobytes())),
            "not finite",
        ),
        (
            riff((b"fmt ", EXTENSIBLE), (b"data", np.array([3e38], dtype="<f4").tobytes())),
            "finite and within",
        ),
    ],
)
def test_broken_files_have_a_clear_message(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "broken.wav"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=message) as caught:
        read_wav(path)
    assert str(caught.value).startswith(str(path))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"none\.wav"):
        read_wav(tmp_path / "none.wav")


def test_a_recording_of_hours_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.wav"
    path.write_bytes(
        riff((b"fmt ", struct.pack("<HHIIHH", 1, 1, 1000, 0, 1, 8)), (b"data", bytes(600_000)))
    )
    with pytest.raises(ValueError, match="longer than 500 seconds"):
        read_wav(path)


@given(st.binary(max_size=200), st.integers(0, 60), st.integers(0, 100))
@settings(deadline=None, max_examples=400)
def test_any_bytes_give_samples_or_a_value_error(noise: bytes, place: int, cut: int) -> None:
    good = riff((b"fmt ", EXTENSIBLE), (b"data", np.linspace(-1, 1, 8, dtype="<f4").tobytes()))
    for data in (
        noise,
        b"RIFF\0\0\0\0WAVE" + noise,
        (good[:place] + noise + good[place + len(noise) :])[:-cut],
    ):
        try:
            samples, _ = decoded_wav(data)
        except ValueError:
            continue
        assert samples.ndim == 1
        assert len(samples) >= 1
