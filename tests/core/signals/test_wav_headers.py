"""Headers of WAV files that recorders and streams write, laid out by hand as EBU Tech 3306 (RF64),
ITU-R BS.2088 (BW64) and the RIFF specification say."""

import io
import struct

import numpy as np
import pytest
from haptic_tracing.core.signals.wav import WavFile

SAMPLES = np.arange(-400, 400, dtype="<i2")


def chunk(name, body, size=None):
    return name + struct.pack("<I", len(body) if size is None else size) + body


def form(rate=8000, tag=1, extra=b""):
    fields = struct.pack("<HHIIHH", tag, 1, rate, 2 * rate, 2, 16)
    return chunk(b"fmt ", fields + (struct.pack("<H", len(extra)) + extra if extra else b""))


def header(*chunks, name=b"RIFF", size=None):
    body = b"WAVE" + b"".join(chunks)
    return io.BytesIO(name + struct.pack("<I", len(body) if size is None else size) + body)


@pytest.mark.parametrize("size", [0, 0xFFFFFFFF])
def test_unknown_sizes_reach_to_the_end(size):
    wav = WavFile(header(form(), chunk(b"data", SAMPLES.tobytes(), size), size=size))
    assert wav.count == 800 and (wav.read(0, 800)[:, 0] * 32768 == SAMPLES).all()


@pytest.mark.parametrize("name", [b"RF64", b"BW64"])
def test_long_files_have_their_size_in_a_chunk_of_its_own(name):
    sizes = chunk(b"ds64", struct.pack("<QQQI", 0, 1600, 800, 0))
    data = chunk(b"data", SAMPLES.tobytes(), 0xFFFFFFFF)
    after = chunk(b"LIST", b"INFO" * 5)
    wav = WavFile(header(sizes, form(), data, after, name=name, size=0xFFFFFFFF))
    assert wav.count == 800 and (wav.read(0, 800)[:, 0] * 32768 == SAMPLES).all()


@pytest.mark.parametrize("rate", [1, 768_000])
def test_other_sample_rates_are_named(rate):
    with pytest.raises(ValueError, match=f"at {rate} Hz: only 1000 to 192000 Hz"):
        WavFile(header(form(rate), chunk(b"data", SAMPLES.tobytes())))


def test_encodings_of_other_vendors_are_refused():
    extra = struct.pack("<HI", 16, 4) + b"\x01\0" + b"x" * 14
    with pytest.raises(ValueError, match="another vendor"):
        WavFile(header(form(tag=0xFFFE, extra=extra), chunk(b"data", SAMPLES.tobytes())))
