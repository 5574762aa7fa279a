"""The corpus of files that readers were fuzzed with: good ones read; bad ones, and what any of them
becomes when bytes are changed, give one clear error, or are read as something finite.

A file that ever broke a reader comes here, called ``bad-...``, or ``good-...`` where it should have
been read.
"""

from pathlib import Path

import numpy as np
import pytest
from carriers import values_at
from haptic_tracing.core.formats import haptic_scene, registry
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.io.error import FormatError
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

CORPUS = Path(__file__).with_name("corpus")
FILES = sorted(
    p.name
    for p in CORPUS.iterdir()
    if p.name.endswith((".json.gz", *catalogue.readers(), ".json")) and ".wav." not in p.name
)
GOOD = [name for name in FILES if name.startswith("good")]
BAD = [name for name in FILES if name.startswith("bad")]


def read(path):
    return (
        haptic_scene.read_export(path)
        if path.name.endswith((".json", ".json.gz"))
        else registry.read(path)
    )


def finite(result):
    """What was read holds nothing that is not finite."""
    for channel in getattr(result, "channels", ()):
        assert np.isfinite(channel.duration)
        for carrier in getattr(channel, "carriers", ()):
            assert np.isfinite(values_at(carrier, np.array([carrier.start, carrier.end]))).all()
        assert np.isfinite(channel.samples).all()


def test_there_are_files_of_every_kind():
    for suffix in (*catalogue.readers(), ".json", ".json.gz"):
        assert any(name.endswith(suffix) for name in GOOD) and any(
            name.endswith(suffix) for name in BAD
        ), suffix


@pytest.mark.parametrize("name", GOOD)
def test_good_files_read(name):
    result = read(CORPUS / name)
    finite(result)
    assert getattr(result, "channels", None) or result.scene.objects


@pytest.mark.parametrize("name", BAD)
def test_bad_files_give_one_clear_error(name):
    with pytest.raises(FormatError) as caught:
        read(CORPUS / name)
    text = str(caught.value)
    assert (
        text.startswith(f"{CORPUS / name}: ")
        and text.isprintable()
        and caught.value.reason
        and len(text) < 500
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_changed_bytes(tmp_path, name, data):
    content = bytearray((CORPUS / name).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        match data.draw(st.sampled_from(["set", "cut", "insert", "copy"])):
            case "set":
                content[place] = data.draw(st.integers(0, 255))
            case "cut":
                del content[place : place + data.draw(st.integers(1, 20))]
            case "insert":
                content[place:place] = data.draw(
                    st.sampled_from(
                        [b"0", b"-", b"e9", b"[", b"{", b'"', b",", b"\xff", b"\x00" * 4]
                    )
                )
            case "copy":
                content[place:place] = content[place : place + 30]
        if not content:
            break
    path = tmp_path / name
    path.write_bytes(bytes(content))
    try:
        finite(read(path))
    except FormatError as error:
        assert str(error).startswith(f"{path}: ") and str(error).isprintable()
    path.unlink()  # what is written over has to reach the disk first, what is removed never does
