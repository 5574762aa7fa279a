"""What must hold for every drive: lengths, checksums computed another way, and order of
amplitudes."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices.families.dualsense import DUALSENSE_PCM
from haptic_tracing.core.devices.families.family import RumbleFamily, StreamFamily
from haptic_tracing.core.devices.families.registry import families
from hypothesis import given
from hypothesis import strategies as st

amplitudes = st.floats(0.0, 1.0)
sequences = st.integers(0, 15)
RUMBLE = [
    (family, transport)
    for family in families().values()
    if isinstance(family, RumbleFamily)
    for transport in family.transports
]
NAMED = {"ids": lambda value: value if isinstance(value, str) else value.name}
HERE = Path(__file__).parent
FILES = (HERE / "reports.json", *sorted(HERE.parents[1].glob("plugins/*/reports.json")))
REPORTS = {name: row for file in FILES for name, row in json.loads(file.read_text()).items()}
"""Length of a report, the places of its two motors' levels, low byte first, and their largest
value, by device and transport."""


def bitwise_crc(data):
    """CRC-32 by its definition: a shift register of the reflected polynomial, one bit at a time."""
    register = 0xFFFFFFFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    return register ^ 0xFFFFFFFF


def motors(name, transport, report):
    return tuple(
        int.from_bytes(
            bytes(report[place] for place in REPORTS[f"{name} {transport}"][side]), "little"
        )
        for side in ("left", "right")
    )


@pytest.mark.slow
@pytest.mark.parametrize(("family", "transport"), RUMBLE, **NAMED)
@given(left=amplitudes, right=amplitudes, sequence=sequences)
def test_length_is_fixed_and_sony_checksums_hold(family, transport, left, right, sequence):
    data = rumble_report(family.name, left, right, transport, sequence).data
    assert len(data) == REPORTS[f"{family.name} {transport}"]["length"]
    if family.name in ("dualsense", "dualshock4") and transport == "bt":
        assert int.from_bytes(data[-4:], "little") == bitwise_crc(b"\xa2" + data[:-4])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "transport"), [pair for pair in RUMBLE if not pair[0].has_tones], **NAMED
)
@given(one=amplitudes, other=amplitudes)
def test_more_amplitude_never_drives_less_and_sides_stay_apart(family, transport, one, other):
    low, high = sorted((one, other))
    weak, strong = (
        motors(family.name, transport, rumble_report(family.name, level, 0.0, transport).data)
        for level in (low, high)
    )
    assert weak[0] <= strong[0] and weak[1] == strong[1] == 0
    weak, strong = (
        motors(family.name, transport, rumble_report(family.name, 0.0, level, transport).data)
        for level in (low, high)
    )
    assert weak[1] <= strong[1] and weak[0] == strong[0] == 0


@pytest.mark.parametrize(
    ("family", "transport"), [pair for pair in RUMBLE if not pair[0].has_tones], **NAMED
)
def test_full_amplitude_is_the_largest_value_of_the_field(family, transport):
    full = REPORTS[f"{family.name} {transport}"]["full"]
    assert motors(family.name, transport, rumble_report(family.name, 1.0, 1.0, transport).data) == (
        full,
        full,
    )


@given(data=st.data())
def test_streams_carry_every_sample(data):
    for family in (family for family in families().values() if isinstance(family, StreamFamily)):
        shape = (2, family.frames)
        drawn = data.draw(st.binary(min_size=shape[0] * shape[1], max_size=shape[0] * shape[1]))
        samples = np.frombuffer(drawn, dtype=np.int8).clip(-127).reshape(shape)
        report = family.encode(samples, data.draw(st.integers(0, 1000))).data
        if family is DUALSENSE_PCM:
            carried = np.frombuffer(report, dtype=np.int8)[13:77].reshape(-1, 2).T
            assert int.from_bytes(report[-4:], "little") == bitwise_crc(b"\xa2" + report[:-4])
        else:
            carried = np.frombuffer(report, dtype=np.int8)[2:].reshape(2, -1)
        assert (carried == samples).all()


@pytest.mark.parametrize("level", [-0.01, 1.01, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(("family", "transport"), RUMBLE, **NAMED)
def test_amplitudes_out_of_range_are_refused(family, transport, level):
    with pytest.raises(ValueError, match=r"amplitude .* is not in \[0, 1\]"):
        rumble_report(family.name, level, 0.0, transport)
    with pytest.raises(ValueError, match=r"amplitude .* is not in \[0, 1\]"):
        rumble_report(family.name, 0.0, level, transport)


def test_wrong_names_transports_and_sequences_are_refused():
    with pytest.raises(ValueError, match="device 'gamecube' is unknown: use one of dualsense"):
        rumble_report("gamecube", 0.0, 0.0)
    with pytest.raises(ValueError, match="'usb' does not exist for xbox: use bt"):
        rumble_report("xbox", 0.0, 0.0, "usb")
    with pytest.raises(ValueError, match=r"sequence 16 is not in 0\.\.15"):
        rumble_report("dualsense", 0.0, 0.0, "bt", 16)
    with pytest.raises(ValueError, match="takes samples"):
        rumble_report("dualsense-pcm", 0.0, 0.0)
